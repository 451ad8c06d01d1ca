"""Make the explorer of answers: one HTML file with all data, which opens from disk without a network.

Records are compact JSON. ``explorer/data.js`` reads the JSON in the page, with equal keys. Each text, step,
operator, scene and tile is stored once, in the lists ``texts``, ``steps``, ``operators``, ``scenes`` and
``tiles``. Other values refer to its index in the list. Empty values are left out.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import TYPE_CHECKING, Literal, TypeAlias, cast
from urllib.parse import quote

from eai.abilities.explanation import Explanation, StepReport, map_missed_goals_to_similar_facts
from eai.abilities.protocol import Ability
from eai.abilities.repair import describe_repair
from eai.abilities.verdict import PlanVerdict, SpanKind, Verdict
from eai.agents.verdict import ActingVerdict
from eai.base.files import to_file_name
from eai.base.json_value import Json
from eai.benchmarks.registry import get_title
from eai.results.codec import hash_text
from eai.results.page import build_page, encode_for_script
from eai.results.record import Record
from eai.results.runs import Run, RunKey
from eai.results.summary import drop_later_attempts, find_answer_outcome

if TYPE_CHECKING:
    from eai.abilities.goal_interpretation.verdict import GoalVerdict
    from eai.abilities.subgoal_decomposition.verdict import SubgoalVerdict
    from eai.abilities.transition_modeling.verdict import OperatorReport, OperatorVerdict

VERSION = 3
"""Version of the format of the page's data."""

_PACKED_KINDS = ("steps", "operators", "scenes", "tiles")
"""Names of the lists of values that are stored once and referred to by index."""

_VIEWER = "http://127.0.0.1:7575/#/logs"
"""Address at which ``inspect view`` shows logs."""


Owner: TypeAlias = Literal["agent", "object", "other"]
"""Kind of the object that a tile shows: the agent, an object that the task is about, or another object."""


_ItemIndex: TypeAlias = int
"""Index of a stored item in the list of its kind, by which other items refer to it."""


@dataclass(slots=True)
class ObjectTile:
    """The rectangle of one object in a picture of a scene.

    Attributes:
        name: name of the object.
        kind: whether the object is the agent, an object of the task, or another object.
        marks: facts about only this object, such as its states.
        lines: facts that relate the object to other objects, each as a line of text.
        zones: tiles inside this tile, by their relation to this object, such as being on it.
    """

    name: str
    kind: Owner
    marks: list[str] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    zones: dict[str, list[ObjectTile]] = field(default_factory=dict)


TileScenes: TypeAlias = Sequence[Sequence[ObjectTile]]
"""Pictures of the scene at the start and after each tried step, each as tiles that lie in no other tile."""


@dataclass(frozen=True, slots=True)
class ExplorerDomainData:
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
    find_scenes: Callable[[Record], TileScenes] = lambda _: ()
    find_film: Callable[[Record], str] = lambda _: ""


def make_film_file_name(record: Record) -> str:
    """Return the file name of an answer's film. Equal answers to a task share a film."""
    return f"{to_file_name(record.task_id)}-{hash_text(record.response)[:12]}.gif"


