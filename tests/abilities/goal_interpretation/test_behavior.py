from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.behavior.kitchen import make_task
from eai.abilities.goal_interpretation.behavior import GoalInterpretation
from eai.abilities.protocol import Protocol
from eai.abilities.verdict import Confusion, Verdict
from eai.benchmarks.behavior.tasks import BehaviorTasks
from oracle import MODELS, Oracle

TASK = make_task()
STRICT, REFERENCE = (GoalInterpretation(TASK, protocol) for protocol in (Protocol.STRICT, Protocol.EAI_1_0_5))

SETS = (*MODELS, "gt_lastoption", "gt_option0", "perturb0", "perturb1")

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
        # Unknown words are of no kind in the reference.
        ([["broken", "plate.n.01_1"]], ((0, 1, 2), (0, 0, 2)), ((0, 0, 2), (0, 0, 2))),
        ([["beats", "a", "b"]], ((0, 0, 2), (0, 1, 2)), ((0, 0, 2), (0, 0, 2))),
        ([["open"]], ((0, 1, 2), (0, 0, 2)), ((0, 1, 2), (0, 0, 2))),
    ],
)  # fmt: skip
def test_counts(conditions: list[Any], strict: Any, reference: Any) -> None:
    text = answer(*conditions)
    assert counts(STRICT.score(text)) == tuple(Confusion(*each) for each in strict)
    assert counts(REFERENCE.score(text)) == tuple(Confusion(*each) for each in reference)


def test_what_is_wrong_with_conditions_is_told() -> None:
    verdict = STRICT.score(answer(["open"], ["open", "moon.n.01_1"], ["broken", "plate.n.01_1"], ALL[0]))
    assert verdict.details == {
        "predicted": 4,
        "ill_formed": 1,
        "hallucinated": ["moon.n.01_1"],
        "unknown_predicates": ["broken"],
        "aborts": False,
    }
    assert verdict.counts is not None
    assert verdict.counts["all"] == Confusion(1, 3, 3)


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
    assert verdict.details is not None
    assert verdict.details["aborts"] is aborts


def test_explanations_tell_the_option_compared_with_and_what_is_wrong() -> None:
    explanation = STRICT.explain(answer(ALL[0], ["open", "fridge.n.01_1"]))
    assert explanation.notes == ("wrong: open(fridge.n.01_1)",)
    assert [(goal.goal, goal.satisfied) for goal in explanation.goals] == [
        ("inside(peach.n.01_1, sink.n.01_1)", True),
        ("not dusty(plate.n.01_1) and not dusty(plate.n.01_2)", False),
        ("nextto(rag.n.01_1, rag.n.01_10)", False),
    ]
    assert STRICT.explain("?").notes[0].startswith("parsing")


def told_by_reference(part: dict[str, int]) -> Confusion:
    return Confusion(
        part["num_satisfied_conditions"],
        part["num_false_positive_conditions"],
        part["num_unsatisfied_conditions"],
    )


@pytest.mark.parametrize("name", SETS)
def test_every_row_has_the_references_counts(
    behavior_tasks: BehaviorTasks, oracle: Oracle, name: str
) -> None:
    content = oracle("behavior", "goal_interpretation", name)
    errors = {"format_error_num": 0, "state_hallucination_num": 0, "object_hallucination_num": 0}
    for row in content["records"]:
        task = behavior_tasks[row["identifier"]]
        verdict = GoalInterpretation(task, Protocol.EAI_1_0_5).score(row["response"])
        parts = {"all": "overall", "state": "state_goal", "relation": "relation_goal"}
        expected = {key: told_by_reference(row["verdict"][part]) for key, part in parts.items()}
        assert (row["identifier"], verdict.counts) == (row["identifier"], expected)
        details: Any = verdict.details
        errors["format_error_num"] += details["ill_formed"]
        errors["state_hallucination_num"] += len(details["unknown_predicates"])
        errors["object_hallucination_num"] += len(details["hallucinated"])
    assert {key: content["summary"]["grammatical_errors"][key] for key in errors} == errors


def test_the_data_sets_own_goals_are_all_right(behavior_tasks: BehaviorTasks) -> None:
    for task in behavior_tasks.values():
        for option in (0, -1):
            conditions = [condition for goal in task.interpretation_goals for condition in goal[option]]
            verdict = GoalInterpretation(task, Protocol.STRICT).score(answer(*conditions))
            assert verdict.counts is not None
            everything = verdict.counts["all"]
            assert isinstance(everything, Confusion)
            assert everything[1:] == (0, 0)


@settings(max_examples=200, deadline=None)
@given(
    st.one_of(
        st.text(max_size=40), st.lists(st.lists(st.text(max_size=8), max_size=4)).map(lambda c: answer(*c))
    )
)
def test_any_text_has_a_verdict_and_an_explanation(text: str) -> None:
    for scorer in (STRICT, REFERENCE):
        assert scorer.score(text) == scorer.score(text)
        scorer.explain(text)
