"""Shorten the lists and rules in our prompts. Every function takes a text and returns a shorter text.

Only the form of lines matters, so prompts in any wording can be shortened. Lines of unknown form stay
unchanged. `eai.tasks.short_lists` explains lines such as ``inside(*, jar): nut, key``. Shortened texts also
have these forms:

* ``p(*): all`` and ``p(*): all but a`` state ``p`` of all listed objects, or of all but ``a``;
* ``p(a, b) both ways`` also states ``p(b, a)``;
* in a list of objects, an object's kind follows in brackets. An object without brackets has the kind that its
  name states, without the number.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from itertools import groupby, takewhile

from eai.base.grouping import group_pairs
from eai.tasks.rules import explain_rule_notation
from eai.tasks.short_lists import write_similar_facts_on_one_line
from eai.world.state import Fact

RULES = "rules"
"""Key of a benchmark's own short rules in `Notation.short_texts`, used instead of `shorten_rules`."""

_OBJECT = re.compile(r"(\S+) \[([^\]]*)\]: (.+)")
_FACT = re.compile(r"([^\s()]+)\(([^()]+)\)")
_HEAD = re.compile(r"([^\s()]+)(\([^()]*\))")
_IS_A = re.compile(r"is_a\((\S+), (\S+)\)")
_NUMBER = re.compile(r"[._-]?\d+$")
_COMMA = re.compile(r", (?![^()]*\))")

_BEFORE_REASONS = ("impossible where", "not yet possible while", "needless where")
_SIGN_OF_CHANGE = {"becomes true": "", "becomes false": "not "}

_MIN_HOLDERS = 3
"""Minimum number of objects that must have a property so that one line states it of ``all`` objects."""

_SIGNS = (
    (" -> ", "NAME(parameter:kind): conditions -> changes, in this order, no others; there \"not p\" makes p"
    " false."),
    (" [", "[c]: needless unless c."),
    ("{", "Conditions before {} are read before the action."),
    ("*", "* is any object."),
    ("first ", "\"first\": in the order of the objects."),
    ("is_a(", "is_a(x, k): x is of kind k."),
    (" or ", "\"and\" binds before \"or\", \"or\" before \"implies\"."),
)  # fmt: skip
"""Pairs: a sign of the short notation for rules of actions, and a text that explains the sign."""


_LIST_SIGNS = (
    ("(*, ", "p(*, c): a, b is p(a, c) and p(b, c)."),
    (", *)", "p(a, *): b, c is p(a, b) and p(a, c)."),
    ("(*)", "p(*): a, b is p(a) and p(b)."),
    (" both ways", '"both ways" adds p(b, a) to p(a, b).'),
    ("..", "a_2..4 is a_2, a_3, a_4."),
    ("(*): all", '"all" is all listed objects.'),
)
"""Pairs of a sign in short lists of facts, such as ``(*)``, and a text that explains the sign."""


def explain_symbols_in_short_fact_list(fact_list: str) -> str:
    """Return explanations of the signs (such as ``*``) that occur in a short list of facts, as one text.

    A space precedes each explanation.
    """
    return "".join([f" {words}" for sign, words in _LIST_SIGNS if sign in fact_list])


def shorten_predicate_list(text: str) -> str:
    """Return a list of predicates in short form: one line for all predicates with equal parameters."""
    lines = text.splitlines()
    heads = [_HEAD.fullmatch(line) for line in lines]
    if not all(heads):
        return text
    names = group_pairs((head[2], head[1]) for head in heads if head)
    return "\n".join([f"{parameters}: {', '.join(alike)}" for parameters, alike in names.items()])


def merge_lines_of_similar_objects(
    object_lines: str, join_names: Callable[[list[str]], str] = ", ".join
) -> str:
    """Return a list of objects in short form: one line for all objects with equal kinds and properties.

    Args:
        object_lines: the list, with one object a line.
        join_names: returns some names as one text.
    """
    groups: dict[str, list[str]] = {}
    others = []
    for line in object_lines.splitlines():
        described = _OBJECT.fullmatch(line)
        if described is None:
            others.append(line)
            continue
        name, kind, properties = described.groups()
        shown = "" if _NUMBER.sub("", name) == kind else f" [{kind}]"
        groups.setdefault(shown + ("" if properties == "-" else f": {properties}"), []).append(name)
    return "\n".join([*[f"{join_names(names)}{about}" for about, names in groups.items()], *others])


def merge_lines_of_similar_facts(fact_lines: str, object_lines: str) -> str:
    """Return a list of facts in short form: similar facts share a line.

    Args:
        fact_lines: the list, with one fact a line.
        object_lines: the list of all objects, one a line. In the result, the word ``all`` stands for these
            objects.
    """
    listed = [line[1] for line in map(_OBJECT.fullmatch, object_lines.splitlines()) if line]
    lines: list[str] = []
    for predicate, run in groupby(fact_lines.splitlines(), _find_predicate_of_fact_line):
        facts = list(run)
        lines += facts if predicate is None else _merge_fact_lines_of_predicate(predicate, facts, listed)
    return "\n".join(lines)


