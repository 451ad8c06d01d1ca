"""Converts records (scored answers) to JSON objects and back; ``docs/records.md`` describes the fields.

The dataclasses are the schema: their fields have the names of the file's fields. Enums are written as their
values, and tuples as lists. Goals are an object from kinds to goals, and errors an object from steps to
errors. Fields without a meaning for an ability are null.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import is_dataclass, replace
from enum import Enum
from functools import cache
from operator import attrgetter
from types import MappingProxyType
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from eai.abilities.attempt import Attempt
from eai.abilities.declaration import get_declaration
from eai.abilities.experiment import Experiment, StudySettings
from eai.abilities.explanation import AtomOrAction, VerdictExplanation
from eai.abilities.protocol import DEFAULT_PROTOCOL, Ability
from eai.abilities.replanning_options import STUDY, ReplanningOptions
from eai.abilities.task_features import TaskFeatures
from eai.abilities.verdict import Verdict
from eai.base.errors import InputError
from eai.base.json_value import Json
from eai.results.older_records import OLDER_OPTION_FIELDS, read_older_experiment, read_older_study_summaries
from eai.results.record import AnswerOrigin, Record
from eai.tasks.options import describe_validation_error
from eai.tasks.share import TalliesByGoalKind

SCHEMA = 4
"""The version of the format of records (scored answers in result files)."""

READABLE_SCHEMAS = (2, 3, SCHEMA)
"""Versions of the format of records (scored answers) that can be read."""

_FIELDS_WITH_HALVES = ("goals", "partial")
"""Fields with counts that may be multiples of a half, such as 1.5.

