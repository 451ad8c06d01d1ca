"""Find registered studies by name: studies of this package and of other distributions.

A study adds options to runs, or analyses the records of runs. A distribution registers a `Study` by an entry
point of the group ``eai.studies``. A study is imported only when it is used.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any

from eai.base.entry_points import EntryPoint, get_entry_points
from eai.base.errors import InputError, did_you_mean
from eai.studies.study import Study
from eai.studies.variation import VariationOptions

if TYPE_CHECKING:
    from eai.benchmarks.suite import Suite
    from eai.results.record import Record

GROUP = "eai.studies"
"""Group of entry points that register studies."""

_LISTED_FIRST = (
    "cofactors",
    "errors",
    "goals",
    "items",
    "sensitivity",
    "contamination",
    "replanning",
    "pipeline",
    "perception",
    "prompts",
    "annotations",
    "repair",
    "conduct",
)
"""Names of the studies that come first in lists of studies, in this order."""


@cache
def _find_study_entry_points() -> Mapping[str, EntryPoint]:
    return get_entry_points(GROUP, _LISTED_FIRST)


def list_study_names() -> tuple[str, ...]:
    """Return the names of all registered studies. Studies of this package come first."""
    return tuple(_find_study_entry_points())


@cache
def find_study(name: str) -> Study:
    """Return the registered study (options of runs, and an analysis) with a name.

    Raises:
        InputError: no study has the name, or the entry point does not lead to a study.
    """
    if name not in _find_study_entry_points():
        known = ", ".join(_find_study_entry_points())
        raise InputError(
            f"{name!r} is no study: expected one of {known}{did_you_mean(name, _find_study_entry_points())}"
        )
    value = _find_study_entry_points()[name].load()
    if not isinstance(value, Study):
        raise InputError(f"entry point {name} of {GROUP}: expected a Study, found {type(value).__name__}")
    return value


def add_study_summaries(record: Record, suite: Suite, question_metadata: Mapping[str, Any]) -> Record:
    """Add a summary to the record of an answer for each study that varied the run, and return the record.

    Example: the study of perception counts the errors in the scene that the question stated. Summaries that
    the record already has are kept.

    Args:
        record: the record; a record without an answer gets no summaries.
        suite: the suite of the record.
        question_metadata: the metadata of the question, such as the stated scene.
    """
    if record.unanswered is not None:
        return record
    summaries = {**record.summaries}
    for name in record.settings_by_study.keys() & _find_study_entry_points().keys() - summaries.keys():
        summarize = find_study(name).summarize
        summary = None if summarize is None else summarize(record, suite, question_metadata)
        if summary:
            summaries[name] = summary
    return replace(record, summaries=summaries)


@cache
def list_studies_with_run_options() -> tuple[Study, ...]:
    """Return the studies that have options for runs, not only for analyses."""
    return tuple(
        [
            study
            for study in map(find_study, _find_study_entry_points())
            if study.options is not VariationOptions
        ]
    )
