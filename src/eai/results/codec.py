"""The one form of records outside the program: JSON objects, whose fields are in ``docs/records.md``.

The dataclasses are the schema: their fields have the names that stand in a file. Enums are their values,
tuples lists; goals by kind and errors by their number are objects. What an ability has no use for is null.
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
from eai.abilities.attempt_options import STUDY, AttemptOptions
from eai.abilities.declaration import declaration_of
from eai.abilities.experiment import Experiment, StudyChoice
from eai.abilities.explanation import Explanation, Statement
from eai.abilities.protocol import Ability
from eai.abilities.task_features import TaskFeatures
from eai.abilities.verdict import Verdict
from eai.base.errors import InputError
from eai.base.json_value import Json
from eai.results.older_records import NAMES, older_experiment, older_summaries
from eai.results.record import Origin, Record
from eai.tasks.options import misfit
from eai.tasks.share import GoalTallies

SCHEMA = 4
"""The version of the record format."""

READABLE = (2, 3, SCHEMA)
"""The versions that are read."""

_HALVES = ("goals", "partial")
"""Fields that count halves. All their numbers are written as floats, so that each has one type."""

COMMON = ("executable", "success", "error", "additional_steps", "category", "goals", "counts", "planner")
"""The fields that stand in the record of every ability, in their order; null where it has no use for them."""

T = TypeVar("T")


def sha256_of(text: str) -> str:
    """The digest of a text; lone surrogates, which JSON can carry, are kept apart."""
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def record_to_json(record: Record) -> dict[str, Json]:
    """A record as a JSON object."""
    written: dict[str, Json] = {
        "schema": SCHEMA,
        "protocol": record.protocol.value,
        "domain": record.domain,
        "ability": record.ability.value,
        "model": record.model,
        "task_id": record.task_id,
        **({} if record.sample is None else {"sample": record.sample}),
        **({} if record.task is None else {"task": _features_to_json(record.task)}),
        "response_sha256": sha256_of(record.response),
        "data_sha256": record.data_sha256,
        **({} if record.errata is None else {"errata": dataclass_to_json(record.errata)}),
        **_written(record.verdict),
        "repairs": list(record.repairs),
        "unanswered": record.unanswered,
        "suite_size": record.suite_size,
    }
    if record.experiment is not None:
        written |= experiment_to_json(record.experiment, record.summaries)
    if record.attempts:
        written["attempts"] = [_attempt_to_json(attempt) for attempt in record.attempts]
    if record.origin is not None:
        written |= dataclass_to_json(record.origin)
    if record.explanation is not None:
        written["explanation"] = _plain(record.explanation)
    return {**written, "response": record.response}


def _features_to_json(task: TaskFeatures) -> dict[str, Json]:
    """The features of a task, without those that most have not."""
    absent: tuple[tuple[str, Json], ...] = (("hazards", []), ("missing", None), ("fits", None))
    return {name: value for name, value in dataclass_to_json(task).items() if (name, value) not in absent}


def experiment_to_json(
    experiment: Experiment, summaries: Mapping[str, Mapping[str, Any]] = MappingProxyType({})
) -> dict[str, Json]:
    """Return the fields ``study`` and ``agent`` of records and summaries, each only if there is a choice.

    Args:
        experiment: the experiment.
        summaries: what studies say of one answer, by the name of the study.
    """
    study: dict[str, Json] = {}
    for name, choice in experiment.ordered_choices.items():
        summary = {"summary": _plain(summaries[name])} if name in summaries else {}
        study[name] = {"label": choice.label, "options": _plain(choice.options), **summary}
    agent = {name: getattr(experiment, name) for name in ("harness", "effort", "rules")}
    fields = (("study", study, study), ("agent", agent, experiment.agent_settings))
    return {name: value for name, value, is_chosen in fields if is_chosen}


def experiment_from_json(values: Mapping[str, Any]) -> Experiment | None:
    """Return the experiment with these fields, or None if they have no choice.

    Raises:
        InputError: a field has another type; the message names it.
    """
    if not values:
        return None
    if values.keys() & {"study", "agent"}:
        study = _read(dict[str, StudyChoice], values.get("study") or {}, "study")
        agent = _read(dict[str, Any], values.get("agent") or {}, "agent")
        if STUDY in study:
            _read(AttemptOptions, study[STUDY].options, f"study.{STUDY}.options")
        experiment = _read(Experiment, {**agent, "study": study}, "agent")
    else:
        chosen = {name: values[name] for name in NAMES if values.get(name) is not None}
        names = _read(dict[str, str], chosen, "experiment")
        experiment = older_experiment(names, _read(AttemptOptions, values, "experiment"))
    places = enumerate(experiment.study.items())
    ordered = {name: replace(choice, label_position=place, summary={}) for place, (name, choice) in places}
    return None if experiment == Experiment() else replace(experiment, study=ordered)


def _experiment(values: Mapping[str, Any]) -> Experiment | None:
    older = _read(dict[str, Any], values.get("experiment") or {}, "experiment")
    return experiment_from_json(
        older or {name: values[name] for name in ("study", "agent") if values.get(name)}
    )


def _summaries(values: Mapping[str, Any]) -> Mapping[str, Mapping[str, Any]]:
    if not values.get("study"):
        return older_summaries(values)
    parts = _read(dict[str, dict[str, Any]], values["study"], "study")
    return {name: part["summary"] for name, part in parts.items() if part.get("summary")}


def read_summary(record: Record, study: str, kind: type[T]) -> T | None:
    """Return what a study says of an answer as a value of the study's type, or None if it says nothing.

    Raises:
        InputError: the summary is no such value.
    """
    summary = record.summaries.get(study)
    return None if summary is None else _read(kind, summary, f"study.{study}.summary")


def _attempt_to_json(attempt: Attempt) -> dict[str, Json]:
    """An attempt as a record has it: with the fields that a record of its own would have."""
    explanation = attempt.explanation
    return {
        "prompt_sha256": attempt.prompt_sha256,
        "response_sha256": sha256_of(attempt.response),
        **_written(attempt.verdict),
        "repairs": [*attempt.answer_repairs, *attempt.verdict.repairs],
        "slipped_at": attempt.slipped_at,
        "goal_held_at": attempt.goal_held_at,
        "usage": _plain(attempt.usage),
        "answer_repairs": list(attempt.answer_repairs),
        **({} if explanation is None else {"explanation": _plain(explanation)}),
        "response": attempt.response,
    }


def fields_of(verdict: Verdict) -> dict[str, Json]:
    """A verdict's part of its record."""
    own = dataclass_to_json(verdict)
    reason = own.pop("excluded")
    status = "scored" if reason is None else "excluded"
    repairs = own.pop("repairs")
    for name in ("repair", "refused", "partial"):
        if own.get(name, name) is None:
            del own[name]
    return {
        "status": status,
        "excluded_reason": reason,
        **dict.fromkeys(COMMON),
        "repairs": repairs,
        **own,
    }


