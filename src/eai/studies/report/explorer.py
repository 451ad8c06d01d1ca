"""Make the explorer of answers: one HTML file with all data. It opens from disk without a network.

The data are lines of base64. Each line is a chunk of compressed JSON, whose keys ``explorer/data.js`` reads.
The last line is the index: the fields that list and filter answers. The other lines have details of answers,
a few runs each, and the page reads a line when it shows one of its answers. Each field is a column of values,
with null for empty values.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import zip_longest
from typing import TYPE_CHECKING, Literal, TypeAlias, cast

from eai.abilities.explanation import StepReport, VerdictExplanation, map_missed_goals_to_similar_facts
from eai.abilities.protocol import Ability
from eai.abilities.repair import describe_repair
from eai.abilities.verdict import ALL, AnswerSpanKind, PlanVerdict, Verdict
from eai.agents.setting import ACTING
from eai.agents.verdict import EpisodeVerdict
from eai.base.files import to_file_name
from eai.base.json_value import Json
from eai.benchmarks.registry import get_title
from eai.results.codec import hash_text
from eai.results.page import build_page
from eai.results.plots import OUTCOME_COLORS
from eai.results.record import Record
from eai.results.runs import Run
from eai.results.summary import drop_later_attempts, find_answer_outcome

if TYPE_CHECKING:
    from eai.abilities.goal_interpretation.verdict import GoalVerdict
    from eai.abilities.subgoal_decomposition.verdict import SubgoalVerdict
    from eai.abilities.transition_modeling.verdict import OperatorReport, OperatorVerdict
    from eai.abilities.verdict import ConfusionCounts

VERSION = 5
"""Version of the format of the data in the explorer (page ``explorer.html``)."""

_INDEX_FIELDS = frozenset({"run", "t", "o", "z", "f", "m", "k", "c", "p", "a", "h", "N"})
"""Short names of the fields by which the explorer lists and filters answers. All other fields are details."""

_MAX_RUNS_PER_CHUNK = 4
"""Maximum number of runs whose answers are compressed together, as one chunk of the page's data.

The runs of a chunk belong to one suite.
"""

_DATA = "{{data}}"
"""Text in the HTML page that stands for the data, which are inserted there."""

_VIEWER = "http://127.0.0.1:7575/#/logs"
"""Address at which ``inspect view`` shows logs."""


ObjectRole: TypeAlias = Literal["agent", "object", "other"]
"""Kind of object in a diagram of a scene: the agent, an object of the task, or another object."""


_Row: TypeAlias = "dict[str, Json]"
"""JSON values by the short names that the page expects, such as the fields of an answer."""

_RunNames: TypeAlias = "tuple[str, str, str, str]"
"""Protocol (scoring rules), domain, ability and model of a run."""

_encode_json = json.JSONEncoder(separators=(",", ":")).encode


@dataclass(slots=True)
class ObjectRectangle:
    """The rectangle of one object in a picture of a scene.

    Attributes:
        name: name of the object.
        kind: whether the object is the agent, an object of the task, or another object.
        marks: facts about only this object, such as its states.
        lines: facts that relate the object to other objects, each as a line of text.
        zones: rectangles inside this one, by the relation of their objects to this object, such as ``on``.
    """

    name: str
    kind: ObjectRole
    marks: list[str] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    zones: dict[str, list[ObjectRectangle]] = field(default_factory=dict)


SceneDiagrams: TypeAlias = Sequence[Sequence[ObjectRectangle]]
"""Diagrams of the scene: one of the initial state, and one of the state after each tried step.

