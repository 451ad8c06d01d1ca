"""Make scenes of BEHAVIOR-1K: the objects of an activity, their possible products, and the initial state.

If a definition leaves a fact open, `docs/behavior-1k.md` decides it. For example, objects are closed and
switched off, and a source gives the substance of its kind. Furniture of a room is fixed, unless the goal
moves it (decision D2). Rules become facts of the scene, such as the foods that a heat source cooks, or the
tool that removes a stain. Each recipe that can matter is an invisible object. Objects that actions may make
have a name from the start.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import chain
from typing import TypeAlias

import eai.logic.formula as f
from eai.benchmarks.behavior_1k import kinds as k
from eai.benchmarks.behavior_1k import predicates as p
from eai.logic.traversal import get_bound_variables, walk_subformulas
from eai.pddl.bddl import parse_problem
from eai.world.state import Scene, State
from eai.world.vocabulary import Predicate

AGENT, ANY_OTHER = "agent", "_*"
RECIPE = "recipe"
"""Category of the objects that represent recipes. They come last in a scene, and no answer may name them."""
GROUND = ("floor", "lawn", "driveway")
"""Categories of objects on which the agent may stand."""

_SYNSET = re.compile(r"([\w'-]+)\.n\.\d\d")
_SUPPORTS = ("inside", "ontop", "attached", "overlaid", "draped")
_MOVING_PREDICATES = ("inside", "ontop", "under", "attached")
_SceneFactIterator: TypeAlias = Iterator[tuple[Predicate, tuple[str, ...]]]
_NEED_PREDICATES = {"toggled_on": p.works_on, "closed": p.works_closed, "inside": p.works_inside}
_ABILITIES_OF_PREDICATE: Mapping[Predicate, tuple[str, ...]] = {
    **{
        predicate: (predicate.name,)
        for predicate in (p.openable, p.toggleable, p.slicer, p.fillable, p.substance)
    },
    **{predicate: (predicate.name,) for predicate in (p.liquid, p.heatable, p.flammable)},
    p.cloth: ("cloth", "drapeable"),
    p.foldable: ("cloth", "rope"),
    p.mixing_tool: ("mixingTool",),
    p.absorbent: ("removes",),
    p.visual: ("visualSubstance",),
    p.sink: ("drains",),
    p.heat_source: ("heatSource",),
    p.cold_source: ("coldSource",),
}
"""Predicate -> names of abilities in the annotations.