All numbers in these fields are written as floats, so that each field has one type in all records.
"""

COMMON_FIELDS = (
    "executable",
    "success",
    "error",
    "additional_steps",
    "category",
    "goals",
    "counts",
    "planner",
)
"""Fields that the record of every ability has, in order; null if the ability has no value for a field."""

T = TypeVar("T")


def hash_text(text: str) -> str:
    """Return the SHA-256 digest of a text; lone surrogates, which JSON allows, are encoded too."""
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def record_to_json(record: Record) -> dict[str, Json]:
    """Return a record (scored answer) as a JSON object."""
    fields: dict[str, Json] = {
        "schema": SCHEMA,
        "protocol": record.protocol.value,
        "domain": record.domain,
        "ability": record.ability.value,
        "model": record.model,
        "task_id": record.task_id,
        **({} if record.sample is None else {"sample": record.sample}),
        **({} if record.task is None else {"task": _features_to_json(record.task)}),
        "response_sha256": hash_text(record.response),
        "data_sha256": record.data_sha256,
        **({} if record.errata is None else {"errata": dataclass_to_json(record.errata)}),
        **_verdict_to_json(record.verdict),
        **({"success": record.verdict.success} if record.protocol is DEFAULT_PROTOCOL else {}),
        "repairs": list(record.all_answer_repairs),
        "unanswered": record.unanswered,
        "suite_size": record.suite_size,
    }
    if record.experiment is not None:
        fields |= experiment_to_json(record.experiment, record.summaries)
    if record.attempts:
        fields["attempts"] = [_attempt_to_json(attempt) for attempt in record.attempts]
    if record.origin is not None:
        fields |= dataclass_to_json(record.origin)
    if record.explanation is not None:
        fields["explanation"] = _value_to_json(record.explanation)
    return {**fields, "response": record.response}


def _features_to_json(task: TaskFeatures) -> dict[str, Json]:
    absent_values: tuple[tuple[str, Json], ...] = (("hazards", []), ("missing", None), ("fits", None))
    return {
        name: value for name, value in dataclass_to_json(task).items() if (name, value) not in absent_values
    }


def experiment_to_json(
    experiment: Experiment, study_summaries: Mapping[str, Mapping[str, Any]] = MappingProxyType({})
) -> dict[str, Json]:
    """Return the fields ``study`` and ``agent`` of records and summaries as a JSON object.

    ``study`` has the options of each study (variation of the questions), such as several attempts. ``agent``
    has the options of the agent that the run uses. A field without options is left out.

    Args:
        experiment: the run's options of studies and of the agent.
        study_summaries: for each study, values that a record stores about its question, such as the number of
            errors in the scene that the question states; empty for the summary of a run.
    """
    study: dict[str, Json] = {}
    for name, choice in experiment.study_settings_in_label_order.items():
        summary = {"summary": _value_to_json(study_summaries[name])} if name in study_summaries else {}
        study[name] = {"label": choice.label, "options": _value_to_json(choice.options), **summary}
    agent = {name: getattr(experiment, name) for name in ("harness", "effort", "rules")}
    fields = (("study", study, study), ("agent", agent, experiment.agent_settings))
    return {name: value for name, value, is_chosen in fields if is_chosen}


def experiment_from_json(values: Mapping[str, Any]) -> Experiment | None:
    """Return the options of studies and agents in a record's fields; None if they state no options.

    The fields are ``study`` and ``agent``. Older records have the chosen options as fields.

    Raises:
        InputError: a field has another type; the message names it.
    """
    if not values:
        return None
    if values.keys() & {"study", "agent"}:
        study = _parse_value(dict[str, StudySettings], values.get("study") or {}, "study")
        agent = _parse_value(dict[str, Any], values.get("agent") or {}, "agent")
        if STUDY in study:
            _parse_value(ReplanningOptions, study[STUDY].options, f"study.{STUDY}.options")
        experiment = _parse_value(Experiment, {**agent, "study": study}, "agent")
    else:
        chosen = {name: values[name] for name in OLDER_OPTION_FIELDS if values.get(name) is not None}
        names = _parse_value(dict[str, str], chosen, "experiment")
        experiment = read_older_experiment(names, _parse_value(ReplanningOptions, values, "experiment"))
    positions = enumerate(experiment.study.items())
    ordered = {
        name: replace(choice, label_position=position, summary={}) for position, (name, choice) in positions
    }
    return None if experiment == Experiment() else replace(experiment, study=ordered)


def _read_experiment(values: Mapping[str, Any]) -> Experiment | None:
    older = _parse_value(dict[str, Any], values.get("experiment") or {}, "experiment")
    return experiment_from_json(
        older or {name: values[name] for name in ("study", "agent") if values.get(name)}
    )


def _read_study_summaries(values: Mapping[str, Any]) -> Mapping[str, Mapping[str, Any]]:
    if not values.get("study"):
        return read_older_study_summaries(values)
    parts = _parse_value(dict[str, dict[str, Any]], values["study"], "study")
    return {name: part["summary"] for name, part in parts.items() if part.get("summary")}


def read_study_summary(record: Record, study: str, kind: type[T]) -> T | None:
    """Return the values that a study (a variation of questions) reports on an answer; None without values.

    Args:
        record: the record.
        study: name of the study.
        kind: the type that holds the values.

    Raises:
        InputError: the values do not have the type.
    """
    summary = record.summaries.get(study)
    return None if summary is None else _parse_value(kind, summary, f"study.{study}.summary")


def _attempt_to_json(attempt: Attempt) -> dict[str, Json]:
    explanation = attempt.explanation
    return {
        "prompt_sha256": attempt.prompt_sha256,
        "response_sha256": hash_text(attempt.response),
        **_verdict_to_json(attempt.verdict),
        "repairs": [*attempt.answer_repairs, *attempt.verdict.repairs],
        "slipped_at": attempt.slipped_at,
        "goal_held_at": attempt.goal_held_at,
        "usage": _value_to_json(attempt.usage),
        "answer_repairs": list(attempt.answer_repairs),
        **({} if explanation is None else {"explanation": _value_to_json(explanation)}),
        "response": attempt.response,
    }


def verdict_to_record_fields(verdict: Verdict) -> dict[str, Json]:
    """Return the fields of a record that its verdict fills, as a JSON object."""
    fields = dataclass_to_json(verdict)
    reason = fields.pop("excluded")
    status = "scored" if reason is None else "excluded"
    repairs = fields.pop("repairs")
    for name in ("repair", "refused", "partial", "without_call"):
        if fields.get(name, name) is None:
            del fields[name]
    return {
        "status": status,
        "excluded_reason": reason,
        **dict.fromkeys(COMMON_FIELDS),
        "repairs": repairs,
        **fields,
    }


def _verdict_to_json(verdict: Verdict) -> dict[str, Json]:
    """Return the fields of a verdict as a JSON object. Each field has one type in all records."""
    fields = verdict_to_record_fields(verdict)
    return fields | {
        name: _convert_numbers_in_json(fields[name], float) for name in _FIELDS_WITH_HALVES if name in fields
    }


def _convert_numbers_in_json(value: Any, convert: Callable[[float], int | float]) -> Any:
    if isinstance(value, Mapping):
        return {name: _convert_numbers_in_json(item, convert) for name, item in value.items()}
    if isinstance(value, list):
        return [_convert_numbers_in_json(item, convert) for item in value]
    return convert(value) if type(value) in (int, float) else value


def _shorten_number(number: float) -> int | float:
    return int(number) if float(number).is_integer() else number


def record_from_json(values: Mapping[str, Any]) -> Record:
    """Return the record (scored answer) that a JSON object describes; unknown fields are ignored.

    Raises:
        InputError: the object is not a record; the message names the field.
    """
    ability = _parse_value(Ability, _require_field(values, "ability"), "ability")
    origin = _read_origin(values)
    record = _parse_value(
        Record,
        {
            **{name: values[name] for name in _list_dataclass_field_names(Record) if name in values},
            "ability": ability,
            "response": values.get("response") or "",
            "verdict": _read_verdict(values, ability, 0 if origin is None else len(origin.answer_repairs)),
            "origin": origin,
            "explanation": _convert_stored_goal_list_to_mapping(values.get("explanation")),
            "experiment": _read_experiment(values),
            "summaries": _read_study_summaries(values),
            "attempts": _read_attempts(values, ability),
        },
    )
    sha256 = _parse_value(str, _require_field(values, "response_sha256"), "response_sha256")
    if values.get("response") is not None and hash_text(record.response) != sha256:
        raise InputError(
            "expected the response that was scored, but response_sha256 is the digest of another text; "
            "score the answer again"
        )
    return record


def dataclass_to_json(value: Any) -> dict[str, Json]:
    """Return a dataclass, such as an explanation or the origin of an answer, as a JSON object."""
    return {name: _value_to_json(getattr(value, name)) for name in value.__dataclass_fields__}


def _value_to_json(value: Any) -> Json:
    kind: Any = type(value)
    return value if kind in _PLAIN_TYPES else _find_encoder(kind)(value)


_PLAIN_TYPES = frozenset({type(None), bool, int, float, str})


@cache
def _find_encoder(kind: type) -> Callable[[Any], Json]:
    """Return the function that converts values of a type to JSON; cached, because records have few types."""
    if issubclass(kind, Enum):
        return attrgetter("value")
    if issubclass(kind, str | int | float):
        return lambda value: value
    if issubclass(kind, AtomOrAction):
        return _statement_to_json
    if issubclass(kind, VerdictExplanation):
        return _explanation_to_json
    if issubclass(kind, TalliesByGoalKind):
        return lambda tallies: dict(zip(TalliesByGoalKind._fields, map(list, tallies), strict=True))
    if issubclass(kind, Mapping):
        return lambda value: {getattr(key, "value", key): _value_to_json(item) for key, item in value.items()}
    return dataclass_to_json if is_dataclass(kind) else lambda value: [_value_to_json(item) for item in value]


def _explanation_to_json(explanation: VerdictExplanation) -> dict[str, Json]:
    """Return an explanation as JSON.

    The explained goals (``atoms``) become a list, because field names must not depend on the answer.
    """
    atoms = explanation.atoms
    listed = None if atoms is None else [{"text": text, **_statement_to_json(atoms[text])} for text in atoms]
    return {**dataclass_to_json(explanation), "atoms": listed}


def _statement_to_json(statement: AtomOrAction) -> dict[str, Json]:
    return {name: _value_to_json(item) for name, item in statement._asdict().items()}


def _convert_stored_goal_list_to_mapping(stored_explanation: Any) -> Any:
    """Replace the list of goals in a stored explanation by a mapping from a goal's text to its fields."""
    if not isinstance(stored_explanation, dict) or not isinstance(stored_explanation.get("atoms"), list):
        return stored_explanation
    atoms = {
        atom.get("text"): {n: p for n, p in atom.items() if n != "text"}
        for atom in stored_explanation["atoms"]
    }
    return {**stored_explanation, "atoms": atoms}


