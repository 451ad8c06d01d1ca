"""Feedback on a failed attempt, by level, form and world. It never says more than its level allows."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise, product
from pathlib import Path
from typing import cast, get_args

import pytest

import eai.logic.formula as w
from agents.switches import DOMAIN, SWITCHES
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.feedback import REASONS_PREFIX, MultiAttemptQuestionWriter
from eai.abilities.protocol import Ability
from eai.abilities.replanning_options import AttemptStart, FeedbackForm, FeedbackLevel, ReplanningOptions
from eai.abilities.trial import MultiAttemptTrial
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.suite import open_suite
from eai.tasks.prompts.prompt import BelievedTask, Prompt
from eai.tasks.task import Task, goal
from eai.tasks.wording import PromptAndAnswerWording
from raising import BOOM, RAISING

ACTIONS = Ability.ACTION_SEQUENCING
SUITE = open_suite(SWITCHES, ACTIONS)
PLAIN = Prompt("Switch both on.\n", "Be brief.")
GOLDEN = Path(__file__).parent / "golden" / "feedback.txt"
LAMP, SHED, BOX, TORCH = "PRESS lamp", "GO shed", "OPEN box", "PRESS torch"


def plan(*steps: str) -> str:
    words = [step.split() for step in steps]
    return json.dumps([{"action": name, "object": ", ".join(objects)} for name, *objects in words])


FAILURES = {
    "parsing": "I would press the lamp.",
    "empty": "",
    "hallucination": plan(LAMP, "PRESS moon"),
    "argument_number": plan(LAMP, "GO shed shed"),
    "affordance": plan("GO lamp"),
    "missing_step": plan(LAMP, TORCH),
    "wrong_order": plan(LAMP, SHED, BOX, "GO hall", TORCH),
    "additional_step": plan(LAMP, "GO hall"),
    "goals": plan(SHED, BOX),
}
"""A plan for each way to fail."""


def questions(
    chosen: ReplanningOptions,
    answers: Sequence[str],
    asker: MultiAttemptQuestionWriter | None = None,
    task_id: str = "both",
) -> list[Prompt]:
    """Return the questions of a trial, including the question after the last answer."""
    scorer = SUITE.scorer(task_id)
    assert isinstance(scorer, ActionSequencingScorer)
    trial = MultiAttemptTrial(scorer, chosen)
    asks = asker or MultiAttemptQuestionWriter(
        {task_id: PLAIN}.__getitem__, PromptAndAnswerWording.from_domain(DOMAIN)
    )
    found = [asks.write_question(trial)]
    for text in answers:
        trial.try_answer(text)
        found.append(asks.write_question(trial))
    return found


def added_text(feedback: FeedbackLevel, answer: str) -> str:
    """Return the text that a second question adds to the first."""
    _, second = questions(ReplanningOptions(1, feedback=feedback), [answer])
    assert second.user.startswith(PLAIN.user.rstrip())
    return second.user.removeprefix(PLAIN.user.rstrip())


def test_each_failure_has_its_own_words() -> None:
    parts = [
        f"=== {failure}, {feedback}{added_text(feedback, answer)}\n"
        for failure, answer in FAILURES.items()
        for feedback in ("kind", "explained")
    ]
    assert "\n".join(parts) == GOLDEN.read_text(encoding="utf-8")


@pytest.mark.parametrize("feedback", get_args(FeedbackLevel))
def test_a_task_is_tried_again_after_its_scorer_raised(feedback: FeedbackLevel) -> None:
    scorer = open_suite(RAISING, ACTIONS).scorer("both")
    assert isinstance(scorer, ActionSequencingScorer)
    world: AttemptStart = "continue" if feedback == "state" else "restart"
    trial = MultiAttemptTrial(scorer, ReplanningOptions(1, feedback=feedback, world=world))
    asker = MultiAttemptQuestionWriter(
        {"both": PLAIN}.__getitem__, PromptAndAnswerWording.from_domain(DOMAIN)
    )
    trial.try_answer(BOOM)
    assert ("could not be judged" in asker.write_question(trial).user) == (feedback in ("kind", "explained"))
    assert "OverflowError" not in asker.write_question(trial).user
    won = trial.try_answer(plan(LAMP, SHED, BOX, TORCH))
    assert (won.verdict.success, trial.attempts[0].verdict.success) == (True, False)


@pytest.mark.parametrize(
    ("failure", "explained"),
    [
        ("hallucination", "there is no moon"),
        ("affordance", "lamp is no room"),
        ("missing_step", "the robot is not beside torch"),
        ("wrong_order", "what it lacks held after step"),
        ("additional_step", "the robot is in hall already"),
    ],
)
def test_only_the_level_explained_gives_the_failed_check(failure: str, explained: str) -> None:
    assert explained in added_text("explained", FAILURES[failure])
    assert explained not in added_text("kind", FAILURES[failure])


def test_a_wrong_number_of_objects_is_explained_at_every_level() -> None:
    for feedback in ("kind", "explained"):
        assert "GO takes 1 object, not 2" in added_text(feedback, FAILURES["argument_number"])


FORMS = [
    (feedback, form, world)
    for feedback, form, world in product(
        get_args(FeedbackLevel), get_args(FeedbackForm), get_args(AttemptStart)
    )
    if feedback != "state" or world == "continue"
]


@pytest.mark.parametrize(("feedback", "form", "world"), FORMS)
def test_the_text_of_each_attempt_reaches_the_next_question(
    feedback: FeedbackLevel, form: FeedbackForm, world: AttemptStart
) -> None:
    """Two levels leave the plan out. Without feedback all questions are equal."""
    answers = [plan(LAMP, TORCH), plan(LAMP, "WAVE"), plan("WAVE", TORCH)]
    asked = questions(ReplanningOptions(3, world, feedback, form), answers)
    for number, (before, after) in enumerate(pairwise(asked)):
        shown = after.user + "".join(text for turn in after.turns for text in turn)
        tells = feedback in ("kind", "explained")
        in_turns = form == "chat" and feedback != "none"
        for answer in answers[: number + 1]:
            assert (answer in shown) == (tells or in_turns)
        assert (REASONS_PREFIX in shown) == tells
        assert after.system == PLAIN.system
        if feedback == "none":
            assert after == PLAIN
        elif feedback != "state" or in_turns:
            assert after.sha256 != before.sha256


def test_a_conversation_asks_the_first_question_once() -> None:
    answers = [plan(TORCH), plan(LAMP, TORCH)]
    *_, last = questions(ReplanningOptions(2, feedback="explained", form="chat"), answers)
    assert (last.user, [answer for answer, _ in last.turns]) == (PLAIN.user, answers)
    assert "attempt 1" in last.turns[0][1]
    assert "attempt 2" in last.turns[1][1]


def test_the_question_in_a_continued_world_describes_the_present_state() -> None:
    """Rendered questions describe the present state without an addition.

    Other questions describe it at the end.
    """
    chosen = ReplanningOptions(1, "continue", "state")
    library = PromptLibrary("eai")
    prompts = library.open(SWITCHES, ACTIONS)
    first, second = questions(chosen, [plan(SHED)], library.make_question_writer(SWITCHES, ACTIONS, prompts))
    assert first == prompts["both"]
    added = set(second.user.splitlines()) - set(first.user.splitlines())
    assert added == {"at(robot, shed)"}
    _, given = questions(chosen, [plan(SHED)])
    assert "What holds now, in place of" in given.user
    assert "at(robot, shed)" in given.user
    assert "attempt" not in given.user


def test_actions_already_taken_are_not_requested_again() -> None:
    chosen = ReplanningOptions(1, "continue", "state")
    asks = MultiAttemptQuestionWriter(
        {"greet": PLAIN}.__getitem__, PromptAndAnswerWording.from_domain(DOMAIN)
    )
    _, second = questions(chosen, [plan("WAVE")], asks, "greet")
    assert second.user.partition("in this order:\n")[2].splitlines()[0] == "PRESS"
    library = PromptLibrary("eai")
    rendered = library.make_question_writer(SWITCHES, ACTIONS, library.open(SWITCHES, ACTIONS))
    before, after = questions(chosen, [plan("WAVE")], rendered, "greet")
    assert "WAVE or GO" in before.user
    assert "WAVE or GO" not in after.user


@pytest.mark.parametrize("world", get_args(AttemptStart))
@pytest.mark.parametrize("form", get_args(FeedbackForm))
def test_feedback_is_about_the_goals_that_the_question_stated(
    world: AttemptStart, form: FeedbackForm
) -> None:
    """The task's own goals are left out. Goals about unknown objects are never met."""
    scorer = SUITE.scorer("both")
    assert isinstance(scorer, ActionSequencingScorer)
    lit = [w.Atom("lit", (w.Constant(name),)) for name in ("lamp", "moon")]
    stated = replace(SUITE.tasks["both"], goals=tuple(map(goal, lit)))
    trial = MultiAttemptTrial(
        scorer, ReplanningOptions(1, world, "explained", form), task_with_stated_goals=stated
    )
    asks = MultiAttemptQuestionWriter({"both": PLAIN}.__getitem__, PromptAndAnswerWording.from_domain(DOMAIN))
    trial.try_answer(plan(LAMP))
    question = asks.write_question(trial)
    added = question.user.removeprefix(PLAIN.user.rstrip()) + "".join(reply for _, reply in question.turns)
    assert "lit(moon)" in added
    assert "lit(torch)" not in added
    assert "lit(lamp)" not in added.partition("relation: ")[2].partition("state: ")[2]
    assert not trial.attempts[0].verdict.success
    assert [report.satisfied for report in trial.goal_reports[0]] == [True, False]
    assert trial.task_in_next_question.goals == stated.goals


