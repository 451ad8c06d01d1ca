"""The annotations of BEHAVIOR-1K: kinds of objects, and the rules by which they become others."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

from pydantic import TypeAdapter

from eai.base.grouping import group_pairs

PACK = "behavior_1k"
"""Name of the pack with these activities and annotations."""

ACTIVITIES, KINDS, RULES, PLANS = "activities.txt", "kinds.json", "rules.json", "plans.txt"
"""The members of the pack: the first and the last have one line an activity."""

_SYNSET = re.compile(r"([\w'-]+)\.n\.\d\d")

RAG = "rag.n.01"
"""How a kind removes substances that stands for others and has no conditions of its own (`convert`)."""

WATER, BOILED_WATER = "water.n.06", "cooked__water.n.01"
WASHER, DRYER = "washer.n.03", "clothes_dryer.n.01"
MELTING_TEMPERATURE, LIGHTING_TEMPERATURE = 100, 1000
"""Temperatures in degrees Celsius: `MeltingRule`, and the flame of a lighter."""

Manner: TypeAlias = str | list[str] | None
"""How a tool removes a substance: just so ([]), soaked with one of these, ``toggled_on``, or not (None)."""


def lemma(synset: str) -> str:
    """The name of a kind without its sense: ``mug`` of ``mug.n.04``."""
    return _SYNSET.sub(lambda match: match[1].replace("-", "_"), synset)


class _HeatSource(NamedTuple):
    """A source of heat or cold: its temperature, and what it needs to work on something."""

    temperature: float
    needs: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Recipe:
    """A rule that makes things of several others.

    Attributes:
        name: its name.
        by: what is done: ``machine``, ``stirring`` or ``heat``.
        takes: how many of each kind.
        cooked: kinds that must be cooked, or must not.
        toppings: what lies on or covers which other kind.
        vessel: the kind of the machine, or of what it is heated in; empty for anything that can be filled.
        source: the kind of what heats or cools it, if it is heated.
        makes: how many of each kind come of it.
        result: the states in which they come to be.
    """

    name: str
    by: str
    takes: Mapping[str, int]
    cooked: Mapping[str, bool]
    toppings: Mapping[str, str]
    vessel: str
    source: str
    makes: Mapping[str, int]
    result: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Making:
    """A way to make a kind: by what, of what, with what at hand, and by which recipe, if by one."""

    by: str
    takes: tuple[str, ...]
    equipment: tuple[str, ...] = ()
    recipe: Recipe | None = None


@dataclass(frozen=True)
class _KindRules:
    """The rules; each mapping is from a kind to what it becomes.

    Attributes:
        slice: the kind of its halves, and how many.
        dice: what its dice are, by ``raw`` and ``cooked``.
        melt: what it melts to.
        cook: what a substance becomes when it is hot enough.
        cook_in_water: the same for what needs boiled water.
        wash: by substance: what water must have in it to wash it off; None for what never is.
        fits: which kind can be attached to which.
        recipes: the recipes.
    """

    slice: Mapping[str, tuple[str, int]]
    dice: Mapping[str, Mapping[str, str]]
    melt: Mapping[str, str]
    cook: Mapping[str, str]
    cook_in_water: Mapping[str, str]
    wash: Mapping[str, Sequence[str] | None]
    fits: Sequence[tuple[str, str]]
    recipes: Sequence[Recipe]

    @cached_property
    def makings(self) -> Mapping[str, Sequence[Making]]:
        """All ways to make each kind."""
        return group_pairs(self._yield_makings())

    def _yield_makings(self) -> Iterator[tuple[str, Making]]:
        for whole, (half, _) in self.slice.items():
            yield half, Making("slice", (whole,), ("slicer",))
        for whole, dice in self.dice.items():
            for made in dice.values():
                yield made, Making("dice", (whole,), ("slicer",))
        for by, rules in (("melt", self.melt), ("cook", self.cook)):
            for before, after in rules.items():
                yield after, Making(by, (before,), ("heatSource",))
        for before, after in self.cook_in_water.items():
            yield after, Making("cook_in_water", (before, BOILED_WATER), ("heatSource",))
        for recipe in self.recipes:
            tools = [kind for kind in (recipe.vessel, recipe.source) if kind]
            equipment = ("mixingTool",) if recipe.by == "stirring" else tuple(tools)
            for made in recipe.makes:
                yield made, Making("recipe", tuple(recipe.takes), equipment, recipe)


class Kinds:
    """The kinds, each with its abilities, and the rules.

    Args:
        values: the content of the member of kinds.
        rules: that of the member of rules.
    """

    def __init__(self, values: Mapping[str, Any], rules: object) -> None:
        self._kinds: Mapping[str, Mapping[str, Any]] = values["kinds"]
        self._removers: Sequence[Mapping[str, Any] | None] = values["removers"]
        self.rules = TypeAdapter(_KindRules).validate_python(rules)

    def has(self, synset: str, *abilities: str) -> bool:
        """Whether a kind has one of these abilities."""
        known = self._kinds.get(synset, {})
        return any(ability in known for ability in abilities)

    def get_threshold(self, synset: str, ability: str) -> float | None:
        """The temperature from which on an ability shows; None without the ability."""
        found = self._kinds.get(synset, {}).get(ability)
        return None if found is None else float(found)

    def get_heat_source(self, synset: str, ability: str) -> _HeatSource | None:
        """The source of heat or cold that a kind is; None if it is none."""
        found = self._kinds.get(synset, {}).get(ability)
        return None if found is None else _HeatSource(found["temperature"], tuple(found["needs"]))

    def get_substances(self, synset: str) -> Sequence[str]:
        """The substances that a source or an applier gives."""
        found: Sequence[str] = self._kinds.get(synset, {}).get("gives", ())
        return found

    def get_manner(self, tool: str, substance: str) -> Manner:
        """How a kind of tool removes a substance."""
        number = self._kinds.get(tool, {}).get("removes")
        if number is None:
            return None
        manners = self._removers[number] or self._removers[self._kinds[RAG]["removes"]] or {}
        kind = "fluid" if self.has(substance, "liquid") else "non_fluid"
        kind = "visual" if self.has(substance, "visualSubstance") else kind
        found: Manner = manners[substance if substance in manners else kind]
        return found
