from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.behavior.kitchen import make_task
from eai.abilities.goal_interpretation.scorer import GoalInterpretation
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.notation.goal_lexicon import write_goals
from eai.abilities.verdict import Confusion, Verdict
from eai.benchmarks.behavior import domain
from eai.benchmarks.behavior.notation import BehaviorGoals
from eai.benchmarks.behavior.tasks import BehaviorTasks
from protocols import of_reference
from sweeps import examples

reference_goals = of_reference("behavior_goals")

TASK = make_task()
DOMAIN = domain.as_meant()
STRICT = GoalInterpretation(TASK, DOMAIN, BehaviorGoals())
REFERENCE = reference_goals.ByFirstOption(TASK)

ALL = [
    ["inside", "peach.n.01_1", "sink.n.01_1"],
    ["not", ["dusty", "plate.n.01_1"]],
    ["not", ["dusty", "plate.n.01_2"]],
    ["nextto", "rag.n.01_1", "rag.n.01_10"],
]
OTHER_WAY = ["inside", "peach.n.01_1", "saucepan.n.01_1"]


def answer(*conditions: Any) -> str:
    return json.dumps({"node goals": [], "edge goals": list(conditions)})


def counts(verdict: Verdict) -> tuple[object, ...]:
    assert verdict.counts is not None
    return verdict.counts["state"], verdict.counts["relation"]


@pytest.mark.parametrize(
    ("conditions", "strict", "reference"),
    [
        ([], ((0, 0, 2), (0, 0, 2)), ((0, 0, 2), (0, 0, 2))),
        (ALL, ((2, 0, 0), (2, 0, 0)), ((2, 0, 0), (2, 0, 0))),
        # Both ways to meet a goal: one is wrong.
        ([ALL[0], OTHER_WAY], ((0, 0, 2), (1, 1, 1)), ((0, 0, 2), (1, 1, 1))),
        # Neighbours the other way round.
        ([["nextto", "rag.n.01_10", "rag.n.01_1"]], ((0, 0, 2), (1, 0, 1)), ((0, 0, 2), (0, 1, 2))),
        # Said twice.
        ([ALL[1], ALL[1]], ((1, 0, 1), (0, 0, 2)), ((1, 0, 1), (0, 0, 2))),
        ([["open", "fridge.n.01_1"]] * 2, ((0, 1, 2), (0, 0, 2)), ((0, 2, 2), (0, 0, 2))),
        # Capitals.
        ([["Inside", "Peach.n.01_1", "SINK.n.01_1"]], ((0, 0, 2), (1, 0, 1)), ((0, 0, 2), (1, 0, 1))),
        # Unknown words are of no kind in the reference, and wrong where a goal is of one.
        ([["broken", "plate.n.01_1"]], ((0, 0, 2), (0, 0, 2)), ((0, 0, 2), (0, 0, 2))),
        ([["open", "moon.n.01_1"]], ((0, 0, 2), (0, 0, 2)), ((0, 1, 2), (0, 0, 2))),
        ([["beats", "a", "b"]], ((0, 0, 2), (0, 0, 2)), ((0, 0, 2), (0, 0, 2))),
        ([["open"]], ((0, 0, 2), (0, 0, 2)), ((0, 1, 2), (0, 0, 2))),
    ],
)  # fmt: skip
def test_counts(conditions: list[Any], strict: Any, reference: Any) -> None:
    text = answer(*conditions)
    assert counts(STRICT.score(text)) == tuple(Confusion(*each) for each in strict)
    assert counts(REFERENCE.score(text)) == tuple(Confusion(*each) for each in reference)


def test_what_is_wrong_with_conditions_is_told() -> None:
    verdict = STRICT.score(answer(["open"], ["open", "moon.n.01_1"], ["broken", "plate.n.01_1"], ALL[0]))
    assert isinstance(verdict, GoalVerdict)
    assert verdict.predicted == 4
    assert verdict.ill_formed == 1
    assert verdict.hallucinated == ("moon.n.01_1", "broken")
    assert verdict.unknown_predicates == ("broken",)
    assert not verdict.aborts
    assert verdict.counts is not None
    assert verdict.counts["all"] == Confusion(1, 0, 3)