def test_the_question_describes_the_perceived_scene() -> None:
    """The metadata of the question describe the perceived scene as well."""
    library = PromptLibrary("eai")

    def look(task: Task, attempt: int) -> tuple[BelievedTask, dict[str, str]]:
        return BelievedTask(task, initial=f"seen before attempt {attempt}\n$initial"), {"scene": str(attempt)}

    asks = library.make_question_writer(SWITCHES, ACTIONS, library.open(SWITCHES, ACTIONS), look)
    _, second = questions(ReplanningOptions(1, "continue", "state"), [plan(SHED)], asks)
    assert "seen before attempt 2\n" in second.user
    assert "at(robot, shed)" in second.user
    trial = MultiAttemptTrial(
        cast("ActionSequencingScorer", SUITE.scorer("both")), ReplanningOptions(1, "continue", "state")
    )
    assert asks.get_scene_metadata_for_next_question(trial) == {}
    trial.try_answer(plan(SHED))
    assert asks.get_scene_metadata_for_next_question(trial) == {"scene": "2"}


def test_files_of_the_user_replace_the_words(tmp_path: Path) -> None:
    (tmp_path / "feedback").mkdir()
    (tmp_path / "feedback" / "missing_step.txt").write_text("Too early: $action.\n")
    library = PromptLibrary("eai", tmp_path)
    asks = library.make_question_writer(SWITCHES, ACTIONS, library.open(SWITCHES, ACTIONS))
    _, second = questions(ReplanningOptions(1, feedback="kind"), [plan(LAMP, TORCH)], asks)
    assert "- Too early: PRESS(torch).\n" in second.user