A diagram is a list of its outermost rectangles. They contain all other rectangles of the diagram.
"""


@dataclass(frozen=True, slots=True)
class DomainDataOfExplorerPage:
    """Questions, operators and scenes of a domain that the explorer shows beside answers, if available.

    Attributes:
        prompts: ability -> task -> prompt.
        operators: name of an operator -> definition of the operator in the data set.
        instructions: task -> the task in natural language.
        find_scenes: returns the pictures of the scene for an answer's record; empty if unknown.
        find_film: returns the address of the film of an answer, relative to the page; empty without a film.
    """

    prompts: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    operators: Mapping[str, str] = field(default_factory=dict)
    instructions: Mapping[str, str] = field(default_factory=dict)
    find_scenes: Callable[[Record], SceneDiagrams] = lambda _: ()
    find_film: Callable[[Record], str] = lambda _: ""


def make_film_file_name(record: Record) -> str:
    """Return the file name of an answer's film. Equal answers to a task share a film."""
    return f"{to_file_name(record.task_id)}-{hash_text(record.response)[:12]}.gif"


class ExplorerPageData:
    """Collects runs for the explorer. Only compressed data of the collected runs stay in memory.

    Args:
        background: function that returns the data that all runs of a domain share, called once for a domain.
        outcomes: mapping from outcomes in logs of other projects to colours; the first outcome is a success.
            A page with such outcomes shows no rate of success.
    """

    def __init__(
        self,
        background: Callable[[str], DomainDataOfExplorerPage] = lambda domain: DomainDataOfExplorerPage(),
        outcomes: Mapping[str, str] | None = None,
    ) -> None:
        self._success = next(iter(outcomes or ()), "success")
        self._outcomes = {kind.value: color for kind, color in OUTCOME_COLORS.items()} | {**(outcomes or {})}
        self._background = cache(background)
        self._logged_runs: dict[_RunNames, list[_Row]] = {}
        self._runs: list[_Row] = []
        self._sort_keys: list[tuple[int | str, ...]] = []
        self._suite: tuple[str, ...] = ()
        self._rows_by_run: list[list[_Row]] = []
        self._pictures: dict[str, dict[str, int]] = {"tiles": {}, "scenes": {}}
        self._details: list[bytes] = []
        self._index = zlib.compressobj(zlib.Z_BEST_COMPRESSION)
        self._compressed_index = [self._index.compress(b'{"chunks":[')]
        self._prompts: dict[str, dict[str, str]] = {}
        self._tasks: dict[str, _Row] = {}

    def add_run(self, run: Run) -> None:
        """Add a run, with its stored verdicts on answers, to the explorer."""
        key, background = run.key, self._background(run.key.domain)
        log: Json = run.log and [*run.log, _VIEWER]
        self._start_collecting_answers_of_run(
            (key.protocol.value, key.domain, key.ability.value, key.name), key.sort_key, log
        )
        self._rows_by_run.append([self._make_answer_fields(record) for record in run.records])
        prompts = background.prompts.get(key.ability.value, {})
        stored = self._prompts.setdefault(f"{key.domain}/{key.ability.value}", {})
        tasks = self._tasks.setdefault(key.domain, {})
        for record in run.records:
            if record.task is not None and record.task_id not in tasks:
                instruction = " ".join(background.instructions.get(record.task_id, "").split())
                tasks[record.task_id] = [record.task.name, instruction]
            if prompt := prompts.get(record.task_id):
                stored[record.task_id] = prompt

    def add_logged_episode(
        self,
        domain_protocol_model: tuple[str, str, str],
        task: str,
        outcome: str,
        *,
        error: tuple[str, int, str] | None,
        lines: Iterable[str],
        steps: Iterable[StepReport],
    ) -> None:
        """Add an episode from another project's log to the explorer.

        Args:
            domain_protocol_model: domain, protocol and model, as the page shows them.
            task: the task.
            outcome: a key of the argument ``outcomes`` of `ExplorerPageData`.
            error: kind, number of the step, and reason of the first error; None if the log shows no error.
            lines: sentences about the outcome.
            steps: the actions. In addition to the outcomes of `StepReport`, their outcomes can be
                ``accepted`` and ``cannot_tell``.
        """
        domain, protocol, model = domain_protocol_model
        values: _Row = {
            "t": task,
            "o": outcome,
            "f": error and [*error],
            "R": [*lines],
            "s": [_convert_step_report_to_json(step) for step in steps],
        }
        rows = self._logged_runs.setdefault((protocol, domain, ACTING.value, model), [])
        rows.append(_drop_empty_values(values))

    def format_data_as_base64_lines(self) -> Iterator[str]:
        """Yield all data of the explorer as lines of base64, a chunk of compressed JSON each.

        First come details of answers, then prompts, and last the index of all answers.
        """
        for names, rows in self._logged_runs.items():
            self._start_collecting_answers_of_run(names)
            self._rows_by_run.append(rows)
        self._logged_runs.clear()
        self._compress_answers_of_collected_runs()
        prompts = {suite: texts for suite, texts in self._prompts.items() if texts}
        order = sorted(range(len(self._runs)), key=self._sort_keys.__getitem__)
        content: _Row = {
            "version": VERSION,
            "success": self._success,
            "outcomes": self._outcomes,
            "runs": self._runs,
            "order": order,
            "prompts": {suite: len(self._details) + number for number, suite in enumerate(prompts)},
            "tasks": self._tasks,
            "titles": {domain: get_title(domain) for domain in self._tasks},
            "gold": {domain: {**self._background(domain).operators} for domain in self._tasks},
        }
        index = self._index.copy()
        end = index.compress(f"],{_encode_json(content)[1:]}".encode()) + index.flush()
        yield from map(_encode_as_base64_line, self._details)
        yield from map(
            _encode_as_base64_line,
            map(_compress, map(_encode_prompts_as_indices_of_shared_lines, prompts.values())),
        )
        yield _encode_as_base64_line(b"".join([*self._compressed_index, end]))

    def _start_collecting_answers_of_run(
        self, names: _RunNames, sort_key: tuple[int | str, ...] = (), log: Json = None
    ) -> None:
        """Add the names of a run (protocol, domain, ability, model), to which the next answers belong.

        Before that, compress the answers collected so far if they belong to another suite, or if they are
        from `_MAX_RUNS_PER_CHUNK` runs.
        """
        if names[:3] != self._suite or len(self._rows_by_run) == _MAX_RUNS_PER_CHUNK:
            self._compress_answers_of_collected_runs()
        self._suite = names[:3]
        packed = dict(zip(("protocol", "domain", "ability", "model"), names, strict=True))
        self._runs.append(_drop_empty_values({**packed, "log": log}))
        self._sort_keys.append(sort_key)

    def _compress_answers_of_collected_runs(self) -> None:
        """Compress the answers of the runs since the last call, as one chunk of the page's data.

        Answers of several runs to a task are neighbors, because similar neighbors compress better.
        """
        if not self._rows_by_run:
            return
        first = len(self._runs) - len(self._rows_by_run)
        runs = [[{"run": n, **row} for row in rows] for n, rows in enumerate(self._rows_by_run, first)]
        rows = [row for neighbors in zip_longest(*runs) for row in neighbors if row is not None]
        names = dict.fromkeys(name for row in rows for name in row)
        columns = {name: [row.get(name) for row in rows] for name in names}
        listed = {name: column for name, column in columns.items() if name in _INDEX_FIELDS}
        details = {name: column for name, column in columns.items() if name not in _INDEX_FIELDS}
        separator = "," if self._details else ""
        self._compressed_index.append(self._index.compress(f"{separator}{_encode_json(listed)}".encode()))
        pictures = {kind: [*items] for kind, items in self._pictures.items()}
        self._details.append(_compress({"columns": details, **pictures}))
        self._rows_by_run, self._pictures = [], {kind: {} for kind in self._pictures}

    def _make_answer_fields(self, record: Record) -> _Row:
        verdict, error = record.verdict, record.verdict.error
        explanation, background = record.explanation or VerdictExplanation(), self._background(record.domain)
        fields = _make_ability_specific_fields(record)
        # field q lists the clauses of operators, and the explanation's notes would repeat this list
        notes = () if "q" in fields else explanation.notes
        return _drop_empty_values(
            {
                "t": record.task_id,
                "o": find_answer_outcome(record).value,
                "x": verdict.excluded,
                "u": record.unanswered,
                "z": 1 if record.is_cut_off else None,
                "r": record.response,
                "f": None if error is None else [error.kind.value, error.step, error.detail],
                "m": list(record.all_answer_repairs),
                "S": _list_answer_spans_with_parsing_outcome(verdict),
                "R": [*describe_repair(verdict.repair)] if verdict.repair else [],
                **fields,
                "T": _list_turns(record),
                "w": [*notes],
                "s": [_convert_step_report_to_json(step) for step in explanation.steps],
                "G": _list_goals(explanation),
                "A": self._list_attempts(record),
                "F": background.find_film(record),
                "P": [self._store_scene_and_get_index(scene) for scene in background.find_scenes(record)],
            }
        )

    def _list_attempts(self, record: Record) -> list[Json]:
        """Return each attempt at a record's task as a separate answer; an empty list for a single attempt."""
        number = len(record.attempts)
        parts = [drop_later_attempts(record, k) for k in range(1, number + 1)]
        attempts = [replace(part, attempts=(), origin=None) for part in parts]
        return [self._make_answer_fields(attempt) for attempt in attempts] if number > 1 else []

    def _store_scene_and_get_index(self, rectangles: Sequence[ObjectRectangle]) -> int:
        return self._store_picture_and_get_index(
            "scenes", [self._store_rectangle_and_get_index(rectangle) for rectangle in rectangles]
        )

    def _store_rectangle_and_get_index(self, rectangle: ObjectRectangle) -> int:
        """Store a rectangle and the rectangles inside, and return its index among the stored rectangles."""
        zones: list[Json] = [
            [label, [self._store_rectangle_and_get_index(item) for item in within]]
            for label, within in rectangle.zones.items()
        ]
        fields = [rectangle.name, rectangle.kind, rectangle.marks, rectangle.lines, zones]
        return self._store_picture_and_get_index("tiles", fields)

    def _store_picture_and_get_index(self, kind: str, picture: Json) -> int:
        """Store a picture unless it is stored already, and return its index in the list of its kind.

        The kinds are scenes, and rectangles of objects in scenes. The lists start anew with each chunk of the
        page's data.
        """
        indices = self._pictures[kind]
        return indices.setdefault(_encode_json(picture), len(indices))