The predicate holds for an object if the object's kind has at least one of the abilities.
"""


def map_categories_to_synsets(activity_definition: str) -> Mapping[str, str]:
    """Return a mapping from each category in a definition, such as ``mug``, to its synset in the definition.

    If a category has several synsets, the last one in the text counts.
    """
    return {k.get_lemma(match[0]): match[0] for match in _SYNSET.finditer(activity_definition)}


class _ActivityDefinition:
    """The definition of an activity. Its names have no sense numbers: ``mug_1`` for ``mug.n.04_1``.

    Args:
        text: the definition.

    Attributes:
        problem: the parsed definition.
        synsets: category -> synset. No definition has two synsets that differ only in their sense number.
    """

    def __init__(self, text: str) -> None:
        self.problem = parse_problem(k.get_lemma(text))
        self.synsets = map_categories_to_synsets(text)

    @cached_property
    def category_by_object(self) -> Mapping[str, str]:
        """Mapping from the name of each declared object, except the agent, to its category.

        Names that end in ``_*`` are left out: they mean further objects of the simulator's scene.
        """
        declared = self.problem.objects
        return {
            obj.name: obj.type for obj in declared if obj.type != AGENT and not obj.name.endswith(ANY_OTHER)
        }

    def yield_initial_facts(self) -> Iterator[tuple[str, tuple[str, ...]]]:
        """Yield the positive initial facts, except about the agent.

        Each is a predicate and names of objects.
        """
        for fact in self.problem.initial:
            names = tuple([term.name for term in fact.arguments])
            if not names[0].startswith(f"{AGENT}_") and not any(n.endswith(ANY_OTHER) for n in names):
                yield fact.predicate, names

    def yield_categories_mentioned_in_goal(self) -> Iterator[str]:
        """Yield the category of each object and each variable that the goal mentions."""
        for formula in walk_subformulas(self.problem.goal):
            if isinstance(formula, f.Atom):
                yield from (
                    self.category_by_object[t.name]
                    for t in formula.arguments
                    if t.name in self.category_by_object
                )
        yield from self._category_by_variable.values()

    @cached_property
    def _category_by_variable(self) -> Mapping[str, str]:
        """Mapping from the name of each variable of the goal to its category.

        In a definition, all variables of one name have one category.
        """
        bound = chain.from_iterable(map(get_bound_variables, walk_subformulas(self.problem.goal)))
        return {variable.name: str(variable.category) for variable in bound}

    def _yield_binary_atoms(self) -> Iterator[tuple[str, f.Term, f.Term]]:
        """Yield, for each atom of the goal with two arguments, its predicate and its arguments."""
        for formula in walk_subformulas(self.problem.goal):
            if isinstance(formula, f.Atom) and len(formula.arguments) == 2:
                yield formula.predicate, *formula.arguments

    def _find_objects_for_term(self, term: f.Term) -> Sequence[str]:
        """Return the names of the objects that a term of the goal (an object or a variable) may stand for."""
        if isinstance(term, f.Constant):
            return (term.name,)
        return [
            name
            for name, category in self.category_by_object.items()
            if category == self._category_by_variable[term.name]
        ]

    @cached_property
    def objects_that_goal_may_move(self) -> frozenset[str]:
        """Objects that may have to be moved to reach the goal.

        A chair counts, too, if the goal is to put the chair next to an object.
        """
        names = {
            name
            for predicate, obj, _ in self._yield_binary_atoms()
            for name in self._find_objects_for_term(obj)
            if predicate in _MOVING_PREDICATES or (predicate == "nextto" and "chair" in name)
        }
        return frozenset(name for name in names if self.category_by_object[name] not in GROUND)

    def yield_container_kinds(self) -> Iterator[str]:
        """Yield the kinds of objects that contain another object, initially or in the goal."""
        for predicate, names in self.yield_initial_facts():
            if predicate == "inside":
                yield self.synsets[self.category_by_object[names[1]]]
        for predicate, _, container in self._yield_binary_atoms():
            if predicate == "inside":
                yield from (
                    self.synsets[self.category_by_object[name]]
                    for name in self._find_objects_for_term(container)
                )


class _SceneMaker:
    """Makes the scene of one activity.

    Args:
        activity: the definition of the activity.
        kinds: the kinds of objects and the rules.
        containers: kinds of objects that contain another object in the definition of some activity.
    """

    def __init__(
        self, activity: _ActivityDefinition, kinds: k.ObjectKinds, containers: frozenset[str]
    ) -> None:
        self._activity = activity
        self._kinds = kinds
        self._containers = containers
        self._declared_kinds = {name: activity.synsets[c] for name, c in activity.category_by_object.items()}
        self._future = {
            names[0] for predicate, names in activity.yield_initial_facts() if predicate == "future"
        }
        self._kind_of_each = dict(self._declared_kinds)  # `make_state` adds objects that actions can make
        self._gives = {
            names for predicate, names in activity.yield_initial_facts() if predicate == "insource"
        }
        self._rooms = {
            names[0]: names[1] for predicate, names in activity.yield_initial_facts() if predicate == "inroom"
        }
        self._recipes: list[k.ObjectRecipe] = []

    def make_state(self) -> State:
        """Return the initial state.

        Its objects are the declared objects, then objects that actions can make, then recipes. A recipe is an
        object, because its facts state what it needs and makes.
        """
        self._add_substances_supplied_by_objects()
        wanted = {self._declared_kinds[name] for name in self._future}
        in_goal = (self._activity.synsets[c] for c in self._activity.yield_categories_mentioned_in_goal())
        present = {kind for name, kind in self._kind_of_each.items() if name not in self._future}
        wanted |= {
            kind for kind in in_goal if kind in self._kinds.rules.production_methods and kind not in present
        }
        self._add_recipes_and_products_to_scene(sorted(wanted), present)
        recipes = {f"recipe_{number}": recipe for number, recipe in enumerate(self._recipes, 1)}
        made = {name: f"made__{k.get_lemma(kind)}" for name, kind in self._kind_of_each.items()}
        objects = {**made, **self._activity.category_by_object, **dict.fromkeys(recipes, RECIPE)}
        facts = dict.fromkeys((*self._yield_facts(), *self._yield_facts_describing_recipes(recipes)))
        return Scene(p.VOCABULARY, objects).state((predicate.name, names) for predicate, names in facts)

    # The objects.

    def _find_objects_of_kind(self, synset: str) -> list[str]:
        """Return the names of the objects of a kind. Objects that the activity declares come first."""
        return [name for name, kind in self._kind_of_each.items() if kind == synset]

    def _add_object(self, synset: str) -> str:
        stem, number = k.get_lemma(synset), 1
        while f"{stem}_{number}" in self._kind_of_each:
            number += 1
        self._kind_of_each[f"{stem}_{number}"] = synset
        return f"{stem}_{number}"

    def _add_substances_supplied_by_objects(self) -> None:
        """Add facts that state which substances each object supplies because of its kind.

        Facts that the definition of the activity states are not added again.
        """
        for name, kind in list(self._declared_kinds.items()):
            for substance in self._kinds.get_substances_supplied_by_object_kind(kind):
                objects = self._find_objects_of_kind(substance)
                if not any((name, given) in self._gives for given in objects):
                    self._gives.add((name, objects[0] if objects else self._add_object(substance)))

    def _has_equipment(self, kind_or_ability: str, present_kinds: set[str]) -> bool:
        """Whether the scene has an object of a needed kind, or with a needed ability."""
        return kind_or_ability in present_kinds or any(
            self._kinds.has_ability(kind, kind_or_ability) for kind in self._declared_kinds.values()
        )

    def _is_kind_present_or_makeable(
        self, kind: str, present_kinds: set[str], visited_kinds: tuple[str, ...]
    ) -> bool:
        """Whether the scene has an object of a kind, or objects from which such an object can be made."""
        if kind in present_kinds:
            return True
        return kind not in visited_kinds and any(
            self._can_method_be_used(making, present_kinds, (*visited_kinds, kind))
            for making in self._kinds.rules.production_methods.get(kind, ())
        )

    def _can_method_be_used(
        self, method: k.ObjectProductionMethod, present_kinds: set[str], visited_kinds: tuple[str, ...]
    ) -> bool:
        return all(self._has_equipment(need, present_kinds) for need in method.equipment) and all(
            self._is_kind_present_or_makeable(ingredient, present_kinds, visited_kinds)
            for ingredient in method.takes
        )

    def _add_recipes_and_products_to_scene(
        self, wanted_kinds: Sequence[str], present_kinds: set[str]
    ) -> None:
        """Add recipes for objects of the wanted kinds to the scene, with intermediate and final products."""
        makings = self._kinds.rules.production_methods
        pending, ways = list(wanted_kinds), dict[str, list[k.ObjectProductionMethod]]()
        while pending:
            kind = pending.pop()
            if kind in ways:
                continue
            ways[kind] = [
                m for m in makings.get(kind, ()) if self._can_method_be_used(m, present_kinds, (kind,))
            ]
            for making in ways[kind]:
                if making.recipe is not None and making.recipe not in self._recipes:
                    self._recipes.append(making.recipe)
                pending += [taken for taken in making.takes if taken not in present_kinds or taken in makings]
        for kind, makings_of_kind in ways.items():
            if kind not in present_kinds or kind in {self._kind_of_each[name] for name in self._future}:
                self._add_producible_objects_of_kind(kind, makings_of_kind)
        for kind in dict.fromkeys(self._declared_kinds.values()):
            if kind in self._kinds.rules.slice and self._has_equipment("slicer", present_kinds):
                self._add_halves_made_by_slicing(kind)

    def _add_producible_objects_of_kind(
        self, kind: str, production_methods: Sequence[k.ObjectProductionMethod]
    ) -> None:
        """Add objects of a kind until the scene has the greatest number that a method can make.

        Slicing makes two halves of each whole object. A recipe makes its number of products, but only one
        object of a substance. All other methods make one object. Without slicing, objects are added only if
        the scene has no object of the kind.
        """
        number = 1
        for making in production_methods:
            if making.by == "slice":
                number = max(number, 2 * len(self._find_objects_of_kind(making.takes[0])))
            if making.recipe is not None and not self._kinds.has_ability(kind, "substance"):
                number = max(number, making.recipe.makes[kind])
        by_slicing = any(making.by == "slice" for making in production_methods)
        if by_slicing or not self._find_objects_of_kind(kind):
            while len(self._find_objects_of_kind(kind)) < number:
                self._future.add(self._add_object(kind))

    def _add_halves_made_by_slicing(self, kind: str) -> None:
        """Add two halves for each object of a kind that can be sliced.

        They do not exist before the slicing.
        """
        half, number = self._kinds.rules.slice[kind]
        wholes = len(self._find_objects_of_kind(kind))
        while (
            len([name for name in self._find_objects_of_kind(half) if name in self._future]) < number * wholes
        ):
            self._future.add(self._add_object(half))

    # The facts.

    def _yield_facts(self) -> _SceneFactIterator:
        for name, kind in self._kind_of_each.items():
            yield from self._yield_ability_facts_of_object(name, kind)
            yield from self._yield_heat_and_cold_facts(name, kind)
            yield from self._yield_substance_removal_facts(name, kind)
            yield from self._yield_transformation_and_attachment_facts(name, kind)
        yield from self._yield_facts_on_sliced_halves()
        for name, substance in sorted(self._gives):
            yield p.gives, (name, substance)
        yield from self._yield_facts_of_initial_state()

    def _yield_ability_facts_of_object(self, object_name: str, kind: str) -> _SceneFactIterator:
        has, rules = self._kinds.has_ability, self._kinds.rules
        for predicate, abilities in _ABILITIES_OF_PREDICATE.items():
            if has(kind, *abilities):
                yield predicate, (object_name,)
        heat = self._kinds.get_heat_source(kind, "heatSource")
        cold = self._kinds.get_heat_source(kind, "coldSource")
        encloses = any(source is not None and "inside" in source.needs for source in (heat, cold))
        others = {
            p.fixed: has(kind, "sceneObject")
            and object_name in self._rooms
            and object_name not in self._activity.objects_that_goal_may_move,
            p.floor: k.get_lemma(kind) in GROUND,
            p.sliceable: kind in rules.slice,
            p.diceable: kind in rules.dice and kind not in rules.slice,
            p.container: not has(kind, "substance")
            and (encloses or kind in self._containers or has(kind, "fillable", "openable")),
            p.washer: kind == k.WASHER,
            p.dryer: kind == k.DRYER,
            p.water: kind == k.WATER,
            p.boiled_water: kind == k.BOILED_WATER,
            p.lighter: heat is not None
            and heat.temperature >= k.LIGHTING_TEMPERATURE
            and not has(kind, "sceneObject"),
        }
        yield from ((predicate, (object_name,)) for predicate, holds in others.items() if holds)
        for source in (heat, cold):
            for need in source.needs if source is not None else ():
                yield _NEED_PREDICATES[need], (object_name,)

    def _yield_heat_and_cold_facts(self, name: str, kind: str) -> _SceneFactIterator:
        """Yield facts that state which objects a source of heat or cold cooks, melts or chills."""
        heat = self._kinds.get_heat_source(kind, "heatSource")
        cold = self._kinds.get_heat_source(kind, "coldSource")
        if heat is None and cold is None:
            return
        for other, its_kind in self._kind_of_each.items():
            done = self._kinds.get_minimum_temperature(its_kind, "cookable")
            melting = its_kind in self._kinds.rules.melt
            if heat is not None:
                if done is not None and heat.temperature >= done:
                    yield p.cooks, (name, other)
                if melting and heat.temperature >= k.MELTING_TEMPERATURE:
                    yield p.melts, (name, other)
                    if self._kinds.has_ability(its_kind, "substance"):
                        yield p.cooks, (name, other)
            if cold is not None and cold.temperature <= 0 and self._kinds.has_ability(its_kind, "freezable"):
                yield p.chills, (name, other)

    def _yield_substance_removal_facts(self, tool: str, tool_kind: str) -> _SceneFactIterator:
        washes = tool_kind == k.WASHER or self._kinds.has_ability(tool_kind, "drains")
        for other, substance in self._kind_of_each.items():
            if not self._kinds.has_ability(substance, "substance"):
                continue
            match self._kinds.get_removal_method(tool_kind, substance):
                case []:
                    yield p.removes_dry, (tool, other)
                case "toggled_on":
                    yield p.removes_running, (tool, other)
                case [*solvents]:
                    yield p.removes_soaked, (tool, other)
                    yield from self._yield_facts_of_solvents_for_substance(other, solvents)
            if washes:
                needed = self._kinds.rules.wash.get(substance, ())
                if needed is not None and not needed:
                    yield p.washes_off, (tool, other)
                yield from self._yield_facts_of_solvents_for_substance(other, needed or ())

    def _yield_facts_of_solvents_for_substance(
        self, substance: str, solvent_kinds: Iterable[str]
    ) -> _SceneFactIterator:
        for kind in solvent_kinds:
            yield from (
                (p.dissolved_by, (substance, solvent)) for solvent in self._find_objects_of_kind(kind)
            )

    def _yield_transformation_and_attachment_facts(self, object_name: str, kind: str) -> _SceneFactIterator:
        rules = self._kinds.rules
        dice = rules.dice.get(kind, {})
        is_substance = self._kinds.has_ability(kind, "substance")
        for predicate, made in (
            (p.melts_to, rules.melt.get(kind)),
            (p.cooks_to, rules.cook.get(kind)),
            (p.cooks_to, rules.melt.get(kind) if is_substance else None),
            (p.boils_to, rules.cook_in_water.get(kind)),
            (p.diced_as, dice.get("raw")),
            (p.diced_cooked_as, dice.get("cooked")),
        ):
            for other in self._find_objects_of_kind(made) if made is not None else ():
                yield predicate, (object_name, other)
        for one, to in rules.fits:
            if one == kind:
                yield from ((p.fits, (object_name, other)) for other in self._find_objects_of_kind(to))

    def _yield_facts_on_sliced_halves(self) -> _SceneFactIterator:
        for whole, (half, number) in self._kinds.rules.slice.items():
            halves = [name for name in self._find_objects_of_kind(half) if name in self._future]
            for position, name in enumerate(self._find_objects_of_kind(whole)):
                for half_name in halves[number * position : number * (position + 1)]:
                    yield p.part_of, (half_name, name)

    def _yield_facts_of_initial_state(self) -> _SceneFactIterator:
        placed: set[str] = set()
        present = {substance for _, substance in self._gives}
        for predicate, names in self._activity.yield_initial_facts():
            stored = p.STORED.get(predicate)
            if predicate in _SUPPORTS and names[0] in placed:
                continue
            if predicate in _SUPPORTS:
                placed.add(names[0])
            if predicate == "filled":
                yield p.has_in, names
            if predicate in ("filled", "covered", "contains", "saturated"):
                present.add(names[1])
            if stored is not None:
                yield stored, names
            elif predicate not in ("inroom", "insource", "future"):
                yield p.VOCABULARY.find_stored_predicate(f"is_{predicate}") or p.is_broken, names
        for name, kind in self._kind_of_each.items():
            if name not in self._future and (
                name in present or not self._kinds.has_ability(kind, "substance")
            ):
                yield p.present, (name,)
        yield from self._yield_floor_facts()

    def _yield_floor_facts(self) -> _SceneFactIterator:
        floors = [name for name, kind in self._declared_kinds.items() if k.get_lemma(kind) in GROUND]
        for name, kind in self._kind_of_each.items():
            room = self._rooms.get(name)
            near = [floor for floor in floors if room is None or self._rooms.get(floor) == room]
            if near and name not in floors and not self._kinds.has_ability(kind, "substance"):
                yield p.by_floor, (name, near[0])
        for fact in self._activity.problem.initial:
            match fact:
                case f.Atom("ontop", (agent, ground)) if agent.name.startswith(f"{AGENT}_"):
                    yield p.robot_on, (ground.name,)

    # Recipes.

    def _yield_facts_describing_recipes(self, recipes: Mapping[str, k.ObjectRecipe]) -> _SceneFactIterator:
        for name, recipe in recipes.items():
            yield p.recipe, (name,)
            if recipe.by != "machine":
                yield p.by_stirring if recipe.by == "stirring" else p.by_heat, (name,)
            bakes = recipe.by == "heat" and not any(
                self._kinds.has_ability(made, "substance") for made in recipe.makes
            )
            if bakes:
                yield p.relaxed, (name,)
            for kind, number in recipe.takes.items():
                yield from self._yield_ingredient_facts(name, recipe, kind, number, is_baking=bakes)
            for kind, number in recipe.makes.items():
                made = self._find_objects_of_kind(kind)
                declared = len([product for product in made if product in self._declared_kinds])
                for product in made[: max(number, declared)]:
                    yield p.makes, (name, product)
                    yield p.product, (product,)
            yield from ((p.makes_cooked, (name,)) for state in recipe.result if state == "cooked")
            yield from ((p.makes_hot, (name,)) for state in recipe.result if state == "hot")
            yield from ((p.made_in, (name, vessel)) for vessel in self._find_objects_of_kind(recipe.vessel))
            yield from ((p.heated_by, (name, source)) for source in self._find_objects_of_kind(recipe.source))
            if recipe.by == "machine":
                yield from ((p.mixer, (machine,)) for machine in self._find_objects_of_kind(recipe.vessel))

    def _yield_ingredient_facts(
        self,
        recipe_name: str,
        recipe: k.ObjectRecipe,
        ingredient_kind: str,
        needed_count: int,
        *,
        is_baking: bool,
    ) -> _SceneFactIterator:
        """Yield facts that state which objects of a kind (the ingredient) a recipe takes.

        A recipe for baking takes a substance only if it is a topping, or if a topping lies on or covers it.
        """
        related = ingredient_kind in recipe.toppings or ingredient_kind in recipe.toppings.values()
        is_substance = self._kinds.has_ability(ingredient_kind, "substance")
        if is_substance and is_baking and not related:
            return
        for taken in self._find_objects_of_kind(ingredient_kind)[: None if is_substance else needed_count]:
            yield p.topping if ingredient_kind in recipe.toppings else p.ingredient, (recipe_name, taken)
            if ingredient_kind in recipe.toppings.values():
                yield p.base, (recipe_name, taken)
            if ingredient_kind in recipe.cooked:
                yield p.cooked_first if recipe.cooked[ingredient_kind] else p.raw, (recipe_name, taken)


SceneBuilder: TypeAlias = Callable[[str], tuple[_ActivityDefinition, State]]
"""Function from the name of an activity to its parsed definition and its initial state."""


def make_scene_builder(kinds: k.ObjectKinds, definitions: Mapping[str, str]) -> SceneBuilder:
    """Return a function that maps the name of an activity to its definition and initial state.

    The returned function raises KeyError for an unknown name.

    Args:
        kinds: the kinds of objects and the rules.
        definitions: definitions by name of the activity.
    """
    activities = {name: _ActivityDefinition(text) for name, text in definitions.items()}
    containers = frozenset(
        kind for activity in activities.values() for kind in activity.yield_container_kinds()
    )
    return lambda name: (activities[name], _SceneMaker(activities[name], kinds, containers).make_state())
