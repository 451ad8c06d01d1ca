from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from abilities.goal_interpretation.lamps import DOMAIN, OBJECTS, atom, make_task
from eai.abilities.declaration import AnswerOutcome
from eai.abilities.goal_interpretation.declaration import GOAL_INTERPRETATION
from eai.abilities.goal_interpretation.scorer import GoalInterpretationScorer
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.notation.goal_lexicon import write_goals
from eai.abilities.notation.goals import JsonGoalNotation
from eai.abilities.verdict import ConfusionCounts
from eai.logic.formula import FALSE, Eventually, Or
from eai.tasks.task import Task
from eai.world.fault import FaultKind

SCORER = GoalInterpretationScorer(make_task(), DOMAIN, JsonGoalNotation())

LAMPS = [["lit", "lamp_0"], ["lit", "lamp_1"]]
SHUT = ["not", ["open", "box_0"]]


class ByCategory(JsonGoalNotation):
    """A notation in which several objects share a name."""

    symmetric = frozenset({"together"})

    def list_object_names(self, task: Task) -> tuple[str, ...]:
        return tuple(thing.category for thing in task.scene.objects)


def answer(states: object = (), relations: object = (), actions: object = ()) -> str:
    return json.dumps({"node goals": states, "edge goals": relations, "action goals": actions})


def judge(text: str, scorer: GoalInterpretationScorer = SCORER) -> GoalVerdict:
    verdict = scorer.score(text)
    assert isinstance(verdict, GoalVerdict)
    return verdict


def counts(text: str, scorer: GoalInterpretationScorer = SCORER) -> tuple[object, ...]:
    found: Any = judge(text, scorer).counts
    parts = tuple(tuple(found[kind]) for kind in ("state", "relation", "action"))
    assert found["all"] == ConfusionCounts(*map(sum, zip(*parts, strict=True)))
    return parts


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (answer(), ((0, 0, 3), (0, 0, 1), (0, 0, 1))),
        # A goal for all lamps has one condition for each lamp.
        (answer([*LAMPS, SHUT]), ((3, 0, 0), (0, 0, 1), (0, 0, 1))),
        (answer([LAMPS[1]]), ((1, 0, 2), (0, 0, 1), (0, 0, 1))),
        # A negated goal and its opposite.
        (answer([SHUT]), ((1, 0, 2), (0, 0, 1), (0, 0, 1))),
        (answer([["open", "box_0"]]), ((0, 1, 3), (0, 0, 1), (0, 0, 1))),
        # One of the boxes is enough; stating both is wrong.
        (answer(relations=[["inside", "ball_0", "box_1"]]), ((0, 0, 3), (1, 0, 0), (0, 0, 1))),
        (
            answer(relations=[["inside", "ball_0", "box_1"], ["inside", "ball_0", "box_0"]]),
            ((0, 0, 3), (1, 1, 0), (0, 0, 1)),
        ),
        # One of the actions is enough.
        (answer(actions=["OPEN"]), ((0, 0, 3), (0, 0, 1), (1, 0, 0))),
        (answer(actions=["OPEN", "PRESS", "FLY"]), ((0, 0, 3), (0, 0, 1), (1, 1, 0))),
        (answer(actions=[["OPEN", "box_0"]]), ((0, 0, 3), (0, 0, 1), (0, 1, 1))),
        # Said again.
        (answer([*LAMPS, *LAMPS, ["open", "box_1"], ["open", "box_1"]]), ((2, 1, 1), (0, 0, 1), (0, 0, 1))),
        # Unknown names and ill-formed goals are neither right nor wrong.
        (answer([["lit", "sun"], ["shiny", "box_0"], ["open"]]), ((0, 0, 3), (0, 0, 1), (0, 0, 1))),
        (answer([*LAMPS, SHUT, ["lit", "sun"], ["lit", "sun"]]), ((3, 0, 0), (0, 0, 1), (0, 0, 1))),
        (answer(relations=[["beats", "box_0", "box_1"], 7]), ((0, 0, 3), (0, 0, 1), (0, 0, 1))),
        (answer([["lit", "lamp_0", "lamp_1"]]), ((0, 0, 3), (0, 0, 1), (0, 0, 1))),
        # The predicate decides on the kind, not the section.
        (answer(relations=LAMPS), ((2, 0, 1), (0, 0, 1), (0, 0, 1))),
        (answer([["inside", "ball_0", "box_0"]]), ((0, 0, 3), (1, 0, 0), (0, 0, 1))),
        ("Light all lamps.", ((0, 0, 3), (0, 0, 1), (0, 0, 1))),
    ],
)
def test_right_wrong_and_missed_goals_are_counted(text: str, expected: tuple[object, ...]) -> None:
    assert counts(text) == expected


def test_an_explanation_names_the_defects_of_goals() -> None:
    verdict = judge(answer([["lit", "sun"], ["shiny", "box_0"], ["open"], 7], actions=["FLY"]))
    assert verdict.predicted == 5
    assert verdict.ill_formed == 2
    assert verdict.hallucinated == ("sun", "shiny", "FLY")
    assert verdict.unknown_predicates == ("shiny",)