class ExplorerData:
    """Collects runs as JSON text for the explorer.

    Args:
        background: function that returns the background of a domain, called once for each domain.
    """

    def __init__(
        self, background: Callable[[str], ExplorerDomainData] = lambda domain: ExplorerDomainData()
    ) -> None:
        self._background = cache(background)
        self._number_of_step = cache(self._pack_step)
        self._number_of_operator = cache(self._pack_operator)
        self._numbers: dict[str, dict[str, int]] = {name: {} for name in ("texts", *_PACKED_KINDS)}
        self._runs: dict[RunKey, str] = {}
        self._prompts: dict[str, dict[str, Json]] = {}
        self._tasks: dict[str, dict[str, Json]] = {}

    def add_run(self, run: Run) -> None:
        """Add the records of a run."""
        key, background = run.key, self._background(run.key.domain)
        packed: dict[str, Json] = {
            "protocol": key.protocol.value,
            "domain": key.domain,
            "ability": key.ability.value,
            "model": key.name,
            "log": run.log and [*run.log, f"{_VIEWER}/{quote(run.log[0])}/samples/sample"],
            "answers": [self._pack_answer(record) for record in run.records],
        }
        self._runs[key] = encode_for_script(_drop_empty_values(packed))
        prompts = background.prompts.get(key.ability.value, {})
        stored = self._prompts.setdefault(f"{key.domain}/{key.ability.value}", {})
        tasks = self._tasks.setdefault(key.domain, {})
        for record in run.records:
            if record.task is not None and record.task_id not in tasks:
                instruction = " ".join(background.instructions.get(record.task_id, "").split())
                tasks[record.task_id] = [self._pack_text(record.task.name), self._pack_text(instruction)]
            prompt = prompts.get(record.task_id)
            if prompt and record.task_id not in stored:
                stored[record.task_id] = self._pack_texts(prompt.split("\n"))

    def to_json(self) -> str:
        """Return all data as one JSON text that is safe inside a script element."""
        domains = dict.fromkeys(key.domain for key in self._runs)
        content = {
            "version": encode_for_script(VERSION),
            "runs": _format_json_array(
                self._runs[key] for key in sorted(self._runs, key=lambda key: key.sort_key)
            ),
            "prompts": encode_for_script({suite: lines for suite, lines in self._prompts.items() if lines}),
            "tasks": encode_for_script({domain: tasks for domain, tasks in self._tasks.items() if tasks}),
            "titles": encode_for_script({domain: get_title(domain) for domain in domains}),
            "gold": encode_for_script(
                {domain: {**gold} for domain in domains if (gold := self._background(domain).operators)}
            ),
            "texts": encode_for_script(list(self._numbers["texts"])),
            **{name: _format_json_array(self._numbers[name]) for name in _PACKED_KINDS},
        }
        return f"{{{','.join(f'{encode_for_script(name)}:{text}' for name, text in content.items())}}}"

    def _pack_answer(self, record: Record) -> Json:
        verdict = record.verdict
        explanation = record.explanation or Explanation()
        return _drop_empty_values(
            {
                "t": self._pack_text(record.task_id),
                "o": find_answer_outcome(record).value,
                "x": self._pack_text(verdict.excluded) if verdict.excluded else None,
                "u": self._pack_text(record.unanswered) if record.unanswered else None,
                "z": 1 if record.is_cut_off else None,
                "r": self._pack_text(record.response) if record.response else None,
                "f": self._pack_error(verdict),
                "m": list(record.all_answer_repairs),
                "S": _list_spans_of_answer_text(verdict),
                "R": self._pack_texts(describe_repair(verdict.repair)) if verdict.repair else [],
                **self._pack_ability_fields(record),
                "T": self._pack_turns(record),
                "w": self._pack_texts(explanation.notes),
                "s": [self._number_of_step(step) for step in explanation.steps],
                "G": self._pack_goals(explanation),
                "A": self._pack_attempts(record),
                "F": film if (film := self._background(record.domain).find_film(record)) else None,
                "P": [
                    self._pack_scene(scene) for scene in self._background(record.domain).find_scenes(record)
                ],
            }
        )

    def _pack_goals(self, explanation: Explanation) -> list[Json]:
        """Return the goals of a task.

        Missed goals have a reason, and similar facts that the answer reached instead, as in `eai explain`.
        """
        near, goals = map_missed_goals_to_similar_facts(explanation), list[Json]()
        for goal in explanation.goals:
            got = f"got {', '.join(near[goal.goal])}" if goal.goal in near else ""
            remarks = self._pack_texts(filter(None, (goal.why, got)))
            goals.append([goal.kind, self._pack_text(goal.goal), int(goal.satisfied), *remarks])
        return goals

    def _pack_turns(self, record: Record) -> list[Json]:
        """Return a list for each turn of an episode: the reached goals, and the agent's thought."""
        turns = record.verdict.turns if isinstance(record.verdict, ActingVerdict) else ()
        is_whole = record.response.lstrip().startswith("{") and '"turns"' in record.response
        written = json.loads(record.response)["turns"] if turns and is_whole else [{} for _ in turns]
        thoughts = [self._pack_text(turn["thought"]) if turn.get("thought") else None for turn in written]
        return [[turn.goals, thought] for turn, thought in zip(turns, thoughts, strict=True)]

    def _pack_attempts(self, record: Record) -> list[Json]:
        """Return each attempt of a record as a separate answer; an empty list for a single attempt."""
        number = len(record.attempts)
        parts = [drop_later_attempts(record, k) for k in range(1, number + 1)]
        attempts = [replace(part, attempts=(), origin=None) for part in parts]
        return [self._pack_answer(attempt) for attempt in attempts] if number > 1 else []

    def _pack_ability_fields(self, record: Record) -> dict[str, Json]:
        if isinstance(record.verdict, PlanVerdict):
            return self._pack_plan_fields(record.ability, record.verdict)
        if record.ability is Ability.GOAL_INTERPRETATION:
            goals = cast("GoalVerdict", record.verdict)
            return {
                "n": {kind: list(counts) for kind, counts in (goals.counts or {}).items()},
                "h": self._pack_texts(goals.hallucinated),
            }
        if record.ability is Ability.TRANSITION_MODELING:
            return self._pack_operator_fields(cast("OperatorVerdict", record.verdict))
        return {}

    def _pack_plan_fields(self, ability: Ability, verdict: PlanVerdict) -> dict[str, Json]:
        subgoals = ability is Ability.SUBGOAL_DECOMPOSITION
        category = cast("SubgoalVerdict", verdict).category if subgoals else None
        return {
            "e": None if verdict.executable is None else int(verdict.executable),
            "a": verdict.additional_steps,
            "c": category and category.value,
            "g": None if verdict.goals is None else [list(tally) for tally in verdict.goals],
            "C": None if verdict.partial is None else list(verdict.partial),
        }

    def _pack_operator_fields(self, verdict: OperatorVerdict) -> dict[str, Json]:
        return {
            "n": {
                f"{side}/{category}": list(counts)
                for side, by_category in (verdict.counts or {}).items()
                for category, counts in by_category.items()
            },
            "p": verdict.planner and verdict.planner.value,
            "k": list(verdict.task_categories),
            "q": [self._number_of_operator(operator) for operator in verdict.operators],
        }

    def _pack_error(self, verdict: Verdict) -> Json:
        error = verdict.error
        return None if error is None else [error.kind.value, error.step, self._pack_text(error.detail)]

    def _pack_step(self, step: StepReport) -> _ItemIndex:
        """Store a step, with the fields of `StepReport` in the order that the page expects.

        Return its index.
        """
        texts = self._pack_texts((step.action, step.outcome, step.reason, step.earlier))
        facts = self._pack_texts(step.added), self._pack_texts(step.removed)
        return self._store_packed_item("steps", [*texts, *facts, step.hidden_changes])

    def _pack_scene(self, tiles: Sequence[ObjectTile]) -> _ItemIndex:
        return self._store_packed_item("scenes", [self._pack_tile(tile) for tile in tiles])

    def _pack_tile(self, tile: ObjectTile) -> _ItemIndex:
        """Store a tile: name, kind, marks, lines, and each zone with its tiles. Return its index."""
        name, marks, lines = (
            self._pack_text(tile.name),
            self._pack_texts(tile.marks),
            self._pack_texts(tile.lines),
        )
        zones: list[Json] = [
            [self._pack_text(label), [self._pack_tile(item) for item in within]]
            for label, within in tile.zones.items()
        ]
        return self._store_packed_item("tiles", [name, tile.kind, marks, lines, zones])

    def _pack_operator(self, operator: OperatorReport) -> _ItemIndex:
        """Store an operator: name, status, clauses of precondition and effect, and rule violations.

        Return its index.
        """
        sides = [
            [self._pack_texts(parts) for parts in (side.matched, side.additional, side.missing)]
            for side in (operator.precondition, operator.effect)
        ]
        offences = [
            {"offence": offence.offence.value, "name": offence.name, "place": offence.place}
            for offence in operator.offences
        ]
        return self._store_packed_item("operators", [operator.name, operator.status.value, *sides, offences])

    def _pack_texts(self, texts: Iterable[str]) -> list[Json]:
        return [self._pack_text(text) for text in texts]

    def _pack_text(self, text: str) -> int:
        return self._find_item_index("texts", text)

    def _store_packed_item(self, kind: str, packed: list[Json]) -> _ItemIndex:
        return self._find_item_index(kind, encode_for_script(packed))

    def _find_item_index(self, kind: str, item: str) -> _ItemIndex:
        """Return the index of an item in the list of its kind. A new item is added at the end."""
        numbers = self._numbers[kind]
        return numbers.setdefault(item, len(numbers))


def _format_json_array(items: Iterable[str]) -> str:
    return f"[{','.join(items)}]"


def _list_spans_of_answer_text(verdict: Verdict) -> list[Json]:
    """Return the parts of an answer's text as lists (start, end, kind); empty if all kinds are `READ`."""
    if all(span.kind is SpanKind.READ for span in verdict.spans):
        return []
    return [[span.start, span.end, span.kind.value] for span in verdict.spans]


def _drop_empty_values(values: Mapping[str, Json]) -> dict[str, Json]:
    return {key: value for key, value in values.items() if value not in (None, [], {}, "")}


SCRIPTS = (
    "data.js",
    "dom.js",
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


def build_explorer_page(data: str) -> str:
    """Return the HTML page of the explorer.

    Args:
        data: JSON text from `ExplorerData.to_json`.
    """
    return build_page("eai.studies.report", "explorer", SCRIPTS, data)