def _read_verdict(values: Mapping[str, Any], ability: Ability, repairs_before_scoring: int) -> Verdict:
    """Read a verdict from JSON.

    The first ``repairs_before_scoring`` corrections of the answer are left out, because they were made before
    scoring.
    """
    for name in COMMON_FIELDS:
        _require_field(values, name)
    status = _require_field(values, "status")
    reason = _require_field(values, "excluded_reason")
    if status != ("scored" if reason is None else "excluded"):
        raise InputError(
            f"field status: expected 'excluded' if excluded_reason is given, else 'scored', not {status!r}"
        )
    repairs = _parse_value(tuple[str, ...], _require_field(values, "repairs"), "repairs")
    declared: type[Verdict] = get_declaration(ability).verdict
    fields = {name: values[name] for name in _list_dataclass_field_names(declared) if name in values}
    fields |= {
        name: _convert_numbers_in_json(fields[name], _shorten_number)
        for name in _FIELDS_WITH_HALVES
        if name in fields
    }
    if "tried_actions" in _list_dataclass_field_names(declared) and isinstance(
        values.get("attempts"), int
    ):  # records of schema 2 store `tried_actions` under the name `attempts`
        fields["tried_actions"] = values["attempts"]
    return _parse_value(declared, {**fields, "excluded": reason, "repairs": repairs[repairs_before_scoring:]})