def _compress(content: Json) -> bytes:
    return zlib.compress(_encode_json(content).encode(), zlib.Z_BEST_COMPRESSION)


def _encode_as_base64_line(compressed: bytes) -> str:
    return f"{base64.b64encode(compressed).decode()}\n"


def _encode_prompts_as_indices_of_shared_lines(prompts: Mapping[str, str]) -> Json:
    """Return all different lines of the prompts, and each task's prompt as a list of indices of lines."""
    lines: dict[str, int] = {}
    tasks = {
        task: [lines.setdefault(line, len(lines)) for line in prompt.split("\n")]
        for task, prompt in prompts.items()
    }
    return {"lines": [*lines], "tasks": tasks}


def _list_goals(explanation: VerdictExplanation) -> list[Json]:
    """Return a list for each goal of a task: its kind, its text, and 1 if it is reached, otherwise 0.

    A missed goal also has a reason, and similar facts that the answer reached instead, as in `eai explain`.
    """
    near, goals = map_missed_goals_to_similar_facts(explanation), list[Json]()
    for goal in explanation.goals:
        got = f"got {', '.join(near[goal.goal])}" if goal.goal in near else ""
        goals.append([goal.kind, goal.goal, int(goal.satisfied), *filter(None, (goal.why, got))])
    return goals