def test_left_out_goals_have_their_own_rate_and_prevent_success() -> None:
    whole = answer([*LAMPS, SHUT], [["inside", "ball_0", "box_1"]], ["OPEN"])
    with_sun = answer([*LAMPS, SHUT, ["lit", "sun"], ["lit"]], [["inside", "ball_0", "box_1"]], ["OPEN"])
    shares = GOAL_INTERPRETATION.contributions(judge(with_sun))
    assert shares["overall.f1"] == GOAL_INTERPRETATION.contributions(judge(whole))["overall.f1"] == (10, 10)
    assert (shares["hallucination"], shares["ill_formed"]) == ((1, 7), (1, 7))
    assert GOAL_INTERPRETATION.outcome(judge(whole)) is AnswerOutcome.SUCCESS
    assert GOAL_INTERPRETATION.outcome(judge(with_sun)) is AnswerOutcome.PARTLY_RIGHT


def test_static_and_hidden_predicates_are_no_goals() -> None:
    verdict = judge(answer([["heavy", "box_0"], ["memory", "box_0"], ["together", "box_0", "ball_0"]]))
    assert verdict.unknown_predicates == ("heavy", "memory")


def test_an_unreadable_answer_is_a_parsing_error() -> None:
    verdict = judge("Light all lamps.")
    assert verdict.error is not None
    assert verdict.error.kind is FaultKind.PARSING
    assert SCORER.explain("Light all lamps.").notes[0].startswith("parsing: ")


def test_an_explanation_names_wrong_and_met_goals() -> None:
    text = f"Sure! {answer([*LAMPS, ['lit', 'sun'], ['open', 'box_0'], ['open']], actions=['OPEN'])}"
    explanation = SCORER.explain(text)
    assert explanation.notes == (
        "read with repair: prose",
        "left out as ill-formed: open()",
        "left out as hallucination: lit(sun), there is no sun",
        "state goals: 2 right, 1 wrong, 1 missed",
        "relation goals: 0 right, 0 wrong, 1 missed",
        "action goals: 1 right, 0 wrong, 0 missed",
        "wrong: open(box_0)",
    )
    assert [(goal.kind, goal.satisfied) for goal in explanation.goals] == [
        ("state", True),
        ("state", False),
        ("relation", False),
        ("action", True),
    ]
    assert explanation.goals[3].goal == "PRESS or OPEN"


@pytest.mark.parametrize(
    "said",
    [[], LAMPS, [LAMPS[0], LAMPS[0]], [*LAMPS, SHUT, ["lit", "sun"], ["open"], ["lit"], ["open", "box_1"]]],
)
def test_the_atoms_of_an_explanation_are_the_counted_goals(said: list[object]) -> None:
    verdict = judge(answer(said, actions=["OPEN", "GO"]))
    assert verdict.counts is not None
    atoms = (verdict.matched, verdict.wrong, verdict.missing)
    assert ConfusionCounts(*map(len, atoms)) == verdict.counts["all"]


def test_right_wrong_and_missing_goals_are_listed() -> None:
    said = [LAMPS[0], ["lit", "sun"], ["open"], ["open", "box_0"]]
    verdict = judge(answer(said, actions=["OPEN", "OPEN"]))
    assert verdict.matched == ("lit(lamp_0)", "OPEN")
    assert verdict.wrong == ("open(box_0)",), "what is ill-formed or unknown is left out"
    assert verdict.missing[:2] == ("lit(lamp_1)", "not open(box_0)")
    unread = judge("Light all lamps.")
    assert (unread.matched, unread.wrong, len(unread.missing)) == ((), (), 5)
    assert not any(goal.satisfied for goal in SCORER.explain("Light all lamps.").goals)


def test_an_explanation_names_the_missed_part_of_a_goal() -> None:
    assert SCORER.explain(answer([LAMPS[0]])).notes[-1] == (
        "missed of a goal that is stated in part: lit(lamp_1)"
    )
    for said in ([], LAMPS):
        assert not any("in part" in note for note in SCORER.explain(answer(said)).notes)


def test_a_wrong_goal_of_another_option_is_marked_as_such() -> None:
    either = Or((atom("lit", "lamp_0"), atom("open", "box_0")))
    scorer = GoalInterpretationScorer(make_task(either), DOMAIN, ByCategory())
    notes = scorer.explain(answer([["lit", "lamp"], ["open", "box"]])).notes
    assert notes[-1].startswith("wrong: ")
    assert notes[-1].endswith(", of another way to meet a goal than the one that counts")


def test_a_goal_that_is_repeated_too_often_is_wrong_and_noted() -> None:
    scorer = GoalInterpretationScorer(make_task(atom("lit", "lamp_0")), DOMAIN, ByCategory())
    text = answer([["lit", "lamp"], ["lit", "lamp"], ["open", "lamp"], ["open", "lamp"]])
    verdict = judge(text, scorer)
    assert (verdict.matched, verdict.wrong) == (("lit(lamp)",), ("lit(lamp)", "open(lamp)", "open(lamp)"))
    assert scorer.explain(text).notes[-2:] == (
        "wrong: lit(lamp), said more often than it is a goal",
        "wrong: open(lamp), 2 times",
    )


