"""Mutated subgoals: gold subgoals among random nested formulas with faults of all kinds."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from differential.mutations import Dice, rearranged, slightly_corrupted
from eai.logic.signature import FormulaSignature

ODD_SUBGOALS: tuple[object, ...] = (
    "",
    " ",
    "done",
    "SLEEP",
    "STANDUP",
    "WAKEUP",
    "()",
    "and",
    7,
    None,
    [],
    {},
    ["x"],
    True,
)
ODD_OUTPUTS: tuple[object, ...] = (None, "", "x", {}, 7, [], [[]], [""], [None], ["SLEEP"], ["then"])
ODD_NAMES = (
    "flies",
    "NOT",
    "not",
    "and",
    "forall",
    "agent",
    "_",
    "-",
    "notopen",
    "orange",
    "thenable",
    "open_",
    "",
)
ODD_OBJECTS = (
    "unicorn",
    "unicorn.1",
    "65",
    "x",
    "agent.1",
    "character",
    "character.65",
    "character.065",
    "",
    "a.b",
    "-1",
)


QUANTIFIERS = (
    *("exists {0}.", "forall {0}.", "forn 1. {0}.", "forn 2 {0}.", "forpairs {0}."),
    *("forpairs {0}, {1}.", "fornpairs 2. {0}, {1}.", "exists {0}: light.", "forpairs {0}: sofa, {1}."),
)


@dataclass(frozen=True, slots=True)
class Words:
    """Words of formulas about a scene. `near` has the relevant objects."""

    signature: FormulaSignature
    objects: Sequence[str]
    near: Sequence[str]


def subgoals(dice: Dice, gold: Sequence[str], words: Words, extras: Mapping[str, object]) -> str:
    """Return an answer of mutated subgoals. ``extras`` are the other keys that prompts ask for."""
    maker = _Maker(dice, words)
    parts: list[object] = list(gold if len(gold) < 9 or dice.chance(0.3) else gold[: 1 + dice.below(9)])
    parts = rearranged(dice, parts, lambda: maker.formula(dice.below(3)), dice.one((0, 1, 2, 3)))
    if dice.chance(0.3) and parts:
        for _ in range(1 + dice.few(0.5)):
            place = dice.below(len(parts))
            parts[place] = maker.changed(str(parts[place]))
    if dice.chance(0.06):
        parts.insert(dice.below(len(parts) + 1), dice.one(ODD_SUBGOALS))
    answer: dict[str, object] = {**(extras if dice.chance(0.5) else {}), "output": parts}
    if dice.chance(0.04):
        answer["output"] = dice.one(ODD_OUTPUTS)
    if dice.chance(0.03):
        answer = {dice.one(("Output", "outputs", "plan")): parts}
    text = json.dumps(answer, indent=dice.one((None, 1)), ensure_ascii=dice.chance(0.5))
    return slightly_corrupted(dice, text, 0.12)


class _Maker:
    """Makes formulas as text."""

    def __init__(self, dice: Dice, words: Words) -> None:
        self._dice = dice
        self._words = words
        signature = words.signature
        arities = {**signature.actions, **signature.predicates}
        self._names = [(name, 1 if arity is None else arity) for name, arity in sorted(arities.items())]

    def formula(self, depth: int, bound: tuple[str, ...] = ()) -> str:
        """Return a random formula up to this depth."""
        dice = self._dice
        if depth <= 0 or dice.chance(0.3):
            return self._primitive(bound)
        match dice.below(12):
            case 0 | 1 | 2 | 3:
                return self._series("and", depth, bound)
            case 4 | 5:
                return self._series("or", depth, bound)
            case 6 | 7:
                return self._series("then", depth, bound)
            case 8 | 9:
                return f"not {self._part(depth, bound)}"
            case 10:
                return f"({self.formula(depth - 1, bound)})"
            case _:
                return self._quantified(depth, bound)

    def changed(self, text: str) -> str:
        """Return a subgoal with an addition around, after or inside it."""
        dice = self._dice
        match dice.below(8):
            case 0:
                return f"{text} {dice.one(('and', 'or', 'then'))} {self.formula(1)}"
            case 1:
                return f"({text} then {self.formula(0)}) and {self.formula(0)}"
            case 2:
                return dice.one(("not ({})", "({})", "not {}", "not not {}", "not(not({}))")).format(text)
            case 3:
                return text.replace("(", dice.one((" (", "( ", "((", ""))).replace(
                    ")", dice.one((" )", ")", ""))
                )
            case 4:
                return text.replace(".", dice.one(("_", ".0", "", "..", ". ")), 1)
            case 5:
                return dice.one(
                    (text.lower(), text.upper(), f" {text} ", text.replace(", ", ","), f"{text}.", f"{text},")
                )
            case 6:
                return dice.one(
                    ("exists x. ({})", "forall x. ({})", "forn 2. x. ({})", "exists x.({})")
                ).format(text)
            case _:
                return f"{self.formula(1)} {dice.one(('and', 'or', 'then', 'AND', ''))} {text}"

    def _series(self, word: str, depth: int, bound: tuple[str, ...]) -> str:
        parts = [self._part(depth, bound) for _ in range(2 + self._dice.few(0.3))]
        return f" {word} ".join(parts)

    def _part(self, depth: int, bound: tuple[str, ...]) -> str:
        """Return a formula as part of a larger one: in brackets most times, unless it is one predicate."""
        text = self.formula(depth - 1, bound)
        is_simple = text.count("(") == 1 and " " not in text.replace(", ", "")
        return text if is_simple or self._dice.chance(0.25) else f"({text})"

    def _quantified(self, depth: int, bound: tuple[str, ...]) -> str:
        variable, other = self._dice.one((("x", "z"), ("y", "x"), ("x0", "y0"), ("soap", "x")))
        head = self._dice.one(QUANTIFIERS).format(variable, other)
        names = (*bound, variable, *([other] if "," in head else []))
        inner = self.formula(depth - 1, names if self._dice.chance(0.9) else bound)
        return f"{head} ({inner})"

    def _primitive(self, bound: tuple[str, ...]) -> str:
        dice = self._dice
        name, arity = dice.one(self._names)
        if dice.chance(0.04):
            name = dice.one(ODD_NAMES)
        if dice.chance(0.04):
            arity = dice.below(4)
        return f"{name}({', '.join(self._object(bound) for _ in range(arity))})"

    def _object(self, bound: tuple[str, ...]) -> str:
        dice, words = self._dice, self._words
        if bound and dice.chance(0.6):
            return dice.one(bound)
        if dice.chance(0.03):
            return dice.one(ODD_OBJECTS)
        known = words.near if words.near and dice.chance(0.85) else words.objects
        name = dice.one(known)
        return name.partition(".")[0] if dice.chance(0.02) else name
