"""The studies there are, by name: those of this package and those that other distributions bring.

A distribution registers one by an entry point of the group ``eai.studies``, a `Study`. Only the study that is
asked for is imported.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any

from eai.base.entry_points import EntryPoint, get_entry_points
from eai.base.errors import InputError, did_you_mean
from eai.studies.study import Study
from eai.studies.variation import Variation

if TYPE_CHECKING:
    from eai.benchmarks.suite import Suite
    from eai.results.record import Record

GROUP = "eai.studies"
"""The group of entry points."""

_FIRST = (
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
"""Studies that are listed first, in this order."""


@cache
def _registered() -> Mapping[str, EntryPoint]:
    return get_entry_points(GROUP, _FIRST)


def study_names() -> tuple[str, ...]:
    """Return the names of all studies, those of this package first."""
    return tuple(_registered())


@cache
def find_study(name: str) -> Study:
    """The study of a name.

    Raises:
        InputError: there is none, or what is registered is none.
    """
    if name not in _registered():
        known = ", ".join(_registered())
        raise InputError(f"{name!r} is no study: expected one of {known}{did_you_mean(name, _registered())}")
    value = _registered()[name].load()
    if not isinstance(value, Study):
        raise InputError(f"{name}: expected a Study, found {type(value).__name__}")
    return value


def summarized(record: Record, suite: Suite, about: Mapping[str, Any]) -> Record:
    """Return a record with the summary of each study that has none yet.

    Args:
        record: the record; without an answer it gets no summaries.
        suite: the suite of the record.
        about: the metadata of the question.
    """
    if record.unanswered is not None:
        return record
    summaries = {**record.summaries}
    for name in record.study.keys() & _registered().keys() - summaries.keys():
        summarize = find_study(name).summarize
        summary = None if summarize is None else summarize(record, suite, about)
        if summary:
            summaries[name] = summary
    return replace(record, summaries=summaries)


@cache
def studies_of_runs() -> tuple[Study, ...]:
    """The studies that a run can be of: those that have options."""
    return tuple([study for study in map(find_study, _registered()) if study.options is not Variation])