def _read_attempts(values: Mapping[str, Any], ability: Ability) -> tuple[Attempt, ...]:
    if isinstance(values.get("attempts"), int):  # records of schema 2 have the number of tried actions here
        return ()
    attempts = []
    for number, values_of_attempt in enumerate(
        _parse_value(list[dict[str, Any]], values.get("attempts") or [], "attempts")
    ):
        made_before = _parse_value(
            tuple[str, ...], values_of_attempt.get("answer_repairs", ()), f"attempts.{number}.answer_repairs"
        )
        fields = {
            name: values_of_attempt[name]
            for name in _list_dataclass_field_names(Attempt)
            if name in values_of_attempt
        }
        fields["explanation"] = _convert_stored_goal_list_to_mapping(values_of_attempt.get("explanation"))
        verdict = _read_verdict(values_of_attempt, ability, len(made_before))
        attempts.append(_parse_value(Attempt, {**fields, "verdict": verdict}, f"attempts.{number}"))
    return tuple(attempts)


def _read_origin(values: Mapping[str, Any]) -> AnswerOrigin | None:
    fields = {name: values[name] for name in _list_dataclass_field_names(AnswerOrigin) if name in values}
    return _parse_value(AnswerOrigin, fields) if fields else None


def _require_field(values: Mapping[str, Any], name: str) -> Any:
    if name not in values:
        raise InputError(f"field {name}: is missing")
    return values[name]


def _parse_value(kind: type[T], value: object, *path: str) -> T:
    """Parse a JSON value as a given type.

    Raises:
        InputError: the value does not have the type; the message names the field.
    """
    hashable: Any = kind
    try:
        read: T = _make_type_adapter(hashable).validate_python(value)
    except ValidationError as error:
        raise InputError(
            f"field {describe_validation_error(error, within=path, whole='the record')}"
        ) from error
    return read


@cache
def _make_type_adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


def _list_dataclass_field_names(dataclass_type: Any) -> Iterable[str]:
    return tuple(dataclass_type.__dataclass_fields__)