def _written(verdict: Verdict) -> dict[str, Json]:
    """The fields of a verdict as a record has them: each with one type in all records."""
    fields = fields_of(verdict)
    return fields | {name: _converted(fields[name], float) for name in _HALVES if name in fields}


def _converted(value: Any, convert: Callable[[float], int | float]) -> Any:
    """A JSON value with all of its numbers converted."""
    if isinstance(value, Mapping):
        return {name: _converted(part, convert) for name, part in value.items()}
    if isinstance(value, list):
        return [_converted(part, convert) for part in value]
    return convert(value) if type(value) in (int, float) else value


def _whole_if_possible(number: float) -> int | float:
    return int(number) if float(number).is_integer() else number


def record_from_json(values: Mapping[str, Any]) -> Record:
    """The record that a JSON object is; fields that are not known are passed over.

    Raises:
        InputError: it is not a record; the message names the field.
    """
    ability = _read(Ability, _present(values, "ability"), "ability")
    origin = _origin(values)
    record = _read(
        Record,
        {
            **{name: values[name] for name in _names(Record) if name in values},
            "ability": ability,
            "response": values.get("response") or "",
            "verdict": _verdict(values, ability, 0 if origin is None else len(origin.answer_repairs)),
            "origin": origin,
            "explanation": _explanation(values.get("explanation")),
            "experiment": _experiment(values),
            "summaries": _summaries(values),
            "attempts": _attempts(values, ability),
        },
    )
    sha256 = _read(str, _present(values, "response_sha256"), "response_sha256")
    if values.get("response") is not None and sha256_of(record.response) != sha256:
        raise InputError("expected the response that was scored; response_sha256 is another text's")
    return record


def dataclass_to_json(value: Any) -> dict[str, Json]:
    """A dataclass as a JSON object: an explanation, say, or where an answer comes from."""
    return {name: _plain(getattr(value, name)) for name in value.__dataclass_fields__}


