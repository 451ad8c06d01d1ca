"""The activity definitions of the BEHAVIOR challenge of 2026, made from those of bddl 3.6.0 by amendments."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from itertools import chain
from typing import Any, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

from eai.base.errors import DataError
from eai.base.files import parse_toml
from eai.benchmarks.behavior_1k.kinds import ACTIVITIES, PACK
from eai.benchmarks.behavior_1k.tasks import DataForAmendedDefinitions, read_plans, split_by_activity
from eai.benchmarks.packs import open_pack
from eai.tasks.source import Source

AMENDMENTS, PLANS_2026 = "challenge_2026.toml", "plans_2026.txt"
"""Files beside this module: changes of bddl's definitions, and plans of the activities that they change."""

Definitions: TypeAlias = Mapping[str, str]
"""Mapping from activities to their definitions in BDDL. Each definition has one line."""

_SECTIONS = re.compile(r"(.*) \(:objects (.*)\) \(:init (.*)\) \(:goal (.*)\)\)")
_DECLARATION = re.compile(r"((?:\S+ )+?)- (\S+)")
_FACT = re.compile(r"\((?:not \([^()]*\)|[^()]*)\)")
_OBJECT = re.compile(r"[\w'-]+\.n\.\d\d_[\d*]+")


class _ActivityAmendment(BaseModel):
    """Changes of one definition. `objects` maps a kind to the number of objects to declare."""

    model_config = ConfigDict(extra="forbid")

    base: str = Field("", alias="from")
    objects: Mapping[str, int] = {}
    drop: frozenset[str] = frozenset()
    add: Sequence[str] = ()
    goal: str = ""


class _ChallengeAmendments(BaseModel):
    model_config = ConfigDict(extra="forbid")

    order: Sequence[str]
    kinds: Mapping[str, Mapping[str, Any]]
    left_out: Mapping[str, str]
    activities: Mapping[str, _ActivityAmendment]


@cache
def load_activity_amendments() -> _ChallengeAmendments:
    """Return the changes that make activities of the challenge of 2026 from activities of bddl 3.6.0."""
    text = (files("eai.benchmarks.behavior_1k") / AMENDMENTS).read_text(encoding="utf-8")
    return _ChallengeAmendments.model_validate(parse_toml(text))


def load_activities_of_challenge_2026(source: Source | None) -> tuple[Definitions, DataForAmendedDefinitions]:
    """Return the definitions of the challenge's activities, and further data for them.

    The data are gold plans, reasons for exclusion, and kinds of objects that bddl 3.6.0 lacks.
    """
    amendments = load_activity_amendments()
    packed = split_by_activity(open_pack(PACK, source).read_member(ACTIVITIES))
    supplement = DataForAmendedDefinitions(amendments.kinds, read_plans(PLANS_2026), amendments.left_out)
    return amend_definitions_for_challenge(packed), supplement


def amend_definitions_for_challenge(original: Definitions) -> Definitions:
    """Return the definitions of the challenge's 100 activities, in the order of the challenge.

    Each definition is that of bddl 3.6.0 (`original`), changed by its amendment if it has one.

    Raises:
        DataError: a definition lacks a fact that its amendment removes.
    """
    amendments = load_activity_amendments()
    amended = {
        name: _amend_activity_definition(name, original, each) for name, each in amendments.activities.items()
    }
    return {name: amended.get(name) or original[name] for name in amendments.order}


def _amend_activity_definition(activity: str, definitions: Definitions, amendment: _ActivityAmendment) -> str:
    match = _SECTIONS.fullmatch(definitions[amendment.base or activity].replace(" )", ")"))
    if match is None:
        raise DataError(
            f"{activity}: expected :objects, :init and :goal, in this order, in the definition of "
            "bddl 3.6.0; run `eai data fetch`"
        )
    head, objects, initial, goal = match.groups()
    declared = {kind: names.split() for names, kind in _DECLARATION.findall(objects)}
    for kind, number in amendment.objects.items():
        declared[kind] = [f"{kind}_{i}" for i in range(1, number + 1)]
    known, facts = set(chain(*declared.values())), _FACT.findall(initial)
    if missing := amendment.drop.difference(facts):
        raise DataError(
            f"{AMENDMENTS}: {activity}: the definition of bddl 3.6.0 lacks {', '.join(sorted(missing))}; "
            "remove these facts from `drop`"
        )
    kept = [fact for fact in facts if known.issuperset(_OBJECT.findall(fact)) and fact not in amendment.drop]
    declarations = [f"{' '.join(names)} - {kind}" for kind, names in declared.items() if names]
    goal = " ".join(amendment.goal.split()) or goal
    facts = [*kept, *amendment.add]
    return f"{head} (:objects {' '.join(declarations)}) (:init {' '.join(facts)}) (:goal {goal}))"
