"""Make pairs of tasks. In a pair, one task has no plan, or the instruction of one task fits two objects.

In a pair with an impossible task, each task lacks one initial fact, a property of an object. Without its
fact, the impossible task has no plan, as the delete relaxation proves (`eai.planning.possible`). The other
task still has a plan. The missing facts do not show which task is impossible: they have the same predicate,
and goals mention their objects in the same way. The objects have the same category if possible. Otherwise,
their categories occurred in impossible tasks of earlier pairs about as often as in possible tasks.

In a pair with an ambiguous task, the instruction describes the wanted object by its place. In the ambiguous
task a second object of the category is in that place. An answer fails if it also treats the second object as
the instruction asks. An agent that never asks which object is meant is therefore right about half of the
time.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import eai.logic.formula as f
from eai.abilities.reports import fact_text
from eai.base.json_value import Json
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator.measures import make_formula_that_object_x_exists
from eai.benchmarks.generator.scene import (
    add_copy_of_object,
    describe_place_by_relation_and_category,
    has_no_contents,
    list_in_random_order,
)
from eai.benchmarks.generator.spec import GeneratedTask
from eai.benchmarks.generator.usual_goals import UsualGoalsOfDataSet
from eai.benchmarks.generator.words import InstructionWriter
from eai.logic.rewriting import rename_objects
from eai.logic.traversal import find_object_names, get_bound_variables, walk_subformulas
from eai.planning.planner import Planner
from eai.planning.search import Limits
from eai.tasks.goal_test import solves_task
from eai.tasks.planning import find_plan, is_impossible
from eai.tasks.special import AmbiguousTaskMark, PossiblyImpossibleTaskMark
from eai.tasks.task import Goal, Task, goal
from eai.tasks.wording import is_unchanging_object_property
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.state import Fact, State

_HALF = 0.5
"""Probability that the wanted object and its copy, which was added to the scene, exchange their names."""

_LIMITS = Limits(300)
"""Limits of the search for a plan that uses the added copy of an object instead of the object."""

ImpossibleMinusPossibleTasks: TypeAlias = Counter[tuple[str, str]]
"""Property and category -> number of impossible tasks minus number of possible tasks.

Only tasks count from which a fact was removed that stated this property of an object of this category.
"""

PossibleImpossiblePairChooser: TypeAlias = Callable[[ImpossibleMinusPossibleTasks], "GeneratedTask | None"]
"""Function that returns a pair of a possible and an impossible task, or None.