@pytest.mark.parametrize(
    ("text", "strict_reads", "reference_reads", "aborts"),
    [
        ("", False, False, False),
        ("{}", True, True, False),
        ('{"a": {"node goals": [["open", "fridge.n.01_1"]]}}', True, True, False),
        ('{"node goals": {"open": "fridge.n.01_1"}}', False, True, False),
        ('{"node goals": null}', True, False, True),
        ('{"node goals": [[]]}', True, False, True),
        ('{"node goals": [["not"]]}', True, False, True),
        ('{"node goals": [7]}', True, False, True),
        ('{"node goals": "ab"}', False, True, False),
    ],
)
def test_what_can_be_read(text: str, strict_reads: bool, reference_reads: bool, aborts: bool) -> None:
    assert (STRICT.score(text).error is None) is strict_reads
    verdict = REFERENCE.score(text)
    assert (verdict.error is None) is reference_reads
    assert isinstance(verdict, GoalVerdict)
    assert verdict.aborts is aborts


def test_explanations_tell_the_option_compared_with_and_what_is_wrong() -> None:
    explanation = STRICT.explain(answer(ALL[0], ["open", "fridge.n.01_1"]))
    assert [note for note in explanation.notes if "goals" not in note] == ["wrong: open(fridge.n.01_1)"]
    assert [(goal.goal, goal.satisfied) for goal in explanation.goals] == [
        ("inside(peach.n.01_1, sink.n.01_1)", True),
        ("not dusty(plate.n.01_1) and not dusty(plate.n.01_2)", False),
        ("nextto(rag.n.01_1, rag.n.01_10)", False),
    ]
    assert STRICT.explain("?").notes[0].startswith("parsing")


def test_the_data_sets_own_goals_are_all_right(behavior_tasks: BehaviorTasks) -> None:
    for task in behavior_tasks.values():
        for option in (0, -1):
            conditions = [condition for goal in task.record.goal_options for condition in goal[option]]
            verdict = GoalInterpretation(task, DOMAIN, BehaviorGoals()).score(answer(*conditions))
            assert verdict.counts is not None
            everything = verdict.counts["all"]
            assert isinstance(everything, Confusion)
            assert everything[1:] == (0, 0)


@settings(max_examples=examples(200), deadline=None)
@given(
    st.one_of(
        st.text(max_size=40), st.lists(st.lists(st.text(max_size=8), max_size=4)).map(lambda c: answer(*c))
    )
)
def test_any_text_has_a_verdict_and_an_explanation(text: str) -> None:
    for scorer in (STRICT, REFERENCE):
        assert scorer.score(text) == scorer.score(text)
        scorer.explain(text)


def test_written_goals_are_all_found(behavior_tasks: BehaviorTasks) -> None:
    notation = BehaviorGoals()
    for task in behavior_tasks.values():
        text = notation.join(write_goals(task, DOMAIN, notation))
        scorers = (GoalInterpretation(task, DOMAIN, notation), reference_goals.ByFirstOption(task))
        for verdict in [scorer.score(text) for scorer in scorers]:
            assert verdict.counts is not None
            _, wrong, missed = verdict.counts["all"]
            assert (wrong, missed) == (0, 0), task.id


def test_states_and_relations_come_in_sections_of_their_own() -> None:
    written = ['["inside", "a.n.01_1", "b.n.01_1"]', '["not", ["open", "b.n.01_1"]]']
    assert json.loads(BehaviorGoals().join(written)) == {
        "node goals": [["not", ["open", "b.n.01_1"]]],
        "edge goals": [["inside", "a.n.01_1", "b.n.01_1"]],
    }