def _list_turns(record: Record) -> list[Json]:
    """Return a pair for each turn of an episode: the reached goals, and the agent's thought."""
    turns = record.verdict.turns if isinstance(record.verdict, EpisodeVerdict) else ()
    is_whole = record.response.lstrip().startswith("{") and '"turns"' in record.response
    written = json.loads(record.response)["turns"] if turns and is_whole else [{} for _ in turns]
    # a replay that stopped early has fewer turns than the answer
    thoughts = [turn.get("thought") or None for turn in written[: len(turns)]]
    return [[turn.goals, thought] for turn, thought in zip(turns, thoughts, strict=True)]


def _make_ability_specific_fields(record: Record) -> _Row:
    if isinstance(record.verdict, PlanVerdict):
        return _make_plan_fields(record.ability, record.verdict)
    if record.ability is Ability.GOAL_INTERPRETATION:
        goals = cast("GoalVerdict", record.verdict)
        return {**_make_confusion_count_fields(goals.counts or {}), "h": list(goals.hallucinated)}
    if record.ability is Ability.TRANSITION_MODELING:
        return _make_operator_fields(cast("OperatorVerdict", record.verdict))
    return {}


def _make_confusion_count_fields(counts: Mapping[str, ConfusionCounts]) -> _Row:
    """Return fields with counts of right, wrong and missed goals or clauses: by name, and their sums."""
    wholes = [count for name, count in counts.items() if name.rpartition("/")[2] == ALL]
    sums = [sum(numbers) for numbers in zip(*(wholes or counts.values()), strict=True)]
    return {"n": {name: list(count) for name, count in counts.items() if any(count)}, "N": sums}


