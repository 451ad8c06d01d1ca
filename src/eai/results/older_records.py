"""Read the options of studies (variations of a run's questions) from records of schema 2 and 3.

Such a record has one object for the options of all studies.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from eai.abilities.experiment import Experiment, StudySettings, make_study_settings_of_one_option
from eai.abilities.replanning_options import STUDY, ReplanningOptions

_AGENT = ("harness", "effort", "rules")

_OPTIONS = {
    "goals_from": ("pipeline", "goals"),
    "subgoals_from": ("pipeline", "subgoals"),
    "scene": ("perception", "scene"),
    "prompt_name": ("prompts", "prompt"),
}
"""Mapping from each option in old records to its study (variation of questions) and its name in tables."""

_ORDER = ("pipeline", "perception", STUDY, "prompts")

OLDER_OPTION_FIELDS = (*_OPTIONS, *_AGENT)
"""Fields of old records, each with one option of a run as text, such as `prompt_name`."""

_STATED = (
    *("goals_sha256", "goal_counts", "stage_1_unreadable", "stage_1_unknown", "stage_1_left_out"),
    *("subgoals_sha256", "subgoals_success"),
)


def read_older_experiment(named_options: Mapping[str, str], replanning: ReplanningOptions) -> Experiment:
    """Return the options of the run of an older record, in today's form.

    ``replanning`` has the options for several attempts at a task. ``named_options`` has all other options;
    their values are texts.
    """
    study: dict[str, StudySettings] = (
        dict(replanning.experiment.study) if replanning.executes_answers_as_episodes else {}
    )
    for option, (name, kind) in _OPTIONS.items():
        if option in named_options:
            choice = make_study_settings_of_one_option(kind, option, named_options[option])
            study[name] = study[name].combine(name, choice) if name in study else choice
    positions = enumerate(_ORDER)
    ordered = {
        name: replace(study[name], label_position=position) for position, name in positions if name in study
    }
    return Experiment(ordered, **{name: named_options[name] for name in _AGENT if name in named_options})


def read_older_study_summaries(record: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    """Return the summaries of the studies ``pipeline`` and ``perception`` in an older record.

    In these studies, a model first states the goals or the scene of a question. The summary of a study has
    values about them, such as the number of errors. The result maps the study's name to its summary, like the
    attribute ``summaries`` of a `Record`.
    """
    experiment = record.get("experiment") or {}
    stated = {name: experiment[name] for name in _STATED if experiment.get(name) is not None}
    summaries = {"pipeline": stated, "perception": record.get("perceived") or {}}
    return {name: summary for name, summary in summaries.items() if summary}
