"""Mutated operators: gold operators with other literals, variables, connectives and brackets."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from typing import TypeAlias

from differential.mutations import Dice, rearranged, slightly_corrupted

Tree: TypeAlias = "str | list[Tree]"
"""A word, or a list in brackets."""

ODD_LITERALS = (
    "()",
    "(not ())",
    "(and)",
    "(or)",
    "x",
    "((on ?x))",
    "(flies ?x)",
    "(on ?x (off ?y))",
    "( (on ?x) (off ?x) )",
)
ODD_WORDS = ("?x", "?obj", "?char", "bathroom", "and", "or", "not", "when", "on", "?obj1", "AND", "exists")
SECTIONS = (":parameters", ":precondition", ":effect")
ODD_TEXTS = (
    "",
    "(:action)",
    "(:action walk)",
    "(:action walk :parameters () :precondition () :effect ())",
    "(:action grab :parameters (?c) :effect (and) :precondition (and))",
    "; nothing",
    "none",
)
_TOKEN = re.compile(r"[()]|[^()\s]+")


def operators(dice: Dice, gold: Sequence[str], others: Sequence[str]) -> str:
    """Return an answer of mutated operators. ``others`` are gold operators of other tasks as PDDL text."""
    parts = rearranged(dice, list(gold), lambda: dice.one(others), dice.one((0, 0, 1)))
    texts = [_operator(dice, part) for part in parts]
    if dice.chance(0.05):
        texts.insert(dice.below(len(texts) + 1), dice.one(ODD_TEXTS))
    return slightly_corrupted(dice, _written(dice, dice.one(("\n", " ", "", "\n\n")).join(texts)), 0.15)


def _written(dice: Dice, text: str) -> str:
    match dice.below(12):
        case 0:
            return text
        case 1:
            return text.replace("\n", " ; then\n")
        case 2:
            return json.dumps({"output": text.replace("\n", " ; then\n")})
        case 3:
            return json.dumps(
                dice.one(
                    ({"output": [text]}, {"output": None}, {"Output": text}, [text], text, {"output": 7})
                )
            )
        case 4:
            return json.dumps({"output": f"(define (domain d) {text})"})
        case _:
            return json.dumps({"output": text}, ensure_ascii=dice.chance(0.5))


def _operator(dice: Dice, text: str) -> str:
    tree = _read(text)
    if not isinstance(tree, list):
        return text
    for _ in range(dice.few(dice.one((0.3, 1, 3)))):
        section = dice.one(SECTIONS[1:])
        if section not in tree:
            break
        place = tree.index(section) + 1
        tree[place] = _changed(dice, tree[place])
    if dice.chance(0.06):
        tree = _odd_operator(dice, tree)
    return slightly_corrupted(dice, _print(tree), 0.02)


def _odd_operator(dice: Dice, tree: list[Tree]) -> list[Tree]:
    """Return an operator without a section, with reordered sections, or with another name."""
    head, sections = tree[:2], [tree[i : i + 2] for i in range(2, len(tree), 2)]
    match dice.below(4):
        case 0 if sections:
            del sections[dice.below(len(sections))]
        case 1:
            sections = dice.shuffled(sections)
        case 2:
            head[1:] = [dice.one(("slice-x", "Walk", "fly", "walk_towards", "grab?", "put_on 2"))]
        case _:
            sections = [*sections, *sections[-1:]]
    return [*head, *(part for section in sections for part in section)]


def _changed(dice: Dice, tree: Tree) -> Tree:
    """Return a condition or effect with one change somewhere in it."""
    places = list(_lists(tree))
    if not places:
        return _read(dice.one(ODD_LITERALS))
    if dice.chance(0.08):
        variables = ("?obj", "?char", "?obj1", "?obj2", "?x")
        return _renamed(tree, dice.one(variables), dice.one(("?thing", "?o", "?obj1", "?c")))
    target = dice.one(places)
    literals = [each for each in places if each and isinstance(each[0], str)]
    target[:] = dice.one(_CHANGES)(dice, _copied(target), dice.one(literals or [[]]))
    return tree


def _without_a_part(dice: Dice, parts: list[Tree], other: list[Tree]) -> list[Tree]:
    place = 1 + dice.below(len(parts) - 1)
    return parts[:place] + parts[place + 1 :]


def _with_another_part(dice: Dice, parts: list[Tree], other: list[Tree]) -> list[Tree]:
    return [*parts, _copied(other)]


def _with_an_odd_part(dice: Dice, parts: list[Tree], other: list[Tree]) -> list[Tree]:
    place = dice.below(len(parts) + 1)
    return [*parts[:place], _read(dice.one(ODD_LITERALS)), *parts[place:]]


def _inside_another(dice: Dice, parts: list[Tree], other: list[Tree]) -> list[Tree]:
    outer: tuple[list[Tree], ...] = (
        ["not", parts],
        ["and", parts],
        ["or", parts],
        ["and", parts, _copied(parts)],
        ["or", parts, _copied(other)],
        ["exists", ["?x", "-", "object"], parts],
        ["forall", ["?x", "-", "object"], parts],
        ["when", _copied(other), parts],
        [parts],
    )
    return dice.one(outer)


def _in_another_order(dice: Dice, parts: list[Tree], other: list[Tree]) -> list[Tree]:
    return [*parts[:1], *dice.shuffled(parts[1:])]


def _with_another_word(dice: Dice, parts: list[Tree], other: list[Tree]) -> list[Tree]:
    place = dice.below(len(parts))
    return [*parts[:place], dice.one(ODD_WORDS), *parts[place + 1 :]]


def _twice(dice: Dice, parts: list[Tree], other: list[Tree]) -> list[Tree]:
    return [*parts, *_copied(parts[1:])]


def _opened(dice: Dice, parts: list[Tree], other: list[Tree]) -> list[Tree]:
    """Return one of an expression's parts in its place, such as an atom without its ``not``."""
    inner = [part for part in parts if isinstance(part, list)]
    return dice.one(inner) if inner else parts


_CHANGES = (
    _without_a_part,
    _with_another_part,
    _with_an_odd_part,
    _inside_another,
    _inside_another,
    _in_another_order,
    _with_another_word,
    _twice,
    _opened,
)


def _lists(tree: Tree) -> Iterator[list[Tree]]:
    if isinstance(tree, list):
        yield tree
        for part in tree:
            yield from _lists(part)


def _copied(parts: list[Tree]) -> list[Tree]:
    return [_copied(part) if isinstance(part, list) else part for part in parts]


def _renamed(tree: Tree, old: str, new: str) -> Tree:
    if isinstance(tree, list):
        return [_renamed(part, old, new) for part in tree]
    return new if tree == old else tree


def _read(text: str) -> Tree:
    """Return the first word or list of a text. A list that is not closed ends with the text."""
    stack: list[list[Tree]] = [[]]
    for token in _TOKEN.findall(text):
        if token == "(":  # noqa: S105 - a bracket
            stack.append([])
        elif token != ")":  # noqa: S105
            stack[-1].append(token)
        elif len(stack) > 1:
            closed = stack.pop()
            stack[-1].append(closed)
    return stack[0][0] if stack[0] else ""


def _print(tree: Tree) -> str:
    return f"({' '.join(map(_print, tree))})" if isinstance(tree, list) else tree
