from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.behavior.kitchen import make_task
from eai.abilities.goal_interpretation.scorer import GoalInterpretationScorer
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.notation.goal_lexicon import write_goals
from eai.abilities.scorer import Scorer
from eai.abilities.verdict import ConfusionCounts, Verdict
from eai.benchmarks.behavior import domain
from eai.benchmarks.behavior.notation import BehaviorGoalNotation
from eai.benchmarks.behavior.tasks import BehaviorTask, BehaviorTasks
from sweeps import examples

TASK = make_task()
DOMAIN = domain.make_domain_with_checks_in_paper_order()
STRICT = GoalInterpretationScorer(TASK, DOMAIN, BehaviorGoalNotation())

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


COUNTS = [
        ([], ((0, 0, 2), (0, 0, 2))),
        (ALL, ((2, 0, 0), (2, 0, 0))),
        # Both options of a goal: one counts as wrong.
        ([ALL[0], OTHER_WAY], ((0, 0, 2), (1, 1, 1))),
        # Neighbours in the other order.
        ([["nextto", "rag.n.01_10", "rag.n.01_1"]], ((0, 0, 2), (1, 0, 1))),
        # A condition stated twice.
        ([ALL[1], ALL[1]], ((1, 0, 1), (0, 0, 2))),
        ([["open", "fridge.n.01_1"]] * 2, ((0, 1, 2), (0, 0, 2))),
        # Capitals.
        ([["Inside", "Peach.n.01_1", "SINK.n.01_1"]], ((0, 0, 2), (1, 0, 1))),
        # Unknown words.
        ([["broken", "plate.n.01_1"]], ((0, 0, 2), (0, 0, 2))),
        ([["open", "moon.n.01_1"]], ((0, 0, 2), (0, 0, 2))),
        ([["beats", "a", "b"]], ((0, 0, 2), (0, 0, 2))),
        ([["open"]], ((0, 0, 2), (0, 0, 2))),
    ]  # fmt: skip


@pytest.mark.parametrize(("conditions", "expected"), COUNTS)
def test_an_answer_has_its_counts_of_goals(conditions: list[Any], expected: Any) -> None:
    assert counts(STRICT.score(answer(*conditions))) == tuple(
        ConfusionCounts(*numbers) for numbers in expected
    )


def test_a_verdict_lists_ill_formed_and_hallucinated_conditions() -> None:
    verdict = STRICT.score(answer(["open"], ["open", "moon.n.01_1"], ["broken", "plate.n.01_1"], ALL[0]))
    assert isinstance(verdict, GoalVerdict)
    assert verdict.predicted == 4
    assert verdict.ill_formed == 1
    assert verdict.hallucinated == ("moon.n.01_1", "broken")
    assert verdict.unknown_predicates == ("broken",)
    assert not verdict.aborts
    assert verdict.counts is not None
    assert verdict.counts["all"] == ConfusionCounts(1, 0, 3)


@pytest.mark.parametrize(
    ("text", "is_read"),
    [
        ("", False),
        ("{}", True),
        ('{"a": {"node goals": [["open", "fridge.n.01_1"]]}}', True),
        ('{"node goals": {"open": "fridge.n.01_1"}}', False),
        ('{"node goals": null}', True),
        ('{"node goals": [[]]}', True),
        ('{"node goals": [["not"]]}', True),
        ('{"node goals": [7]}', True),
        ('{"node goals": "ab"}', False),
    ],
)
def test_sections_must_be_lists_or_null(text: str, is_read: bool) -> None:
    assert (STRICT.score(text).error is None) is is_read


def test_an_explanation_shows_the_compared_option_and_wrong_conditions() -> None:
    explanation = STRICT.explain(answer(ALL[0], ["open", "fridge.n.01_1"]))
    assert [note for note in explanation.notes if "goals" not in note] == ["wrong: open(fridge.n.01_1)"]
    assert [(goal.goal, goal.satisfied) for goal in explanation.goals] == [
        ("inside(peach.n.01_1, sink.n.01_1)", True),
        ("not dusty(plate.n.01_1) and not dusty(plate.n.01_2)", False),
        ("nextto(rag.n.01_1, rag.n.01_10)", False),
    ]
    assert STRICT.explain("?").notes[0].startswith("parsing")


def test_the_goals_of_the_data_set_score_in_full(behavior_tasks: BehaviorTasks) -> None:
    for task in behavior_tasks.values():
        for option in (0, -1):
            conditions = [condition for goal in task.record.goal_options for condition in goal[option]]
            verdict = GoalInterpretationScorer(task, DOMAIN, BehaviorGoalNotation()).score(
                answer(*conditions)
            )
            assert verdict.counts is not None
            total = verdict.counts["all"]
            assert isinstance(total, ConfusionCounts)
            assert total[1:] == (0, 0)


TEXTS = st.one_of(
    st.text(max_size=40), st.lists(st.lists(st.text(max_size=8), max_size=4)).map(lambda c: answer(*c))
)


@settings(max_examples=examples(200), deadline=None)
@given(TEXTS)
def test_any_text_has_a_verdict_and_an_explanation(text: str) -> None:
    assert STRICT.score(text) == STRICT.score(text)
    STRICT.explain(text)


@pytest.fixture
def scorer_of() -> Callable[[BehaviorTask], Scorer]:
    """Return the maker of scorers under `strict`. Tests of other protocols override this fixture."""
    return lambda task: GoalInterpretationScorer(task, DOMAIN, BehaviorGoalNotation())


def test_written_goals_score_in_full(
    behavior_tasks: BehaviorTasks, scorer_of: Callable[[BehaviorTask], Scorer]
) -> None:
    notation = BehaviorGoalNotation()
    for task in behavior_tasks.values():
        text = notation.join(write_goals(task, DOMAIN, notation))
        verdict = scorer_of(task).score(text)
        assert verdict.counts is not None
        _, wrong, missed = verdict.counts["all"]
        assert (wrong, missed) == (0, 0), task.id


def test_states_and_relations_are_written_in_separate_sections() -> None:
    written = ['["inside", "a.n.01_1", "b.n.01_1"]', '["not", ["open", "b.n.01_1"]]']
    assert json.loads(BehaviorGoalNotation().join(written)) == {
        "node goals": [["not", ["open", "b.n.01_1"]]],
        "edge goals": [["inside", "a.n.01_1", "b.n.01_1"]],
    }
