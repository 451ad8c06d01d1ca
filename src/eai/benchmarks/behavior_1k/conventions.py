"""Describe hidden facts of a BEHAVIOR-1K scene: sources, floors, and conventions of the household.

Conventions are facts such as the tool that removes a stain, the heat of a toaster, and the ingredients of a
recipe. Prompts list the conventions that matter for a task, unless the benchmark tests whether a model knows
them. The substance that a source gives and the floor on which furniture stands cannot be known beforehand:
every prompt for plans lists them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import reduce
from operator import or_

from eai.benchmarks.behavior_1k import predicates as p
from eai.tasks.task import Task
from eai.world.relation import iterate_bits
from eai.world.state import State
from eai.world.vocabulary import Predicate

HEADING = "Conventions of this household that matter here:"
SITUATION = "Sources and floors of this household:"

_NEED_WORDS: Mapping[Predicate, str] = {
    p.works_inside: "on what is inside it",
    p.works_on: "while switched on",
    p.works_closed: "while closed",
}

_WIPING_WORDS: Mapping[Predicate, str] = {
    p.removes_dry: "dry",
    p.removes_running: "switched on",
    p.removes_soaked: "soaked with a solvent",
}

_MADE_SENTENCES: Mapping[Predicate, str] = {
    p.diced_as: "DICE makes {} of {}.",
    p.diced_cooked_as: "DICE makes {} of {} if that is cooked.",
    p.cooks_to: "Heat makes {} of {} in a vessel.",
    p.boils_to: "Heat makes {} of {} in a vessel with boiled water.",
    p.melts_to: "Heat melts {1} in or on something to {0}.",
}

_RESULT_WORDS: Mapping[str, Predicate] = {"cooked": p.makes_cooked, "hot": p.makes_hot}


class SceneFactReader:
    """Reads the facts of a state. Objects are given and returned by name.

    Args:
        state: the state.
    """

    def __init__(self, state: State) -> None:
        self._state = state
        self._index = state.scene.index
        self._names = [obj.name for obj in state.scene.objects]

    def _has_fact(self, predicate: Predicate, *names: str) -> bool:
        return self._state.has(predicate.name, *[self._index[name] for name in names])

    def _find_objects_with(self, predicate: Predicate) -> list[str]:
        return [self._names[i] for i in iterate_bits(self._state.mask(predicate.name))]

    def _find_targets_of(self, relation: Predicate, source: str) -> list[str]:
        return [
            self._names[i] for i in iterate_bits(self._state.relation(relation.name).row(self._index[source]))
        ]

    def _find_sources_of(self, relation: Predicate, target: str) -> list[str]:
        return [
            self._names[i]
            for i in iterate_bits(self._state.relation(relation.name).column(self._index[target]))
        ]


def describe_unobservable_facts(task: Task) -> str:
    """Return text for the facts of a task that no observation shows, or an empty text without such facts.

    The text has two parts with headings; an empty part is left out. The first part lists the substance that
    each source (such as a sink) supplies, and the floor under objects. The second part lists facts about
    tools, heat and recipes that never change (conventions).
    """
    return "\n\n".join(
        filter(
            None,
            (
                describe_floors_and_substance_sources(task),
                _format_list_with_heading(
                    HEADING, _HouseholdConventionWriter(task.initial).write_household_convention_lines()
                ),
            ),
        )
    )


def describe_floors_and_substance_sources(task: Task) -> str:
    """Return text for the substance that each source supplies, and for the floor under objects.

    Each source or floor has a line under a heading. Without sources and floors, the text is empty.
    """
    return _format_list_with_heading(
        SITUATION,
        _WriterOfFloorsAndSubstanceSources(task.initial).write_lines_on_floors_and_substance_sources(),
    )


def _format_list_with_heading(heading: str, lines: Iterable[str]) -> str:
    texts = list(lines)
    return "\n".join((heading, *texts)) if texts else ""


class _WriterOfFloorsAndSubstanceSources(SceneFactReader):
    """Describes the substances that each source gives, and the floor under each object without support."""

    def write_lines_on_floors_and_substance_sources(self) -> Iterator[str]:
        """Yield a line for each source of substances, such as a sink, and for each floor near objects.

        The line of a floor lists the objects that exist, have this floor, and are not in or on an object.
        """
        for source in self._names:
            given = self._find_targets_of(p.gives, source)
            if given:
                yield f"- {source} {self._describe_substance_source(source, _join_names(given))}."
        resting = reduce(or_, [self._state.relation(support).sources for support in p.SUPPORTS])
        free = {*self._find_objects_with(p.present)} - {self._names[i] for i in iterate_bits(resting)}
        for floor in self._find_objects_with(p.floor):
            above = [name for name in self._find_sources_of(p.by_floor, floor) if name in free]
            if above:
                yield f"- {floor} is the floor of {_join_names(above)}."

    def _describe_substance_source(self, source: str, joined_substance_names: str) -> str:
        """Return a verb phrase for an object that gives substances, such as "gives water".

        The actions FILL and SOAK use sources (such objects) that are fixed; POUR and APPLY use movable ones.
        """
        if not self._has_fact(p.fixed, source):
            return f"always holds {joined_substance_names}"
        running = ", while it is switched on" if self._has_fact(p.toggleable, source) else ""
        return f"gives {joined_substance_names}{running}"


class _HouseholdConventionWriter(SceneFactReader):
    """Describes the conventions of a household: facts that never change, such as the tool for a stain."""

    def write_household_convention_lines(self) -> Iterator[str]:
        """Yield a line of text for each rule of the world, such as the tool that removes a stain."""
        yield from map(
            self._describe_ways_to_remove,
            [name for name in self._names if self._find_sources_of(p.has_cover, name)],
        )
        yield from self._describe_heat_and_cold_sources()
        for name in self._names:
            yield from self._describe_products_of_object(name)
        yield from map(self._describe_ingredients_and_method_of_recipe, self._find_objects_with(p.recipe))
        for name in self._names:
            fitting = self._find_targets_of(p.fits, name)
            if fitting:
                yield f"- {name} can be attached to {_join_names(fitting)}."

    def _describe_ways_to_remove(self, substance: str) -> str:
        wiping = {how: self._find_sources_of(manner, substance) for manner, how in _WIPING_WORDS.items()}
        ways = [f"by wiping with {_join_names(tools)} ({how})" for how, tools in wiping.items() if tools]
        washing = self._find_sources_of(p.washes_off, substance)
        solvents = self._find_targets_of(p.dissolved_by, substance)
        if washing:
            ways.append(f"by washing or rinsing in {_join_names(washing)}")
        machines = [
            machine
            for machine in (*self._find_objects_with(p.washer), *self._find_objects_with(p.sink))
            if machine not in washing
        ]
        if solvents and machines:
            ways.append(
                f"by washing or rinsing in {_join_names(machines)} with a solvent in it or on the thing"
            )
        dissolved = f" Its solvents here: {_join_names(solvents)}." if solvents else ""
        return f"- {substance} is removed {'; '.join(ways) or 'by nothing here'}.{dissolved}"

    def _describe_heat_and_cold_sources(self) -> Iterator[str]:
        """Yield sentences that state when sources of heat and cold work, and which objects they change."""
        sources = self._find_objects_with(p.heat_source)
        food = {name for source in sources for name in self._find_targets_of(p.cooks, source)}
        for source in (*sources, *self._find_objects_with(p.cold_source)):
            needs = [words for need, words in _NEED_WORDS.items() if self._has_fact(need, source)]
            cooked, molten = self._find_targets_of(p.cooks, source), self._find_targets_of(p.melts, source)
            all_food = "all food here" if set(cooked) == food else _join_names(cooked)
            effects = [f"cooks {all_food}"] if cooked else []
            effects += [f"melts {_join_names(molten)}"] if molten else []
            effects += (
                ["cools and freezes what can be frozen"] if self._find_targets_of(p.chills, source) else []
            )
            does = f"; it {' and '.join(effects)}" if effects else ""
            yield f"- {source} works {', '.join(needs) or 'always'}{does}."

    def _describe_products_of_object(self, original_object: str) -> Iterator[str]:
        halves = self._find_sources_of(p.part_of, original_object)
        if halves:
            yield f"- SLICE makes {_join_names(halves)} of {original_object}."
        for predicate, words in _MADE_SENTENCES.items():
            made = self._find_targets_of(predicate, original_object)
            if made:
                yield f"- {words.format(_join_names(made), original_object)}"

    def _describe_ingredients_and_method_of_recipe(self, recipe_name: str) -> str:
        vessels = self._find_targets_of(p.made_in, recipe_name)
        sources = self._find_targets_of(p.heated_by, recipe_name)
        if self._has_fact(p.by_stirring, recipe_name):
            how = "by stirring, in any vessel"
        elif self._has_fact(p.by_heat, recipe_name):
            how = f"in {_join_names(vessels, 'or')} by {_join_names(sources, 'or')}"
        else:
            how = f"in {_join_names(vessels, 'or')}, switched on, by RUN"
        toppings = self._describe_ingredients(recipe_name, p.topping)
        bases = _join_names(self._find_targets_of(p.base, recipe_name), "or")
        over = f", with {toppings} on {bases}" if toppings else ""
        results = [word for word, makes in _RESULT_WORDS.items() if self._has_fact(makes, recipe_name)]
        state = f" {_join_names(results)}" if results else ""
        taken = self._describe_ingredients(recipe_name, p.ingredient) or "no ingredients"
        alone = "" if self._has_fact(p.relaxed, recipe_name) else ", and nothing else"
        made = self._find_targets_of(p.makes, recipe_name)
        are = "are" if len(made) > 1 else "is"
        return f"- {_join_names(made)} {are} made{state} {how} of {taken}{over}{alone}."

    def _describe_ingredients(self, recipe: str, role: Predicate) -> str:
        raw, cooked = self._find_targets_of(p.raw, recipe), self._find_targets_of(p.cooked_first, recipe)
        notes = {**dict.fromkeys(raw, " (not cooked)"), **dict.fromkeys(cooked, " (cooked)")}
        return _join_names([f"{name}{notes.get(name, '')}" for name in self._find_targets_of(role, recipe)])


def _join_names(names: Iterable[str], word: str = "and") -> str:
    several: Sequence[str] = list(names)
    return f" {word} ".join([", ".join(several[:-1]), several[-1]]) if len(several) > 1 else "".join(several)