def _find_predicate_of_fact_line(line: str) -> str | None:
    fact = _FACT.fullmatch(line)
    return None if fact is None else fact[1]


def _merge_fact_lines_of_predicate(
    predicate: str, fact_lines: Sequence[str], listed_objects: Sequence[str]
) -> Iterator[str]:
    """Yield lines that state the facts of one predicate as short lists."""
    rows = dict.fromkeys([tuple(line[len(predicate) + 1 : -1].split(", ")) for line in fact_lines])
    others = [name for name in listed_objects if (name,) not in rows]
    is_about_listed = rows.keys() <= {(name,) for name in listed_objects}
    if is_about_listed and len(rows) >= _MIN_HOLDERS and 2 * len(others) < len(rows):
        yield f"{predicate}(*): all{' but ' if others else ''}{', '.join(others)}"
        return
    names = list(dict.fromkeys([*listed_objects, *[name for row in rows for name in row]]))
    index = {name: position for position, name in enumerate(names)}
    mutual = {row for row in rows if len(row) == 2 and row[0] != row[1] and row[::-1] in rows}
    kept = [row for row in rows if row not in mutual or index[row[0]] < index[row[1]]]
    for sign in ("", " both ways"):
        facts = [
            Fact(predicate, tuple([index[name] for name in row]))
            for row in kept
            if (row in mutual) is bool(sign)
        ]
        for line in write_similar_facts_on_one_line(
            facts, names, lambda name, words: f"{name}({', '.join(words)})"
        ):
            head, end, tail = line.partition(")")
            yield f"{head}{end}{sign}{tail}"


def shorten_rules(text: str) -> str:
    """Return rules with one line for each action, below an explanation of their notation.

    Args:
        text: a text that `Wording.describe_operators` returns.
    """
    explanation, _, rules = text.partition("\n")
    rules = rules if explanation == explain_rule_notation(rules) else text
    lines = [(len(line) - len(line.lstrip()), line.strip()) for line in rules.splitlines()]
    starts = [number for number, (depth, _) in enumerate(lines) if depth == 0]
    blocks = [lines[start:end] for start, end in zip(starts, [*starts[1:], len(lines)], strict=True)]
    short = "\n".join(map(_write_action_rule_on_one_line, blocks))
    notes = " ".join([words for sign, words in _SIGNS if sign in short])
    return f"{notes}\n{short}" if notes and explanation != text else short


def _write_action_rule_on_one_line(indented_lines: Sequence[tuple[int, str]]) -> str:
    """Return the rule of one action as one line.

    The rule is given as pairs of a line's indent and its text.
    """
    title = indented_lines[0][1]
    if len(indented_lines) == 1:
        return title
    head, _, description = title.partition(": ")
    conditions: list[str] = []
    needed, changes = "", []
    for depth, line in indented_lines[1:]:
        word, _, listed = line.partition(": ")
        if word == "requires":
            conditions = listed.split("; ")
        elif word == "needed only if":
            needed = f"[{listed}]"
        elif word in _BEFORE_REASONS:
            conditions.append(line)
        else:
            changes.append((depth, line))
    head, conditions = _move_parameter_types_into_rule_head(head, conditions)
    before = " ".join(filter(None, ("; ".join(conditions), needed)))
    start = ": ".join(filter(None, (f"{head} {description}".strip(), before)))
    return f"{start} -> {', '.join(_shorten_effects_of_action(changes))}" if changes else start


def _move_parameter_types_into_rule_head(head: str, conditions: Sequence[str]) -> tuple[str, list[str]]:
    """Return the head of an action's rule with the types of its parameters, such as ``open(x:door)``.

    Also return the conditions that do not state a type of a parameter.
    """
    name, separator, parameters = head.partition("(")
    words = parameters[:-1].split(", ")
    kinds = {match[1]: match[2] for match in map(_IS_A.fullmatch, conditions) if match and match[1] in words}
    named = [f"{word}:{kinds[word]}" if word in kinds else word for word in words]
    others = [text for text in conditions if text not in {f"is_a({x}, {kind})" for x, kind in kinds.items()}]
    return (f"{name}({', '.join(named)})" if separator else head), others


def _shorten_effects_of_action(indented_lines: Sequence[tuple[int, str]]) -> Iterator[str]:
    """Yield texts for the changes by an action.

    Changes under a condition stand in braces after the condition.
    """
    pending = list(indented_lines)
    while pending:
        depth, line = pending.pop(0)
        word, _, atoms = line.partition(": ")
        if line.endswith(":"):
            inner = list(takewhile(lambda below: below[0] > depth, pending))  # noqa: B023 - used at once
            del pending[: len(inner)]
            yield f"{line[:-1]} {{{', '.join(_shorten_effects_of_action(inner))}}}"
        elif word in _SIGN_OF_CHANGE:
            yield from (f"{_SIGN_OF_CHANGE[word]}{atom}" for atom in _COMMA.split(atoms))
        else:
            yield line
