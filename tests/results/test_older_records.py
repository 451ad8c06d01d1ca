"""Records of schema 2 and 3, in which one object has the options of all studies."""

from __future__ import annotations

import json
from typing import Any

import pytest

from eai.abilities.replanning_options import ReplanningOptions
from eai.base.errors import InputError
from eai.results.codec import record_from_json, record_to_json
from eai.results.record import Record
from results.test_records_page import EXAMPLES

PLAIN = {
    "name": "",
    "replans": 0,
    "world": "restart",
    "feedback": "none",
    "form": "prompt",
    "slip": 0.0,
    "slip_seed": None,
    "notice": "detected",
    "until": "done",
    **dict.fromkeys(("goals_from", "subgoals_from", "preset", "prompt_name", "scene")),
    **dict.fromkeys(("harness", "effort", "rules")),
}
STATED = {"goals_sha256": "0" * 64, "goal_counts": [1, 0, 2], "stage_1_unknown": ["sofa"]}


def older(schema: int, perceived: dict[str, Any] | None = None, **options: Any) -> Record:
    """Return a record as schema 2 and 3 wrote it."""
    line = {**json.loads(EXAMPLES["action_sequencing"]), "schema": schema, "experiment": PLAIN | options}
    return record_from_json(line if perceived is None else {**line, "perceived": perceived})


@pytest.mark.parametrize("schema", [2, 3])
@pytest.mark.parametrize(
    ("options", "study", "label"),
    [
        ({"goals_from": "a/b"}, "pipeline", "goals-a_b"),
        ({"goals_from": "a", "subgoals_from": "a"}, "pipeline", "goals-a+subgoals-a"),
        ({"scene": "noisy-missing-0.2"}, "perception", "scene-noisy-missing-0.2"),
        ({"replans": 2, "feedback": "explained"}, "replanning", "replans-2-restart-explained"),
        ({"slip": 0.2, "slip_seed": 0}, "replanning", "replans-0+slip-0.2-seed-0"),
        ({"prompt_name": "brief"}, "prompts", "prompt-brief"),
    ],
)
def test_an_older_record_of_each_study_is_read(
    schema: int, options: dict[str, Any], study: str, label: str
) -> None:
    record = older(schema, **options)
    assert {name: part.label for name, part in record.settings_by_study.items()} == {study: label}
    assert record.settings_by_study[study].options.items() >= options.items()
    assert record_from_json(json.loads(json.dumps(record_to_json(record)))) == record


def test_the_studies_of_an_older_record_are_in_the_order_of_its_label() -> None:
    record = older(3, prompt_name="brief", replans=1, scene="image", goals_from="m")
    assert [*record.settings_by_study] == ["pipeline", "perception", "replanning", "prompts"]
    assert ReplanningOptions.from_experiment(record.experiment) == ReplanningOptions(1)


def test_an_older_record_has_the_same_summaries_as_a_new_one() -> None:
    record = older(3, {"facts": 3}, goals_from="m", scene="image", **STATED)
    assert record.summaries == {"pipeline": STATED, "perception": {"facts": 3}}
    assert record.settings_by_study["pipeline"].summary == STATED


def test_harness_effort_and_rules_of_an_older_record_are_read() -> None:
    record = older(3, harness="react", effort="high", rules="until-goal")
    assert record.experiment is not None
    assert record.experiment.agent_settings == {"harness": "react", "effort": "high", "rules": "until-goal"}
    assert record.settings_by_study == {}


def test_an_older_experiment_without_a_choice_is_none() -> None:
    assert older(3).experiment is None


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"replans": "two"}, "field experiment.replans"),
        ({"scene": 3}, "field experiment.scene"),
        ({"slip": 2}, "slip: expected a probability from 0 to 1, not 2"),
    ],
)
def test_a_wrong_option_of_an_older_record_is_named(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        older(3, **options)


@pytest.mark.parametrize(
    ("study", "message"),
    [
        ({"terse": {"label": 3}}, "field study.terse.label"),
        ({"terse": {"label": "a/b"}}, "expected a text that can be the name of a folder"),
        ({"replanning": {"label": "x", "options": {"replans": "two"}}}, "replanning.options.replans"),
    ],
)
def test_a_wrong_choice_of_a_study_is_named(study: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        record_from_json({**json.loads(EXAMPLES["action_sequencing"]), "study": study})
