"""The studies there are, by name: those of this package and those that other distributions bring.

A distribution registers one by an entry point of the group ``eai.studies``, a `Study`. Only the study that is
asked for is imported.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.metadata import EntryPoint

from eai.data.entry_points import entry_points_of
from eai.errors import InputError, did_you_mean
from eai.studies.study import Study
from eai.studies.variation import Variation

GROUP = "eai.studies"
"""The group of entry points."""

BUILT_IN = {
    "cofactors": "eai.studies.cofactors.study:COFACTORS",
    "errors": "eai.studies.errors.study:ERRORS",
    "goals": "eai.studies.goals.study:GOALS",
    "items": "eai.studies.items.study:ITEMS",
    "sensitivity": "eai.studies.sensitivity.study:SENSITIVITY",
    "contamination": "eai.studies.contamination.study:CONTAMINATION",
    "replanning": "eai.studies.attempts.study:REPLANNING",
    "pipeline": "eai.studies.pipeline.study:PIPELINE",
    "perception": "eai.studies.perception.study:PERCEPTION",
    "prompts": "eai.studies.prompts.study:PROMPTS",
    "annotations": "eai.studies.annotation.study:ANNOTATIONS",
    "repair": "eai.studies.repair.study:REPAIR",
    "conduct": "eai.studies.conduct.study:CONDUCT",
}
"""The studies that come with the package, as its metadata have them, too."""


@cache
def _registered() -> Mapping[str, EntryPoint]:
    return entry_points_of(GROUP, BUILT_IN)


def study_names() -> tuple[str, ...]:
    """The names of all studies, those of this package first."""
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


@cache
def studies_of_runs() -> tuple[Study, ...]:
    """The studies that a run can be of: those that have options."""
    return tuple([study for study in map(find_study, _registered()) if study.options is not Variation])
