"""The explorer: one HTML file with everything in it, which opens from disk and reaches for nothing.

Records are compact JSON, in which each text stands once. The page reads it with ``explorer/data.js``, which
knows the same keys. Texts are numbers into ``texts``, steps and operators numbers into ``steps`` and
``operators``, scenes and the tiles in them into ``scenes`` and ``tiles``; what is empty is left out.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import TYPE_CHECKING, Literal, TypeAlias, cast
from urllib.parse import quote

from eai.abilities.explanation import Explanation, StepReport, find_near_misses
from eai.abilities.protocol import Ability
from eai.abilities.repair import repair_lines
from eai.abilities.verdict import PlanVerdict, SpanKind, Verdict
from eai.agents.verdict import ActingVerdict
from eai.base.files import to_file_name
from eai.base.json_value import Json
from eai.benchmarks.registry import title_of
from eai.results.codec import sha256_of
from eai.results.page import build_page, encode_for_script
from eai.results.record import Record
from eai.results.runs import Run, RunKey
from eai.results.summary import keep_attempts, outcome_of

if TYPE_CHECKING:
    from eai.abilities.goal_interpretation.verdict import GoalVerdict
    from eai.abilities.subgoal_decomposition.verdict import SubgoalVerdict
    from eai.abilities.transition_modeling.verdict import OperatorReport, OperatorVerdict

VERSION = 3
"""The version of the format."""

_PARTS = ("steps", "operators", "scenes", "tiles")
"""The parts that are packed once, and are numbers where they stand."""

_VIEWER = "http://127.0.0.1:7575/#/logs"
"""The address at which ``inspect view`` shows logs."""


Owner: TypeAlias = Literal["agent", "object", "other"]
"""The owner of a tile: the agent, an object that the task is about, or another one."""


@dataclass(slots=True)
class Tile:
    """The view of an object in a picture.

    Attributes:
        name: its name.
        kind: whose it is.
        marks: what is said of it alone.
        lines: its relations to others, each a line.
        zones: the tiles that lie in it, by the relation in which they do.
    """

    name: str
    kind: Owner
    marks: list[str] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    zones: dict[str, list[Tile]] = field(default_factory=dict)


Course: TypeAlias = Sequence[Sequence[Tile]]
"""The outermost tiles at the start and after each step that was tried; nothing where they are not known."""


@dataclass(frozen=True, slots=True)
class Background:
    """The questions behind the answers of a domain, where they are at hand.

    Attributes:
        prompts: ability -> task -> prompt.
        operators: operator -> its definition in the data set.
        instructions: task -> what it is in natural language.
        course: what gives the scenes that an answer passes through.
        film: what gives the address of an answer's film beside the page; empty where there is none.
    """

    prompts: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    operators: Mapping[str, str] = field(default_factory=dict)
    instructions: Mapping[str, str] = field(default_factory=dict)
    course: Callable[[Record], Course] = lambda _: ()
    film: Callable[[Record], str] = lambda _: ""


def film_name(record: Record) -> str:
    """The name of the file with the film of an answer in a folder of films, the same for equal answers."""
    return f"{to_file_name(record.task_id)}-{sha256_of(record.response)[:12]}.gif"


class ExplorerData:
    """Runs are added one by one; what is kept of them is text.

    Args:
        background: gives that of a domain, for which it is asked once.
    """

    def __init__(self, background: Callable[[str], Background] = lambda domain: Background()) -> None:
        self._background = cache(background)
        self._number_of_step = cache(self._step)
        self._number_of_operator = cache(self._operator)
        self._known: dict[str, dict[str, int]] = {name: {} for name in ("texts", *_PARTS)}
        self._runs: dict[RunKey, str] = {}
        self._prompts: dict[str, dict[str, Json]] = {}
        self._tasks: dict[str, dict[str, Json]] = {}

    def add(self, run: Run) -> None:
        """Add the records of a run."""
        key, background = run.key, self._background(run.key.domain)
        packed: dict[str, Json] = {
            "protocol": key.protocol.value,
            "domain": key.domain,
            "ability": key.ability.value,
            "model": key.name,
            "log": run.log and [*run.log, f"{_VIEWER}/{quote(run.log[0])}/samples/sample"],
            "answers": [self._answer(record) for record in run.records],
        }
        self._runs[key] = encode_for_script(_without_empty(packed))
        asked = background.prompts.get(key.ability.value, {})
        kept = self._prompts.setdefault(f"{key.domain}/{key.ability.value}", {})
        tasks = self._tasks.setdefault(key.domain, {})
        for record in run.records:
            if record.task is not None and record.task_id not in tasks:
                instruction = " ".join(background.instructions.get(record.task_id, "").split())
                tasks[record.task_id] = [self._text(record.task.name), self._text(instruction)]
            prompt = asked.get(record.task_id)
            if prompt and record.task_id not in kept:
                kept[record.task_id] = self._all(prompt.split("\n"))

    def to_json(self) -> str:
        """Everything as one JSON text that is safe inside a script element."""
        domains = dict.fromkeys(key.domain for key in self._runs)
        content = {
            "version": encode_for_script(VERSION),
            "runs": _array(self._runs[key] for key in sorted(self._runs, key=lambda key: key.order)),
            "prompts": encode_for_script({suite: lines for suite, lines in self._prompts.items() if lines}),
            "tasks": encode_for_script({domain: tasks for domain, tasks in self._tasks.items() if tasks}),
            "titles": encode_for_script({domain: title_of(domain) for domain in domains}),
            "gold": encode_for_script(
                {domain: {**gold} for domain in domains if (gold := self._background(domain).operators)}
            ),
            "texts": encode_for_script(list(self._known["texts"])),
            **{name: _array(self._known[name]) for name in _PARTS},
        }
        return f"{{{','.join(f'{encode_for_script(name)}:{text}' for name, text in content.items())}}}"

    def _answer(self, record: Record) -> Json:
        verdict = record.verdict
        explanation = record.explanation or Explanation()
        return _without_empty(
            {
                "t": self._text(record.task_id),
                "o": outcome_of(record).value,
                "x": self._text(verdict.excluded) if verdict.excluded else None,
                "u": self._text(record.unanswered) if record.unanswered else None,
                "r": self._text(record.response) if record.response else None,
                "f": self._error(verdict),
                "m": list(record.repairs),
                "S": _spans(verdict),
                "R": self._all(repair_lines(verdict.repair)) if verdict.repair else [],
                **self._own(record),
                "T": self._turns(record),
                "w": self._all(explanation.notes),
                "s": [self._number_of_step(step) for step in explanation.steps],
                "G": self._goals(explanation),
                "A": self._attempts(record),
                "F": film if (film := self._background(record.domain).film(record)) else None,
                "P": [self._scene(scene) for scene in self._background(record.domain).course(record)],
            }
        )

    def _goals(self, explanation: Explanation) -> list[Json]:
        """Each goal; with a missed one, why, and the facts that came about instead, as `eai explain` says."""
        near, goals = find_near_misses(explanation), list[Json]()
        for goal in explanation.goals:
            got = f"got {', '.join(near[goal.goal])}" if goal.goal in near else ""
            remarks = self._all(filter(None, (goal.why, got)))
            goals.append([goal.kind, self._text(goal.goal), int(goal.satisfied), *remarks])
        return goals

    def _turns(self, record: Record) -> list[Json]:
        """Of each turn of an episode the goals reached after it, and the agent's words beside its command."""
        turns = record.verdict.turns if isinstance(record.verdict, ActingVerdict) else ()
        is_whole = record.response.lstrip().startswith("{") and '"turns"' in record.response
        written = json.loads(record.response)["turns"] if turns and is_whole else [{} for _ in turns]
        thoughts = [self._text(turn["thought"]) if turn.get("thought") else None for turn in written]
        return [[turn.goals, thought] for turn, thought in zip(turns, thoughts, strict=True)]

    def _attempts(self, record: Record) -> list[Json]:
        """Each of several attempts, as an answer of its own."""
        number = len(record.attempts)
        each = [replace(keep_attempts(record, k), attempts=()) for k in range(1, number + 1)]
        return [self._answer(attempt) for attempt in each] if number > 1 else []

    def _own(self, record: Record) -> dict[str, Json]:
        """The further fields of the verdicts of an ability."""
        if isinstance(record.verdict, PlanVerdict):
            return self._of_plan(record.ability, record.verdict)
        if record.ability is Ability.GOAL_INTERPRETATION:
            goals = cast("GoalVerdict", record.verdict)
            return {
                "n": {kind: list(counts) for kind, counts in (goals.counts or {}).items()},
                "h": self._all(goals.hallucinated),
            }
        if record.ability is Ability.TRANSITION_MODELING:
            return self._of_operators(cast("OperatorVerdict", record.verdict))
        return {}

    def _of_plan(self, ability: Ability, verdict: PlanVerdict) -> dict[str, Json]:
        subgoals = ability is Ability.SUBGOAL_DECOMPOSITION
        category = cast("SubgoalVerdict", verdict).category if subgoals else None
        return {
            "e": None if verdict.executable is None else int(verdict.executable),
            "a": verdict.additional_steps,
            "c": category and category.value,
            "g": None if verdict.goals is None else [list(tally) for tally in verdict.goals],
            "C": None if verdict.partial is None else list(verdict.partial),
        }

    def _of_operators(self, verdict: OperatorVerdict) -> dict[str, Json]:
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

    def _error(self, verdict: Verdict) -> Json:
        error = verdict.error
        return None if error is None else [error.kind.value, error.step, self._text(error.detail)]

    def _step(self, step: StepReport) -> int:
        """Action, outcome, reason, earlier, facts added, facts removed, number of other changes."""
        texts = self._all((step.action, step.outcome, step.reason, step.earlier))
        facts = self._all(step.added), self._all(step.removed)
        return self._part("steps", [*texts, *facts, step.hidden_changes])

    def _scene(self, tiles: Sequence[Tile]) -> int:
        """The outermost tiles."""
        return self._part("scenes", [self._tile(tile) for tile in tiles])

    def _tile(self, tile: Tile) -> int:
        """Name, kind, marks, lines, and each zone with the tiles in it."""
        name, marks, lines = self._text(tile.name), self._all(tile.marks), self._all(tile.lines)
        zones: list[Json] = [
            [self._text(label), [self._tile(each) for each in within]] for label, within in tile.zones.items()
        ]
        return self._part("tiles", [name, tile.kind, marks, lines, zones])

    def _operator(self, operator: OperatorReport) -> int:
        """Name, status, the sides with what is matched, additional and missing, and offences."""
        sides = [
            [self._all(parts) for parts in (side.matched, side.additional, side.missing)]
            for side in (operator.precondition, operator.effect)
        ]
        offences = [
            {"offence": offence.offence.value, "name": offence.name, "place": offence.place}
            for offence in operator.offences
        ]
        return self._part("operators", [operator.name, operator.status.value, *sides, offences])

    def _all(self, texts: Iterable[str]) -> list[Json]:
        return [self._text(text) for text in texts]

    def _text(self, text: str) -> int:
        return self._number("texts", text)

    def _part(self, kind: str, packed: list[Json]) -> int:
        return self._number(kind, encode_for_script(packed))

    def _number(self, kind: str, item: str) -> int:
        """The place of an item among those of its kind, to which it is added if it is not there."""
        known = self._known[kind]
        return known.setdefault(item, len(known))


def _array(items: Iterable[str]) -> str:
    return f"[{','.join(items)}]"


def _spans(verdict: Verdict) -> list[Json]:
    """Return the parts of an answer's text and what became of each; none if all was read as it is."""
    if all(span.kind is SpanKind.READ for span in verdict.spans):
        return []
    return [[span.start, span.end, span.kind.value] for span in verdict.spans]


def _without_empty(values: Mapping[str, Json]) -> dict[str, Json]:
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
"""The parts of the program, in the order in which they need each other."""


def explorer_html(data: str) -> str:
    """The page.

    Args:
        data: from `ExplorerData.to_json`.
    """
    return build_page("eai.studies.report", "explorer", SCRIPTS, data)
