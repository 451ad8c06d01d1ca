"""The definitions of the 2026 challenge agree with published facts about them, and their gold plans work."""

from __future__ import annotations

from pathlib import Path

import pytest

import eai.logic.formula as f
from eai.base.errors import DataError
from eai.base.store import DataPackStore
from eai.benchmarks.behavior_1k.benchmark import behavior_1k_challenge_2025, behavior_1k_challenge_2026
from eai.benchmarks.behavior_1k.challenge import (
    _ActivityAmendment,
    _amend_activity_definition,
    amend_definitions_for_challenge,
    load_activities_of_challenge_2026,
    load_activity_amendments,
)
from eai.benchmarks.behavior_1k.checkout import FILE, read_activity_definitions
from eai.benchmarks.behavior_1k.kinds import ACTIVITIES, PACK, get_lemma
from eai.benchmarks.behavior_1k.tasks import split_by_activity
from eai.benchmarks.packs import open_pack
from eai.logic.traversal import get_bound_variables, walk_subformulas
from eai.pddl.bddl import parse_problem
from eai.tasks.goal_test import GoalTest, solves_task
from eai.tasks.source import Source, TaskSet
from eai.tasks.task import Task
from sweeps import every

FACTS = Path(__file__).with_name("challenge_2026.txt")
LEFT_OUT = "sorting_household_items"

OTHERWISE_COUNTED = {
    "installing_a_fax_machine": "the published number counts a name that ends with _*",
    "halve_an_egg": "the published facts cut the kind hard-boiled_egg at its hyphen",
}


@pytest.fixture(scope="module")
def tasks(activity_store: DataPackStore) -> TaskSet[Task]:
    return behavior_1k_challenge_2026().tasks(Source(store=activity_store))


def facts_of(definition: str) -> list[str]:
    """Return the published facts of a definition, in the columns of the file."""
    problem = parse_problem(definition)
    kinds = {item.name: item.type for item in problem.objects}
    atoms, in_goal = set(), set()
    for part in walk_subformulas(problem.goal):
        in_goal |= {str(variable.category) for variable in get_bound_variables(part)}
        if isinstance(part, f.Atom):
            atoms.add(part.predicate)
            in_goal |= {kinds[term.name] for term in part.arguments if isinstance(term, f.Constant)}
    numbers = len(f.get_operands(problem.goal, f.And)), len(set(kinds.values())), len(kinds)
    return [*map(str, numbers), " ".join(sorted(atoms)), " ".join(sorted(map(get_lemma, in_goal)))]


def test_each_definition_has_the_published_facts(activity_store: DataPackStore) -> None:
    definitions, _ = load_activities_of_challenge_2026(Source(store=activity_store))
    lines = [line.split("|") for line in FACTS.read_text().splitlines() if not line.startswith("#")]
    assert sorted(definitions) == sorted(name for name, *_ in lines)
    different = {name for name, *facts in lines if facts_of(definitions[name]) != facts}
    assert different == set(OTHERWISE_COUNTED)


def test_the_first_fifty_are_those_of_2025_and_one_name_is_spelt_anew(
    tasks: TaskSet[Task], activity_store: DataPackStore
) -> None:
    names = list(tasks)
    assert len(names) == len(set(names)) == 100
    assert names[:50] == list(behavior_1k_challenge_2025().tasks(Source(store=activity_store)))
    assert names[75] == "put_together_a_basic_pruning_kit"


def test_a_checkout_with_these_definitions_is_not_damaged(
    activity_store: DataPackStore, tmp_path: Path
) -> None:
    definitions, _ = load_activities_of_challenge_2026(Source(store=activity_store))
    for name, text in definitions.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / FILE).write_text(text)
    assert read_activity_definitions(tmp_path).keys() == definitions.keys()


@every(10)
def test_gold_plans_reach_goals_that_do_not_hold_at_the_start(tasks: TaskSet[Task], every: int) -> None:
    domain = behavior_1k_challenge_2026().domain
    for name in list(tasks)[::every]:
        task = tasks[name]
        assert (task.unsolvable is not None) == (name == LEFT_OUT)
        assert not all(GoalTest(task).evaluate_each_goal(task.initial, [], [task.initial]))
        assert task.unsolvable or solves_task(domain, task, task.script), name


def test_unchanged_definitions_keep_the_data_s_text(activity_store: DataPackStore) -> None:
    packed = split_by_activity(open_pack(PACK, Source(store=activity_store)).read_member(ACTIVITIES))
    definitions, amended = amend_definitions_for_challenge(packed), load_activity_amendments().activities
    assert len(amended) == 50
    assert all(definitions[name] == packed[name] for name in definitions if name not in amended)


def test_an_amendment_changes_objects_facts_and_goal() -> None:
    text = (
        "(define (problem p-0) (:domain d) (:objects cup.n.01_1 cup.n.01_2 - cup.n.01 "
        "mat.n.01_1 - mat.n.01 ) (:init (ontop cup.n.01_1 mat.n.01_1) (not (open cup.n.01_1) ) "
        "(ontop cup.n.01_2 mat.n.01_1) ) "
        "(:goal (and (open ?cup.n.01_1) ) ) )"
    )
    amendment = _ActivityAmendment(
        objects={"cup.n.01": 1, "jar.n.01": 2},
        drop=frozenset(["(not (open cup.n.01_1))"]),
        add=["(ontop jar.n.01_2 mat.n.01_1)"],
        goal="\n(and\n  (open jar.n.01_1))",
    )
    assert _amend_activity_definition("p", {"p": text}, amendment) == (
        "(define (problem p-0) (:domain d) "
        "(:objects cup.n.01_1 - cup.n.01 mat.n.01_1 - mat.n.01 jar.n.01_1 jar.n.01_2 - jar.n.01) "
        "(:init (ontop cup.n.01_1 mat.n.01_1) (ontop jar.n.01_2 mat.n.01_1)) (:goal (and (open jar.n.01_1))))"
    )
    with pytest.raises(DataError, match=r"p: the definition of bddl 3\.6\.0 lacks \(wet cup\.n\.01_1\)"):
        _amend_activity_definition("p", {"p": text}, _ActivityAmendment(drop=frozenset(["(wet cup.n.01_1)"])))
