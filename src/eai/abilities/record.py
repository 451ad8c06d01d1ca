"""Records: one scored answer, as a line of ``records.jsonl`` (DESIGN section 7)."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, ValidationError

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.verdict import (
    Confusion,
    Counted,
    Counts,
    ErrorReport,
    GoalTallies,
    Json,
    PlanVerdict,
    SubgoalCategory,
    Tally,
    Verdict,
    fields_of,
)
from eai.errors import InputError
from eai.pddl.planning import PlannerOutcome
from eai.world.fault import FaultKind

SCHEMA = 1
"""The version of the record format."""


@dataclass(frozen=True, slots=True)
class Record:
    """A verdict with what it is a verdict on.

    Attributes:
        domain: the name of the domain.
        model: who answered.
        task_id: the data set's id.
        response: the answer as it was scored; empty also where a record that was read does not have it.
        data_sha256: digest of the data it was scored against.
    """

    protocol: Protocol
    domain: str
    ability: Ability
    model: str
    task_id: str
    response: str
    data_sha256: str
    verdict: Verdict

    def to_json(self) -> dict[str, Json]:
        """The record as a JSON object."""
        return {
            "schema": SCHEMA,
            "protocol": self.protocol.value,
            "domain": self.domain,
            "ability": self.ability.value,
            "model": self.model,
            "task_id": self.task_id,
            "response_sha256": sha256_of(self.response),
            "data_sha256": self.data_sha256,
            **fields_of(self.verdict),
            "response": self.response,
        }


def sha256_of(text: str) -> str:
    """The digest of a text; lone surrogates, which JSON can carry, are kept apart."""
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def write_records(path: Path, records: Iterable[Record]) -> None:
    """Write one record a line."""
    with path.open("w", encoding="utf-8") as file:
        for record in records:
            file.write(json.dumps(record.to_json(), ensure_ascii=True) + "\n")


def read_records(path: Path) -> Iterator[Record]:
    """Read a file of records.

    Raises:
        InputError: the file cannot be read, a line is not a record of this schema, or its answer is not the
            one that was scored.
    """
    try:
        with path.open(encoding="utf-8") as file:
            for number, line in enumerate(file, 1):
                if line.strip():
                    yield _parse(f"{path}, line {number}", line)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: expected a readable records.jsonl ({error})") from error


class _Error(BaseModel):
    kind: FaultKind
    step: int | None
    detail: str


class _Goals(BaseModel):
    model_config = ConfigDict(extra="forbid")

    state: tuple[int | float, int | float]
    relation: tuple[int | float, int | float]
    action: tuple[int | float, int | float]


class _Counted(BaseModel):
    success: bool
    goals: _Goals
    errors: dict[FaultKind, int]


class _Line(BaseModel):
    """The wire form of a record; what ``goals_satisfied`` and ``counted`` say is a plan's."""

    model_config = ConfigDict(extra="allow")

    protocol: Protocol
    domain: str
    ability: Ability
    model: str
    task_id: str
    response_sha256: str
    data_sha256: str
    status: Literal["scored", "excluded"]
    excluded_reason: str | None
    executable: bool | None
    success: bool | None
    error: _Error | None
    additional_steps: int | None
    category: SubgoalCategory | None
    goals: _Goals | None
    counts: dict[str, tuple[int, int, int] | dict[str, tuple[int, int, int]]] | None
    planner: PlannerOutcome | None
    repairs: list[str]
    response: str | None = None
    goals_satisfied: tuple[bool, ...] | None = None
    counted: _Counted | None = None


def _parse(place: str, line: str) -> Record:
    try:
        values = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{place}: expected a JSON object ({error})") from error
    if not isinstance(values, dict):
        raise InputError(f"{place}: expected a JSON object")
    schema = values.pop("schema", None)
    if schema != SCHEMA:
        raise InputError(f"{place}: schema {schema!r}, expected {SCHEMA}")
    try:
        wire = _Line.model_validate(values)
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"])
        raise InputError(f"{place}: field {field}: {first['msg']}") from error
    if wire.response is not None and sha256_of(wire.response) != wire.response_sha256:
        raise InputError(f"{place}: expected the response that was scored; response_sha256 is another text's")
    return Record(
        wire.protocol,
        wire.domain,
        wire.ability,
        wire.model,
        wire.task_id,
        wire.response or "",
        wire.data_sha256,
        _verdict(wire),
    )


def _verdict(wire: _Line) -> Verdict:
    verdict = Verdict(
        excluded=wire.excluded_reason,
        executable=wire.executable,
        success=wire.success,
        error=None if wire.error is None else ErrorReport(**wire.error.model_dump()),
        additional_steps=wire.additional_steps,
        category=wire.category,
        goals=None if wire.goals is None else _tallies(wire.goals),
        counts=None if wire.counts is None else _counts(wire.counts),
        planner=wire.planner,
        repairs=tuple(wire.repairs),
        details=wire.model_extra or None,
    )
    if wire.goals_satisfied is None:
        return verdict
    if wire.ability is Ability.ACTION_SEQUENCING:
        return _plan_verdict(verdict, wire)
    return replace(verdict, details={**(verdict.details or {}), "goals_satisfied": wire.goals_satisfied})


def _plan_verdict(verdict: Verdict, wire: _Line) -> PlanVerdict:
    counted = None
    if wire.counted is not None:
        errors = tuple(wire.counted.errors.items())
        counted = Counted(wire.counted.success, _tallies(wire.counted.goals), errors)
    told = {field.name: getattr(verdict, field.name) for field in fields(verdict)}
    return PlanVerdict(**told, goals_satisfied=wire.goals_satisfied or (), counted=counted)


def _tallies(goals: _Goals) -> GoalTallies:
    return GoalTallies(**{kind: Tally(*tally) for kind, tally in goals})


def _counts(
    wire: Mapping[str, tuple[int, int, int] | dict[str, tuple[int, int, int]]],
) -> Counts:
    return {
        key: {name: Confusion(*counts) for name, counts in value.items()}
        if isinstance(value, dict)
        else Confusion(*value)
        for key, value in wire.items()
    }