def test_shared_names_are_matched_up_to_renaming() -> None:
    task = make_task(atom("lit", "lamp_0"), atom("lit", "lamp_1"), atom("open", "box_1"))
    scorer = GoalInterpretationScorer(task, DOMAIN, ByCategory())
    lamp, box = ["lit", "lamp"], ["open", "box"]
    assert counts(answer([lamp, box]), scorer)[0] == (2, 0, 1)
    assert counts(answer([lamp, lamp, lamp]), scorer)[0] == (2, 0, 1)
    assert counts(answer([box, box, box]), scorer)[0] == (1, 1, 2)
    reports = scorer.explain(answer([lamp, box])).goals
    assert [goal.satisfied for goal in reports] == [True, False, True]
    assert write_goals(task, DOMAIN, ByCategory()) == (
        '["lit", "lamp"]',
        '["lit", "lamp"]',
        '["open", "box"]',
    )


def test_symmetric_relations_hold_both_ways() -> None:
    scorer = GoalInterpretationScorer(make_task(atom("together", "box_0", "ball_0")), DOMAIN, ByCategory())
    for pair in (["ball", "box"], ["box", "ball"]):
        assert counts(answer([["together", *pair]]), scorer)[1] == (1, 0, 0)


def test_an_explanation_says_that_a_task_has_no_goals() -> None:
    scorer = GoalInterpretationScorer(replace(make_task(), goals=()), DOMAIN, JsonGoalNotation())
    assert "the task has no goals, so nothing that is stated is right" in scorer.explain(answer(LAMPS)).notes
    assert not any("no goals" in note for note in SCORER.explain(answer(LAMPS)).notes)


def test_a_condition_of_two_goals_counts_once() -> None:
    lamp = atom("lit", "lamp_0")
    scorer = GoalInterpretationScorer(
        make_task(lamp, lamp & atom("open", "box_0")), DOMAIN, JsonGoalNotation()
    )
    assert counts(answer([LAMPS[0]]), scorer)[0] == (1, 0, 1)
    assert [goal.satisfied for goal in scorer.explain(answer([LAMPS[0]])).goals] == [True, False]


def test_an_answer_is_compared_with_the_option_that_it_meets_best() -> None:
    one, other = atom("lit", "lamp_0"), atom("open", "box_0") & atom("open", "box_1") & atom("lit", "lamp_1")
    scorer = GoalInterpretationScorer(make_task(Or((other, one))), DOMAIN, JsonGoalNotation())
    assert counts(answer(), scorer)[0] == (0, 0, 1)
    assert counts(answer([["open", "box_1"]]), scorer)[0] == (1, 0, 2)
    assert counts(answer([["open", "box_1"], LAMPS[0]]), scorer)[0] == (1, 1, 0)


def test_an_unreachable_goal_has_no_condition_and_is_not_met() -> None:
    scorer = GoalInterpretationScorer(make_task(FALSE), DOMAIN, JsonGoalNotation())
    assert counts(answer([LAMPS[0]]), scorer)[0] == (0, 1, 0)
    assert [goal.satisfied for goal in scorer.explain(answer()).goals] == [False]


def test_a_task_without_goals_can_only_be_answered_wrongly() -> None:
    scorer = GoalInterpretationScorer(replace(make_task(), goals=()), DOMAIN, JsonGoalNotation())
    assert counts(answer([LAMPS[0]]), scorer)[0] == (0, 1, 0)
    assert judge("", scorer).error is not None


def test_goals_over_time_are_left_out() -> None:
    scorer = GoalInterpretationScorer(
        make_task(Eventually(atom("lit", "lamp_0"))), DOMAIN, JsonGoalNotation()
    )
    assert scorer.task.goals == ()


def test_the_tasks_own_goals_score_in_full() -> None:
    notation = JsonGoalNotation()
    text = notation.join(write_goals(make_task(), DOMAIN, notation))
    assert json.loads(text) == {
        "node goals": [*LAMPS, SHUT],
        "edge goals": [["inside", "ball_0", "box_0"]],
        "action goals": ["PRESS"],
    }
    assert counts(text) == ((3, 0, 0), (1, 0, 0), (1, 0, 0))


WORDS = st.sampled_from(["lit", "open", "inside", "not", "PRESS", "sun", *OBJECTS])


@given(st.text(max_size=40) | st.lists(WORDS | st.lists(WORDS | st.lists(WORDS))).map(answer))
def test_each_predicted_goal_is_right_wrong_or_left_out(text: str) -> None:
    verdict = judge(text)
    assert verdict.counts is not None
    everything = verdict.counts["all"]
    assert isinstance(everything, ConfusionCounts)
    left_out = verdict.ill_formed + len(verdict.hallucinated)
    assert everything.true_positives + everything.false_positives + left_out == verdict.predicted
    SCORER.explain(text)