def _plain(value: Any) -> Json:
    kind: Any = type(value)
    return value if kind in _WRITTEN_AS_IT_IS else _form(kind)(value)


_WRITTEN_AS_IT_IS = frozenset({type(None), bool, int, float, str})


@cache
def _form(kind: type) -> Callable[[Any], Json]:
    """How the values of a type are written: a record has some fifty, of a dozen types."""
    if issubclass(kind, Enum):
        return attrgetter("value")
    if issubclass(kind, str | int | float):
        return lambda value: value
    if issubclass(kind, Statement):
        return _statement_to_json
    if issubclass(kind, Explanation):
        return _explanation_to_json
    if issubclass(kind, GoalTallies):
        return lambda tallies: dict(zip(GoalTallies._fields, map(list, tallies), strict=True))
    if issubclass(kind, Mapping):
        return lambda value: {getattr(key, "value", key): _plain(part) for key, part in value.items()}
    return dataclass_to_json if is_dataclass(kind) else lambda value: [_plain(part) for part in value]


def _explanation_to_json(explanation: Explanation) -> dict[str, Json]:
    """An explanation, whose atoms are a list: the fields of a record do not depend on the answer."""
    atoms = explanation.atoms
    listed = None if atoms is None else [{"text": text, **_statement_to_json(atoms[text])} for text in atoms]
    return {**dataclass_to_json(explanation), "atoms": listed}


def _statement_to_json(statement: Statement) -> dict[str, Json]:
    return {name: _plain(part) for name, part in statement._asdict().items()}


def _explanation(value: Any) -> Any:
    """An explanation as it is written, with its atoms by their texts."""
    if not isinstance(value, dict) or not isinstance(value.get("atoms"), list):
        return value
    atoms = {atom.get("text"): {n: p for n, p in atom.items() if n != "text"} for atom in value["atoms"]}
    return {**value, "atoms": atoms}


def _verdict(values: Mapping[str, Any], ability: Ability, made_before: int) -> Verdict:
    """The verdict; of the repairs those are its own that were not made before scoring."""
    for name in COMMON:
        _present(values, name)
    status = _present(values, "status")
    reason = _present(values, "excluded_reason")
    if status != ("scored" if reason is None else "excluded"):
        raise InputError(f"field status: expected 'excluded' with a reason, or 'scored', not {status!r}")
    repairs = _read(tuple[str, ...], _present(values, "repairs"), "repairs")
    declared: type[Verdict] = declaration_of(ability).verdict
    own = {name: values[name] for name in _names(declared) if name in values}
    own |= {name: _converted(own[name], _whole_if_possible) for name in _HALVES if name in own}
    if "tried_actions" in _names(declared) and isinstance(values.get("attempts"), int):  # schema 2
        own["tried_actions"] = values["attempts"]
    return _read(declared, {**own, "excluded": reason, "repairs": repairs[made_before:]})


def _attempts(values: Mapping[str, Any], ability: Ability) -> tuple[Attempt, ...]:
    """The attempts of a record."""
    if isinstance(values.get("attempts"), int):  # schema 2: the actions that were tried for subgoals
        return ()
    found = []
    for number, own in enumerate(_read(list[dict[str, Any]], values.get("attempts") or [], "attempts")):
        made_before = _read(
            tuple[str, ...], own.get("answer_repairs", ()), f"attempts.{number}.answer_repairs"
        )
        known = {name: own[name] for name in _names(Attempt) if name in own}
        known["explanation"] = _explanation(own.get("explanation"))
        verdict = _verdict(own, ability, len(made_before))
        found.append(_read(Attempt, {**known, "verdict": verdict}, f"attempts.{number}"))
    return tuple(found)


def _origin(values: Mapping[str, Any]) -> Origin | None:
    known = {name: values[name] for name in _names(Origin) if name in values}
    return _read(Origin, known) if known else None


def _present(values: Mapping[str, Any], name: str) -> Any:
    if name not in values:
        raise InputError(f"field {name}: is missing")
    return values[name]


def _read(kind: type[T], value: object, *place: str) -> T:
    """A value of a type, from JSON.

    Raises:
        InputError: it is not one.
    """
    hashable: Any = kind
    try:
        read: T = _adapter(hashable).validate_python(value)
    except ValidationError as error:
        raise InputError(f"field {misfit(error, within=place, whole='the record')}") from error
    return read


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


def _names(declared: Any) -> Iterable[str]:
    """The names of the fields of a dataclass, in order."""
    return tuple(declared.__dataclass_fields__)