From both tasks, a fact is removed that states a property of an object. Only the impossible task needs its
removed fact. The object's category must not reveal which task is impossible. So the function takes the counts
of earlier pairs by category, and adds the new pair to these counts. The result is None if every pair would
unbalance these counts.
"""


@dataclass(frozen=True, slots=True)
class _TaskPairCandidate:
    """Facts that can be removed from a task to make an impossible and a possible copy of the task.

    All facts have the same predicate (a property), and goals mention their objects in the same way.

    Attributes:
        fact: the fact to remove from the impossible copy. Without this fact, the copy has no plan.
        same: facts about objects of the same category as in `fact`. The possible copy lacks one such fact.
        similar: facts about objects of other categories. If `same` is empty, the possible copy lacks one fact
            in `similar`.
    """

    fact: Fact
    same: Sequence[Fact]
    similar: Sequence[Fact]


def _choose_possible_impossible_pair(
    made: GeneratedTask,
    candidates: Sequence[_TaskPairCandidate],
    rng: random.Random,
    impossible_minus_possible_counts: ImpossibleMinusPossibleTasks,
) -> GeneratedTask | None:
    """Return a pair of tasks, or None if every pair would unbalance the counts of categories."""
    for candidate in candidates:
        kind = _get_property_and_object_category(candidate.fact, made.task)
        partners = candidate.same or [
            other
            for other in candidate.similar
            if impossible_minus_possible_counts[kind]
            <= 0
            <= impossible_minus_possible_counts[_get_property_and_object_category(other, made.task)]
        ]
        if partners:
            other = rng.choice(partners)
            impossible_minus_possible_counts[kind] += 1
            impossible_minus_possible_counts[_get_property_and_object_category(other, made.task)] -= 1
            return _make_possible_task_paired_with_impossible(made, candidate.fact, other, rng)
    return None


def make_possible_impossible_pair_chooser(
    made: GeneratedTask, planner: Planner, removable_properties: Collection[str], rng: random.Random
) -> PossibleImpossiblePairChooser:
    """Return a function that chooses a pair of a task with a plan and a task without a plan.

    The function takes the numbers of impossible minus possible tasks in earlier pairs
    (`ImpossibleMinusPossibleTasks`). Candidates are facts without which the task has no plan. The search for
    candidates stops if the objects of both tasks have the same category. Such a pair can always be used,
    because it leaves the numbers unchanged.

    Args:
        made: a generated task with a plan.
        planner: a planner for the domain. A task counts as impossible only if the planner's heuristic finds
            the goals unreachable.
        removable_properties: properties that objects of the impossible task may lack; any property if empty.
        rng: the random generator.
    """
    task, domain = made.task, planner.domain
    presence_condition, holds = make_formula_that_object_x_exists(domain), planner.heuristic.readings.holds
    properties = _find_removable_facts(task, domain, removable_properties)
    facts = [fact for fact in properties if holds(presence_condition, {"x": fact.arguments[0]}, task.initial)]
    rng.shuffle(facts)
    needed = [fact for fact in facts if not solves_task(domain, _remove_fact(task, fact), task.script)]
    others = [fact for fact in facts if fact not in needed]
    roles = {fact: _make_fact_similarity_key(fact, task) for fact in facts}
    candidates: list[_TaskPairCandidate] = []
    for fact in needed:
        kind, lacking = _get_property_and_object_category(fact, task), _remove_fact(task, fact)
        similar = [other for other in others if roles[other] == roles[fact]]
        if not similar or _looks_solvable(lacking, planner) or not is_impossible(lacking, domain):
            continue
        same = [other for other in similar if _get_property_and_object_category(other, task) == kind]
        candidates.append(_TaskPairCandidate(fact, same, [] if same else similar))
        if same:
            break
    return partial(_choose_possible_impossible_pair, made, candidates, rng)


def _looks_solvable(task: Task, planner: Planner) -> bool:
    goals = (formula.formula for formula in task.goals)
    return all(
        planner.looks_reachable(task.initial, formula, task.planning_object_indices) for formula in goals
    )


def _find_removable_facts(
    task: Task, domain: Domain, removable_properties: Collection[str]
) -> Iterator[Fact]:
    """Yield the initial facts that state a removable property of an object, if prompts show this property.

    If `removable_properties` is empty, all properties are removable.
    """
    predicates = {
        p.name for p in domain.vocabulary.predicates if p.visible and is_unchanging_object_property(p)
    }
    for fact in task.initial.facts():
        if fact.predicate in predicates and (
            not removable_properties or fact.predicate in removable_properties
        ):
            yield fact


def _make_fact_similarity_key(fact: Fact, task: Task) -> tuple[str, bool, bool]:
    """Return a key that is equal for facts with the same property about objects with the same role in goals.

    The key tells the property, whether goals name the object, and whether goals quantify over its category.
    """
    (thing,) = fact.arguments
    parts = (part for task_goal in task.goals for part in walk_subformulas(task_goal.formula))
    kinds = {variable.category for part in parts for variable in get_bound_variables(part)}
    return (
        fact.predicate,
        thing in task.find_objects_named_in_goals(task.goals),
        _get_property_and_object_category(fact, task)[1] in kinds,
    )


def _get_property_and_object_category(fact: Fact, task: Task) -> tuple[str, str]:
    """Return the property that a fact states, and the category of its object."""
    return fact.predicate, task.scene.objects[fact.arguments[0]].category


def _remove_fact(task: Task, fact: Fact) -> Task:
    return replace(task, initial=task.scene.state(other for other in task.initial.facts() if other != fact))


def _make_shuffled_ids_for_task_pair(task: Task, rng: random.Random) -> list[str]:
    """Return the ids of the two tasks of a pair in random order."""
    return rng.sample([f"{task.id}-a", f"{task.id}-b"], 2)


def _make_possible_task_paired_with_impossible(
    made: GeneratedTask, needed_fact: Fact, needless_fact: Fact, rng: random.Random
) -> GeneratedTask:
    task, scene, names = made.task, made.task.scene, _make_shuffled_ids_for_task_pair(made.task, rng)
    solved = replace(
        _remove_fact(task, needless_fact), id=names[0], title=task.id, special=PossiblyImpossibleTaskMark(())
    )
    missing = PossiblyImpossibleTaskMark((fact_text(needed_fact, scene),))
    unsolved = replace(
        _remove_fact(task, needed_fact), id=names[1], title=task.id, script=(), special=missing
    )
    lacks: Mapping[str, Json] = {**made.about, "lacks": fact_text(needless_fact, scene)}
    return GeneratedTask(solved, lacks, GeneratedTask(unsolved, made.about))


def make_unambiguous_task_paired_with_ambiguous(
    made: GeneratedTask,
    benchmark: Benchmark,
    usual_goals: UsualGoalsOfDataSet,
    planner: Planner,
    rng: random.Random,
) -> GeneratedTask | None:
    """Return two tasks with one instruction. It fits one object in the first task, and two in the second.

    Return None if no such tasks are found.

    Args:
        made: a generated task with a plan.
        benchmark: the benchmark of the task.
        usual_goals: the usual places of objects.
        planner: a planner for the benchmark's domain.
        rng: the random generator.
    """
    task, kinds = made.task, [thing.category for thing in made.task.scene.objects]
    hosts = [
        i
        for i in task.relevant
        if kinds[i] in usual_goals.taken_categories
        and describe_place_by_relation_and_category(i, task.initial, usual_goals)
    ]
    named = task.find_objects_named_in_goals(task.goals)
    for thing in list_in_random_order(
        [i for i in hosts if i in named and has_no_contents(i, task.initial, usual_goals)], rng
    ):
        beside = add_copy_of_object(task.initial, usual_goals, thing, thing)
        seen = InstructionWriter.make_writer_for_benchmark(
            benchmark, beside, distinguishes_objects_by_place=True
        ).initial_facts
        for host in list_in_random_order(hosts, rng):
            apart = add_copy_of_object(task.initial, usual_goals, thing, host)
            words = InstructionWriter.make_writer_for_benchmark(
                benchmark, apart, distinguishes_objects_by_place=True
            )
            if _are_object_and_copy_in_described_place(words, seen, thing):
                pair = _make_tasks_with_same_instruction(task, words, (apart, beside), thing, rng)
                if pair is not None and _are_goals_reachable_with_object_and_copy(*pair, thing, planner):
                    return GeneratedTask(pair[0], made.about, GeneratedTask(pair[1], made.about))
                break
    return None


def _are_object_and_copy_in_described_place(
    words: InstructionWriter, known_facts: Iterable[Fact], obj: int
) -> bool:
    """Whether an object and its copy are both in the place by which instructions describe the object.

    The copy is the last object of the scene. `known_facts` state where objects are. The result is False if
    instructions do not describe the object by its place.
    """
    said = words.distinguishing_fact_by_object.get(obj)
    if said is None or len(said.arguments) == 1:
        return False
    place = said.arguments[1:]
    there = {
        other_fact[1][0]
        for other_fact in known_facts
        if (other_fact[0], other_fact[1][1:]) == (said.predicate, place)
    }
    return {obj, len(words.scene.objects) - 1} <= there


def _make_tasks_with_same_instruction(
    task: Task, words: InstructionWriter, two_states: tuple[State, State], obj: int, rng: random.Random
) -> tuple[Task, Task] | None:
    """Return a clear and an ambiguous task with one instruction.

    Return None if the written instruction cannot be read back as the goals of the task.
    """
    ids = _make_shuffled_ids_for_task_pair(task, rng)
    formulas = [task_goal.formula for task_goal in task.goals]
    instruction = words.make_instruction(formulas, rng)
    if not words.does_instruction_state_exactly_goals(instruction, formulas):
        return None
    initial, unclear_initial = two_states
    names = (task.scene.objects[obj].name, initial.scene.objects[-1].name)
    clear = replace(
        task,
        id=ids[0],
        title=task.id,
        instruction=instruction,
        initial=initial,
        goals=(*task.goals, _negate_goals_for_copied_object(task.goals, names)),
        relevant=(*task.relevant, len(task.scene.objects)),
    )
    unclear = replace(clear, id=ids[1], initial=unclear_initial)
    if rng.random() < _HALF:
        clear = _exchange_names_of_two_objects(clear, names)
        unclear = _exchange_names_of_two_objects(unclear, names)
        names = names[::-1]
    return replace(clear, special=AmbiguousTaskMark(names[:1])), replace(
        unclear, special=AmbiguousTaskMark(names)
    )


def _exchange_names_of_two_objects(task: Task, two_names: Sequence[str]) -> Task:
    """Return a task in which two objects exchange names, so that names do not reveal the wanted object."""
    scene, swapped = task.scene, _map_two_names_to_each_other(two_names)
    index = {scene.index[name]: scene.index[other] for name, other in swapped.items()}

    def exchange_two_objects_in_arguments(arguments: Sequence[int]) -> tuple[int, ...]:
        return tuple([index.get(i, i) for i in arguments])

    return replace(
        task,
        initial=scene.state(
            Fact(fact.predicate, exchange_two_objects_in_arguments(fact.arguments))
            for fact in task.initial.facts()
        ),
        goals=_exchange_two_object_names_in_goals(task.goals, two_names),
        script=tuple(
            [Action(step.operator, exchange_two_objects_in_arguments(step.arguments)) for step in task.script]
        ),
    )


def _negate_goals_for_copied_object(goals: Sequence[Goal], object_and_copy_names: Sequence[str]) -> Goal:
    """Return the negation of the goals about the first object, with the second object in its place."""
    asked = [
        task_goal for task_goal in goals if object_and_copy_names[0] in find_object_names(task_goal.formula)
    ]
    done = tuple(
        [task_goal.formula for task_goal in _exchange_two_object_names_in_goals(asked, object_and_copy_names)]
    )
    return goal(f.Not(done[0] if len(done) == 1 else f.And(done)))


def _exchange_two_object_names_in_goals(goals: Iterable[Goal], two_names: Sequence[str]) -> tuple[Goal, ...]:
    return tuple(
        [
            goal(rename_objects(task_goal.formula, _map_two_names_to_each_other(two_names)))
            for task_goal in goals
        ]
    )


def _map_two_names_to_each_other(names: Sequence[str]) -> Mapping[str, str]:
    return dict(zip(names, reversed(names), strict=True))


def _are_goals_reachable_with_object_and_copy(
    clear_task: Task, ambiguous_task: Task, obj: int, planner: Planner
) -> bool:
    """Whether both tasks are solved by their plans, and the ambiguous task has a plan for either object.

    The instruction of the ambiguous task fits two objects: `obj` and its copy, the last object of the scene.
    The plan of the task uses `obj`. A plan must also be found for goals in which the copy and `obj` are
    exchanged.
    """
    names = [ambiguous_task.scene.objects[i].name for i in (obj, -1)]
    other = replace(ambiguous_task, goals=_exchange_two_object_names_in_goals(ambiguous_task.goals, names))
    each_solves = (solves_task(planner.domain, task, task.script) for task in (clear_task, ambiguous_task))
    return all(each_solves) and bool(find_plan(other, planner, _LIMITS).plan)
