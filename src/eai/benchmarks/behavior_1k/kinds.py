"""The kinds of objects in BEHAVIOR-1K (synsets of WordNet), and rules that turn objects into other kinds."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

from pydantic import TypeAdapter

from eai.base.grouping import group_pairs

PACK = "behavior_1k"
"""Name of the data package (pack) with the activities and annotations of BEHAVIOR-1K."""

ACTIVITIES, KINDS, RULES, PLANS = "activities.txt", "kinds.json", "rules.json", "plans.txt"
"""Names of data files: three in the data package `PACK`, and `PLANS` in the folder of this module.

`ACTIVITIES` and `PLANS` have one line per activity.
"""

_SYNSET = re.compile(r"([\w'-]+)\.n\.\d\d")

RAG = "rag.n.01"
"""Synset of rags.

For some abstract kinds of tools, BEHAVIOR-1K does not state which substances they remove. Here, tools of
these kinds remove substances as rags do.
"""

WATER, BOILED_WATER = "water.n.06", "cooked__water.n.01"
WASHER, DRYER = "washer.n.03", "clothes_dryer.n.01"
MELTING_TEMPERATURE, LIGHTING_TEMPERATURE = 100, 1000
"""Minimum temperature in degrees Celsius of a heat source that melts objects, and of a lighter."""

RemovalMethod: TypeAlias = str | list[str] | None
"""How a tool removes a substance.

A list names the solvents with which the tool must be soaked; an empty list means that the tool works dry. A
text means that the tool must be switched on. None means that the tool cannot remove the substance.
"""


def get_lemma(synset: str) -> str:
    """Return the name of a kind without word class and sense number: ``mug`` for ``mug.n.04``."""
    return _SYNSET.sub(lambda match: match[1].replace("-", "_"), synset)


class _HeatSource(NamedTuple):
    """A source of heat or cold: its temperature in degrees Celsius, and the conditions that it needs."""

    temperature: float
    needs: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ObjectRecipe:
    """A rule that makes an object from several ingredients.

    Attributes:
        name: name of the recipe.
        by: the method: ``machine``, ``stirring`` or ``heat``.
        takes: kind of ingredient -> number of objects that the recipe needs.
        cooked: kind of ingredient -> True if the ingredient must be cooked, False if it must be raw.
        toppings: kind of topping -> kind of the object that the topping lies on or covers.
        vessel: kind of the machine, or of the vessel that is heated; empty for any fillable object.
        source: kind of the source of heat or cold; empty if the recipe is not heated.
        makes: kind of product -> number of objects that the recipe makes.
        result: states of the products, such as ``hot``.
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
class ObjectProductionMethod:
    """A way to make an object of a kind: method, kinds of ingredients, equipment, and recipe, if any."""

    by: str
    takes: tuple[str, ...]
    equipment: tuple[str, ...] = ()
    recipe: ObjectRecipe | None = None


@dataclass(frozen=True)
class _ObjectKindTransformationRules:
    """The rules that turn objects into other kinds.

    Mappings are from a kind to the kind of the product, if not stated otherwise.

    Attributes:
        slice: kind -> kind of its halves, and their number.
        dice: kind -> kinds of its dice: a mapping with the keys ``raw`` and ``cooked``.
        melt: kind -> kind of the melted substance.
        cook: substance -> substance that heat turns it into.
        cook_in_water: substance -> substance that heat and boiled water turn it into.
        wash: substance -> solvents that water needs to wash the substance off; None if this is impossible.
        fits: pairs of kinds: objects of the first kind can be attached to objects of the second kind.
        recipes: the recipes.
    """

    slice: Mapping[str, tuple[str, int]]
    dice: Mapping[str, Mapping[str, str]]
    melt: Mapping[str, str]
    cook: Mapping[str, str]
    cook_in_water: Mapping[str, str]
    wash: Mapping[str, Sequence[str] | None]
    fits: Sequence[tuple[str, str]]
    recipes: Sequence[ObjectRecipe]

    @cached_property
    def production_methods(self) -> Mapping[str, Sequence[ObjectProductionMethod]]:
        """Mapping from a kind to all ways to make an object of this kind."""
        return group_pairs(self._yield_production_methods())

    def _yield_production_methods(self) -> Iterator[tuple[str, ObjectProductionMethod]]:
        for whole, (half, _) in self.slice.items():
            yield half, ObjectProductionMethod("slice", (whole,), ("slicer",))
        for whole, dice in self.dice.items():
            for made in dice.values():
                yield made, ObjectProductionMethod("dice", (whole,), ("slicer",))
        for by, rules in (("melt", self.melt), ("cook", self.cook)):
            for before, after in rules.items():
                yield after, ObjectProductionMethod(by, (before,), ("heatSource",))
        for before, after in self.cook_in_water.items():
            yield after, ObjectProductionMethod("cook_in_water", (before, BOILED_WATER), ("heatSource",))
        for recipe in self.recipes:
            tools = [kind for kind in (recipe.vessel, recipe.source) if kind]
            equipment = ("mixingTool",) if recipe.by == "stirring" else tuple(tools)
            for made in recipe.makes:
                yield made, ObjectProductionMethod("recipe", tuple(recipe.takes), equipment, recipe)


class ObjectKinds:
    """The kinds of objects with their abilities, and the rules that turn objects into other kinds.

    Args:
        values: content of the file `KINDS` in the data package `PACK`.
        rules: content of the file `RULES` in this package.
    """

    def __init__(self, values: Mapping[str, Any], rules: object) -> None:
        self._kinds: Mapping[str, Mapping[str, Any]] = values["kinds"]
        self._removers: Sequence[Mapping[str, Any] | None] = values["removers"]
        self.rules = TypeAdapter(_ObjectKindTransformationRules).validate_python(rules)

    def has_ability(self, synset: str, *abilities: str) -> bool:
        """Whether objects of a kind have any of the abilities."""
        owned = self._kinds.get(synset, {})
        return any(ability in owned for ability in abilities)

    def get_minimum_temperature(self, synset: str, ability: str) -> float | None:
        """Return the minimum temperature for an ability, or None if objects of the kind lack the ability.

        For `cookable`, heat of at least this temperature in degrees Celsius cooks the object.
        """
        temperature = self._kinds.get(synset, {}).get(ability)
        return None if temperature is None else float(temperature)

    def get_heat_source(self, synset: str, ability: str) -> _HeatSource | None:
        """Return temperature and conditions of use of a kind of heat or cold source; None for other kinds."""
        source = self._kinds.get(synset, {}).get(ability)
        return None if source is None else _HeatSource(source["temperature"], tuple(source["needs"]))

    def get_substances_supplied_by_object_kind(self, synset: str) -> Sequence[str]:
        """Return the substances that objects of a kind give (as sinks do), or apply to other objects."""
        substances: Sequence[str] = self._kinds.get(synset, {}).get("gives", ())
        return substances

    def get_removal_method(self, tool: str, substance: str) -> RemovalMethod:
        """Return the way in which a kind of tool removes a substance."""
        number = self._kinds.get(tool, {}).get("removes")
        if number is None:
            return None
        methods = self._removers[number] or self._removers[self._kinds[RAG]["removes"]] or {}
        kind = "fluid" if self.has_ability(substance, "liquid") else "non_fluid"
        kind = "visual" if self.has_ability(substance, "visualSubstance") else kind
        method: RemovalMethod = methods[substance if substance in methods else kind]
        return method
