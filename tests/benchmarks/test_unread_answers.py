"""The cause of an unreadable answer stands in its error and its explanation, under `strict` only."""

from __future__ import annotations

import pytest

from eai.abilities.protocol import Ability
from eai.abilities.replanning_options import ReplanningOptions
from eai.base.store import DataPackStore
from eai.benchmarks.suite import Suite, open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.trials import make_trial_record, replay_attempts_at_task
from eai.tasks.source import Source

PLAN = '[{"action": "OPEN", "object": "fridge_97"}]'
ACTIONS = '{"WALK": ["soap"], "GRAB": ["soap"]}'
GOALS = '{"node goals": [["open", "fridge.n.01_1"]], "edge goals": []}'
SECTIONS = '{"node goals": [{"name": "soap", "state": "CLEAN"}], "edge goals": [], "action goals": []}'
SUBGOALS = '{"output": ["open(fridge.97)"]}'
OPERATORS = '{"output": "(:action grasp :parameters (?x - object) :precondition () :effect (holding ?x))"}'


def suite_of(store: DataPackStore, benchmark: str, ability: str) -> Suite:
    return open_suite(benchmark, Ability(ability), source=Source(store, planner=PlannerChoice.NONE))


@pytest.mark.parametrize(
    ("benchmark", "ability", "text", "form"),
    [
        ("behavior", "action_sequencing", GOALS, "goal interpretation"),
        ("behavior", "action_sequencing", SUBGOALS, "subgoal decomposition"),
        ("behavior", "action_sequencing", OPERATORS, "transition modeling"),
        ("behavior", "subgoal_decomposition", PLAN, "action sequencing"),
        ("behavior", "transition_modeling", PLAN, "action sequencing"),
        ("virtualhome", "action_sequencing", SECTIONS, "goal interpretation"),
        ("virtualhome", "goal_interpretation", ACTIONS, "action sequencing"),
        ("virtualhome", "subgoal_decomposition", SECTIONS, "goal interpretation"),
        ("virtualhome", "transition_modeling", "1. WALK(soap)\n2. GRAB(soap)", "action sequencing"),
    ],
)
def test_the_form_of_another_ability_is_recognized(
    data_store: DataPackStore, benchmark: str, ability: str, text: str, form: str
) -> None:
    suite = suite_of(data_store, benchmark, ability)
    assessment = suite.assess(suite.task_ids[0], text)
    assert assessment.verdict.error is not None
    assert assessment.verdict.error.check == "other_ability"
    assert assessment.explain().notes[-1] == f"other_ability: the answer has the form of {form}"


@pytest.mark.parametrize("ability", ["goal_interpretation", "subgoal_decomposition", "transition_modeling"])
def test_every_ability_names_the_cause(data_store: DataPackStore, ability: str) -> None:
    suite = suite_of(data_store, "virtualhome", ability)
    verdict = suite.score(suite.task_ids[0], "I'm sorry, but I can't help with that.")
    assert verdict.error is not None
    assert (verdict.error.kind.value, verdict.error.check) == ("parsing", "refusal")


def test_a_readable_answer_with_an_error_has_no_cause(data_store: DataPackStore) -> None:
    suite = suite_of(data_store, "behavior", "action_sequencing")
    verdict = suite.score(suite.task_ids[0], '[{"action": "FLY", "object": "fridge_97"}]')
    assert verdict.error is not None
    assert verdict.error.check == "unknown_action"


def test_each_attempt_at_a_task_has_its_cause(data_store: DataPackStore) -> None:
    suite = suite_of(data_store, "behavior", "action_sequencing")
    options, task_id = ReplanningOptions(replans=1), suite.task_ids[0]
    texts = ["I'm sorry, but I can't help with that.", "The robot opens the fridge."]
    record = make_trial_record(
        suite, options, "my-model", task_id, replay_attempts_at_task(suite, options, task_id, texts)
    )
    checks = [attempt.verdict.error.check for attempt in record.attempts if attempt.verdict.error is not None]
    assert checks == ["refusal", "prose"]
    assert record.verdict.error is not None
    assert record.verdict.error.check == "prose"
    assert record.explanation is not None
    assert record.explanation.notes[-1] == "prose: the answer is only prose"
