from __future__ import annotations

from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from abilities.action_sequencing.household import make_task
from eai.abilities.action_sequencing.goals import TaskGoals
from eai.abilities.protocol import Protocol
from eai.abilities.verdict import GoalTallies, Tally

BOTH = pytest.mark.parametrize("protocol", list(Protocol), ids=lambda protocol: protocol.value)
OPEN_FRIDGE = "state OPEN fridge.10"
TWO_RELATIONS = ("relation ONTOP cup.13 table.12", "relation ONTOP bread.14 table.12")


def action_tally(protocol: Protocol, goals: list[str], actions: list[str]) -> Tally:
    task = make_task(goals=[f"action {goal}" for goal in goals])
    return TaskGoals(task, protocol).count(task.initial, actions).action


@BOTH
@pytest.mark.parametrize(
    ("goals", "tallies"),
    [
        (["state CLOSED fridge.10", OPEN_FRIDGE], ((1, 2), (0, 0), (0, 0))),
        (["relation ONTOP cup.13 table.12"], ((0, 0), (1, 1), (0, 0))),
        (["relation ONTOP cup.13 bed.20"], ((0, 0), (0, 1), (0, 0))),
        (["relation INSIDE milk.11 fridge.10", "state ON fridge.10"], ((0, 1), (1, 1), (0, 0))),
        (["action GRAB"], ((0, 0), (0, 0), (0, 1))),
        ([], ((0, 0), (0, 0), (0, 0))),
    ],
)
def test_goals_are_counted_by_kind(
    protocol: Protocol, goals: list[str], tallies: tuple[tuple[int, int], ...]
) -> None:
    task = make_task(goals=goals)
    counted = TaskGoals(task, protocol).count(task.initial, [])
    assert counted == GoalTallies(*(Tally(*tally) for tally in tallies))
    assert counted.all_satisfied == all(satisfied == total for satisfied, total in tallies)


@pytest.mark.parametrize(("protocol", "counted"), [(Protocol.STRICT, 2), (Protocol.EAI_1_0_5, 1)])
def test_quirk_the_first_relation_that_holds_ends_the_count(protocol: Protocol, counted: int) -> None:
    task = make_task(goals=TWO_RELATIONS)
    assert TaskGoals(task, protocol).count(task.initial, []).relation == Tally(counted, 2)


@BOTH
@pytest.mark.parametrize(
    ("goals", "actions", "satisfied"),
    [
        (["GRAB"], [], 0),
        (["GRAB"], ["WALK", "GRAB"], 1),
        (["LOOKAT|WATCH"], ["WATCH"], 1),
        (["LOOKAT|WATCH"], ["LOOKAT"], 1),
        (["LOOKAT|WATCH"], ["READ"], 0),
        (["GRAB", "WASH|RINSE"], ["GRAB", "WALK", "RINSE"], 2),
        (["GRAB", "WASH|RINSE"], ["RINSE", "GRAB"], 1),
        (["GRAB", "WASH"], ["GRAB", "GRAB"], 1),
        (["GRAB", "GRAB"], ["GRAB"], 1),
    ],
)
def test_action_goals_count_in_order(
    protocol: Protocol, goals: list[str], actions: list[str], satisfied: int
) -> None:
    assert action_tally(protocol, goals, actions) == Tally(satisfied, len(goals))


@pytest.mark.parametrize(
    ("goals", "actions", "strict", "reference"),
    [
        # Substrings: the reference finds LOOKAT in LOOKAT_SHORT, and PUT in PUTBACK.
        (["LOOKAT"], ["LOOKAT_SHORT"], 0, 1),
        (["PUT"], ["PUTBACK"], 0, 1),
        # The first alternative that occurs at all counts for the reference, even if another occurs earlier.
        (["A|B", "C"], ["B", "C", "A"], 2, 1),
        # A goal that is never met: the reference does not look at those after it, `strict` does.
        (["GRAB", "WASH"], ["WASH"], 1, 0),
        # The reference takes the goals in the order of hash seed 0, which is the alphabetical one.
        (["TYPE", "SWITCHOFF"], ["TYPE", "SWITCHOFF"], 2, 1),
        (["TYPE", "SWITCHOFF"], ["SWITCHOFF", "TYPE"], 1, 2),
    ],
)
def test_quirks_of_action_goals(goals: list[str], actions: list[str], strict: int, reference: int) -> None:
    assert action_tally(Protocol.STRICT, goals, actions).satisfied == strict
    assert action_tally(Protocol.EAI_1_0_5, goals, actions).satisfied == reference


def test_what_the_data_set_order_would_make_of_it_is_told_where_it_matters() -> None:
    task = make_task(goals=("action TYPE", "action SWITCHOFF"))
    actions = ["TYPE", "SWITCHOFF"]
    goals = TaskGoals(task, Protocol.EAI_1_0_5)
    counted = goals.count(task.initial, actions)
    assert counted.action == Tally(1, 2)
    told = {"data_set_order": {"success": True, "action": [2, 2]}}
    assert goals.in_data_set_order(counted, actions) == told


@pytest.mark.parametrize(
    ("protocol", "goals"),
    [
        (Protocol.STRICT, ("action TYPE", "action SWITCHOFF")),
        (Protocol.EAI_1_0_5, ("action GRAB", "action WASH")),
    ],
)
def test_nothing_is_told_where_the_order_is_that_of_the_data_set(
    protocol: Protocol, goals: tuple[str, ...]
) -> None:
    task = make_task(goals=goals)
    counter = TaskGoals(task, protocol)
    assert counter.in_data_set_order(counter.count(task.initial, []), []) is None


@BOTH
def test_each_goal_by_itself(protocol: Protocol) -> None:
    goals = ("action WASH", *TWO_RELATIONS, OPEN_FRIDGE, "action GRAB")
    task = make_task(goals=goals)
    satisfied = TaskGoals(task, protocol).satisfied(task.initial, ["GRAB", "WASH"])
    assert satisfied == [True, True, True, False, True]


@BOTH
def test_an_answer_that_never_ran_satisfies_none_of_all_goals(protocol: Protocol) -> None:
    task = make_task(goals=(*TWO_RELATIONS, OPEN_FRIDGE, "action GRAB"))
    none = GoalTallies(Tally(0, 1), Tally(0, 2), Tally(0, 1))
    assert TaskGoals(task, protocol).none_satisfied() == none


@given(
    st.lists(st.sampled_from(["A", "B", "A|B", "C"]), max_size=4),
    st.lists(st.sampled_from("ABCD"), max_size=6),
)
def test_under_strict_the_longest_run_of_goals_in_order_counts(goals: list[str], actions: list[str]) -> None:
    def reached(chosen: tuple[int, ...]) -> bool:
        rest = iter(actions)
        return all(any(action in goals[i].split("|") for action in rest) for i in chosen)

    sizes = range(len(goals) + 1)
    best = max(n for n in sizes if any(reached(chosen) for chosen in combinations(range(len(goals)), n)))
    assert action_tally(Protocol.STRICT, goals, actions) == Tally(best, len(goals))


@pytest.mark.parametrize(
    ("actions", "satisfied"),
    [([], 0), (["READ", "GRAB"], 2), (["READ"], 0), (["GRAB", "WALK"], 1), (["WATCH", "READ", "GRAB"], 3)],
)
def test_action_goals_singly_in_any_order_of_the_actions(actions: list[str], satisfied: int) -> None:
    task = make_task(goals=["action GRAB", "action READ", "action LOOKAT|WATCH"])
    counted = TaskGoals(task, Protocol.STRICT).count_actions_singly(actions)
    assert counted == Tally(satisfied, 3)
