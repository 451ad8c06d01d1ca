"""The page on records agrees with the codec: its examples are records, and it describes every field."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from typing import get_args

import pytest

from by_path import ROOT
from eai.abilities.attempt import AnswerUsage, Attempt
from eai.abilities.declaration import load_declarations_of_paper_abilities
from eai.abilities.experiment import Experiment, StudySettings
from eai.abilities.explanation import GoalPartReport, GoalReport, StepReport, VerdictExplanation
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.abilities.replanning_options import (
    AttemptStart,
    EndCondition,
    FeedbackForm,
    FeedbackLevel,
    ReplanningOptions,
)
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory
from eai.abilities.task_features import TaskFeatures
from eai.abilities.transition_modeling.verdict import OperatorComparisonStatus, OperatorReport
from eai.abilities.verdict import ErrorReport, SummaryCounts
from eai.pddl.planning import PlannerOutcome
from eai.results.codec import record_from_json, record_to_json
from eai.results.record import AnswerOrigin, Record
from eai.studies.perception.verdict import ScenePerceptionErrorCounts
from eai.world.fault import FaultKind, Notice

PAGE = (ROOT / "docs" / "records.md").read_text(encoding="utf-8")
EXAMPLES = {Ability(json.loads(line)["ability"]): line for line in re.findall(r"```json\n(.*?)\n```", PAGE)}


def test_there_is_an_example_of_every_ability() -> None:
    assert EXAMPLES.keys() == set(PAPER_ABILITIES)


@pytest.mark.parametrize("ability", EXAMPLES)
def test_the_pages_examples_equal_written_records(ability: Ability) -> None:
    assert json.dumps(record_to_json(record_from_json(json.loads(EXAMPLES[ability])))) == EXAMPLES[ability]


def test_every_field_is_on_the_page() -> None:
    example = record_from_json(json.loads(EXAMPLES[Ability.ACTION_SEQUENCING]))
    explained = (VerdictExplanation, StepReport, GoalReport, GoalPartReport, OperatorReport)
    declared = (
        TaskFeatures,
        Experiment,
        StudySettings,
        ReplanningOptions,
        ScenePerceptionErrorCounts,
        Attempt,
        AnswerOrigin,
        AnswerUsage,
        SummaryCounts,
        ErrorReport,
        *explained,
    )
    names = {name for kind in declared for name in kind.__dataclass_fields__} - {"verdict", "label_position"}
    names |= set(record_to_json(Record(**{n: getattr(example, n) for n in Record.__dataclass_fields__})))
    for each in load_declarations_of_paper_abilities().values():
        names |= set(each.verdict.__dataclass_fields__) - {"excluded"}
    assert [name for name in sorted(names) if not re.search(rf'[`"]{name}[`"]', PAGE)] == []


@pytest.mark.parametrize(
    "kind",
    [
        *(PAPER_ABILITIES, FaultKind, SubgoalAnswerCategory, PlannerOutcome, OperatorComparisonStatus),
        *map(get_args, (AttemptStart, FeedbackLevel, FeedbackForm, Notice, EndCondition)),
    ],
)
def test_every_value_of_a_closed_vocabulary_is_on_the_page(kind: Iterable[Ability | str]) -> None:
    values = [each if isinstance(each, str) and not hasattr(each, "value") else each.value for each in kind]
    assert [value for value in values if f"`{value}`" not in PAGE] == []