def _make_plan_fields(ability: Ability, verdict: PlanVerdict) -> _Row:
    subgoals = ability is Ability.SUBGOAL_DECOMPOSITION
    category = cast("SubgoalVerdict", verdict).category if subgoals else None
    return {
        "e": None if verdict.executable is None else int(verdict.executable),
        "a": verdict.additional_steps,
        "c": category and category.value,
        "C": None if verdict.partial is None else list(verdict.partial),
    }


def _make_operator_fields(verdict: OperatorVerdict) -> _Row:
    counts = {
        f"{side}/{category}": count
        for side, by_category in (verdict.counts or {}).items()
        for category, count in by_category.items()
    }
    return {
        **_make_confusion_count_fields(counts),
        "p": verdict.planner and verdict.planner.value,
        "k": list(verdict.task_categories),
        "q": [_convert_operator_report_to_json(operator) for operator in verdict.operators],
    }


def _convert_step_report_to_json(step: StepReport) -> Json:
    """Return the fields of a step in the order that the JavaScript of ``explorer.html`` expects."""
    facts = [*step.added], [*step.removed]
    return [step.action, step.outcome, step.reason, step.earlier, *facts, step.hidden_changes]


def _convert_operator_report_to_json(operator: OperatorReport) -> Json:
    """Return an operator: name, status, clauses of precondition and effect, and rule violations."""
    sides = [
        [[*side.matched], [*side.additional], [*side.missing]]
        for side in (operator.precondition, operator.effect)
    ]
    offences = [
        {"offence": offence.offence.value, "name": offence.name, "place": offence.place}
        for offence in operator.offences
    ]
    return [operator.name, operator.status.value, *sides, offences]


def _list_answer_spans_with_parsing_outcome(verdict: Verdict) -> list[Json]:
    """Return the parts of an answer's text, each as (start, end, how it was read).

    A part can be repaired, skipped as prose, or unreadable, for example (`AnswerSpanKind`). The list is empty
    if the whole text was read without such parts.
    """
    if all(span.kind is AnswerSpanKind.READ for span in verdict.spans):
        return []
    return [[span.start, span.end, span.kind.value] for span in verdict.spans]


def _drop_empty_values(values: Mapping[str, Json]) -> dict[str, Json]:
    return {key: value for key, value in values.items() if value not in (None, [], {}, "")}


SCRIPTS = (
    "dom.js",
    "data.js",
    "state.js",
    "filters.js",
    "list.js",
    "scene.js",
    "replay.js",
    "operators.js",
    "detail.js",
    "compare.js",
    "main.js",
)
"""Names of the page's script files, in order. A script may use the scripts before it."""


def build_explorer_page(lines: Iterable[str]) -> Iterator[str]:
    """Yield the HTML page of the explorer in pieces.

    Args:
        lines: lines of data from `ExplorerPageData.format_data_as_base64_lines`.
    """
    head, _, tail = build_page("eai.studies.report", "explorer", SCRIPTS, _DATA).partition(_DATA)
    yield head
    yield from lines
    yield tail
