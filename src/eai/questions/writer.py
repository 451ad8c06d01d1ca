"""Writing questions: each kind and form in turn, about one task after the other."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import count, cycle, islice
from operator import itemgetter
from typing import NamedTuple

from eai.abilities.protocol import Ability
from eai.abilities.task import Task
from eai.benchmark.benchmark import Benchmark
from eai.planning.planner import Planner
from eai.prompts.template import Templates
from eai.questions.one_step import applicability, backward, forward, inverse, why_not
from eai.questions.phrasing import Phrased, can_be_closed, phrase, pose, question_text, turns
from eai.questions.plans import counterfactual, justification, state_tracking, validation
from eai.questions.question import Form, Kind, Question
from eai.questions.rules import Rules
from eai.questions.setting import Item, Maker, Setting, open_setting
from eai.questions.shortcuts import Ledger, Posed
from eai.questions.ways import landmarks, next_action, reachability
from eai.tasks.source import Source

MAKERS: Mapping[Kind, Maker] = {
    Kind.FORWARD: forward,
    Kind.BACKWARD: backward,
    Kind.INVERSE: inverse,
    Kind.STATE: state_tracking,
    Kind.APPLICABILITY: applicability,
    Kind.WHY_NOT: why_not,
    Kind.COUNTERFACTUAL: counterfactual,
    Kind.VALIDATION: validation,
    Kind.JUSTIFICATION: justification,
    Kind.REACHABILITY: reachability,
    Kind.NEXT_ACTION: next_action,
    Kind.LANDMARKS: landmarks,
}
"""The makers of the items of each kind."""

_LEAST_OBJECTS = 4
"""Of a world with fewer objects nothing is asked."""

_TASKS_TRIED = 30
"""How many tasks are tried for one question."""

_ITEMS = 2
"""How many items of each of these are tried."""

_GIVEN_UP = 5
"""How often in a row none of these gives a question, until there are no more of its kind and form."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """Which questions are wanted.

    Attributes:
        kinds: what is asked about.
        forms: how answers are given.
        number: how many, as evenly spread over kinds and forms as can be.
        seed: of all that is random.
        rules: whether prompts tell the rules. Questions without them are the same, by id; those about the
            numbers of requirements are left out.
    """

    kinds: Sequence[Kind] = tuple(Kind)
    forms: Sequence[Form] = tuple(Form)
    number: int = 500
    seed: int = 0
    rules: bool = True


@dataclass(slots=True)
class _Cell:
    """The questions of one kind and form, as far as they are written.

    Attributes:
        kind: the kind.
        form: the form.
        ledger: what shortcuts get of them.
        failed: how often in a row there was none.
    """

    kind: Kind
    form: Form
    ledger: Ledger
    failed: int = 0


class _Draft(NamedTuple):
    """A draft that a question could be made of."""

    setting: Setting
    item: Item
    posed: Posed | None


class Writer:
    """Writes questions about the tasks of one benchmark.

    Args:
        benchmark: the benchmark.
        source: where its data comes from; the user's default store if None.
        templates: the texts of prompts.
    """

    def __init__(
        self, benchmark: Benchmark, source: Source | None = None, templates: Templates | None = None
    ) -> None:
        self._benchmark = benchmark
        self._tasks = benchmark.tasks_for(Ability.ACTION_SEQUENCING, source or Source())
        self._templates = templates or Templates()
        self._rules = Rules(benchmark.domain)
        self._planner = Planner(benchmark.domain)
        self._settings: dict[tuple[str, int], Setting] = {}

    def write(self, wanted: Wanted) -> Iterator[Question]:
        """The questions, each as good as the next: any first part of them is as evenly spread.

        There are fewer where the tasks do not give as many. Equal arguments give equal questions.
        """
        order = _generator(wanted.seed, "tasks").sample(list(self._tasks), len(self._tasks))
        tasks = cycle(order) if order else iter(())
        cells = [_Cell(kind, form, Ledger()) for form in wanted.forms for kind in wanted.kinds]
        written, seen = 0, set[str]()
        for number in count():
            cells = [cell for cell in cells if cell.failed < _GIVEN_UP]
            if not any(wanted.rules or can_be_closed(cell.kind, cell.form) for cell in cells):
                return
            for cell in cells:
                if written == wanted.number:
                    return
                drafts = self._drafts(islice(tasks, _TASKS_TRIED), cell, number, wanted.seed)
                said = ((draft, self._phrased(draft, cell)) for draft in drafts)
                found = next((each for each in said if each[1].prompt not in seen), None)
                cell.failed = cell.failed + 1 if found is None else 0
                if found is None:
                    continue
                draft, phrased = found
                seen.add(phrased.prompt)
                shortcuts = {} if draft.posed is None else cell.ledger.add(draft.posed)
                prompt = phrased.prompt if wanted.rules else phrased.closed
                if prompt is None:
                    continue
                written += 1
                yield Question(
                    id=f"{cell.kind.value}-{cell.form.value}-{number}",
                    domain=self._benchmark.name,
                    task=draft.setting.task.id,
                    title=draft.setting.task.title,
                    kind=cell.kind,
                    form=cell.form,
                    depth=draft.item.depth,
                    options=phrased.options,
                    prompt=prompt,
                    answer=phrased.answer,
                    accept=phrased.accept,
                    shortcuts=shortcuts,
                )

    def _phrased(self, draft: _Draft, cell: _Cell) -> Phrased:
        return phrase(draft.item, draft.setting, cell.kind, cell.form, self._templates, draft.posed)

    def _drafts(self, tasks: Iterator[str], cell: _Cell, number: int, seed: int) -> Iterator[_Draft]:
        """Drafts about tasks: those that keep shortcuts near chance, then the others, best first."""
        rng = _generator(seed, cell.kind.value, cell.form.value, number)
        order = turns(f"{seed} {cell.kind.value} {cell.form.value}")
        others: list[tuple[int, _Draft]] = []
        for task in (self._tasks[each] for each in tasks for _ in range(_ITEMS)):
            setting = self._setting(task, seed)
            if len(setting.scene.objects) < _LEAST_OBJECTS:
                continue
            item = MAKERS[cell.kind](setting, rng, number)
            if item is None:
                continue
            posed, excess = None, 0
            if cell.form is not Form.OPEN:
                asked = question_text(item, setting, cell.kind, cell.form, self._templates)
                best = pose(item, setting, cell.form, asked, cell.ledger, rng, order[number % len(order)])
                if best is None:
                    continue
                excess, posed = best
            if excess:
                others.append((excess, _Draft(setting, item, posed)))
            else:
                yield _Draft(setting, item, posed)
        for _, draft in sorted(others, key=itemgetter(0)):
            yield draft

    def _setting(self, task: Task, seed: int) -> Setting:
        if (task.id, seed) not in self._settings:
            own = _seed(seed, "way", task.id)
            self._settings[task.id, seed] = open_setting(task, self._rules, self._planner, own)
        return self._settings[task.id, seed]


def _generator(*parts: object) -> random.Random:
    return random.Random(_seed(*parts))  # noqa: S311 - chance, not secrets


def _seed(*parts: object) -> str:
    return "questions " + " ".join(map(str, parts))
