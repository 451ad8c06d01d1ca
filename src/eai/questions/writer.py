"""Writing questions: each kind and form in turn, about one task after the other."""

from __future__ import annotations

import random
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import count, cycle, islice

from eai.abilities.protocol import Ability
from eai.abilities.task import Task
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.source import Source
from eai.planning.planner import Planner
from eai.prompts.template import Templates
from eai.questions.item import Maker
from eai.questions.one_step import applicability, backward, forward, inverse, why_not
from eai.questions.phrasing import phrase, turns
from eai.questions.plans import counterfactual, justification, state_tracking, validation
from eai.questions.question import Form, Kind, Question
from eai.questions.rules import Rules
from eai.questions.setting import Setting, open_setting
from eai.questions.ways import landmarks, next_action, reachability

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
"""What makes the items of each kind."""

_LEAST_OBJECTS = 4
"""Of a world with fewer objects nothing is asked."""

_TASKS_TRIED = 30
"""How many tasks are tried for one question."""

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
    """

    kinds: Sequence[Kind] = tuple(Kind)
    forms: Sequence[Form] = tuple(Form)
    number: int = 500
    seed: int = 0


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
        failed: dict[tuple[Kind, Form], int] = {(k, f): 0 for f in wanted.forms for k in wanted.kinds}
        seen: set[str] = set()
        turns = cycle(order) if order else iter(())
        for number in count():
            for kind, form in list(failed):
                if len(seen) == wanted.number:
                    return
                tasks = islice(turns, _TASKS_TRIED)
                question = self._one(tasks, kind, form, number, wanted.seed, seen)
                if question is None:
                    failed[kind, form] += 1
                    if failed[kind, form] == _GIVEN_UP:
                        del failed[kind, form]
                    continue
                failed[kind, form] = 0
                seen.add(question.prompt)
                yield question
            if not failed:
                return

    def _one(
        self,
        tasks: Iterator[str],
        kind: Kind,
        form: Form,
        number: int,
        seed: int,
        seen: Collection[str],
    ) -> Question | None:
        """A question that is not there yet, about the first of some tasks that gives one."""
        rng = _generator(seed, kind.value, form.value, number)
        order = turns(f"{seed} {kind.value} {form.value}")
        for task in map(self._tasks.__getitem__, tasks):
            setting = self._setting(task, seed)
            if len(setting.scene.objects) < _LEAST_OBJECTS:
                continue
            item = MAKERS[kind](setting, rng, number)
            if item is None:
                continue
            turn = order[number % len(order)]
            phrased = phrase(item, setting, kind, form, self._templates, rng, turn)
            if phrased is not None and phrased.prompt not in seen:
                return Question(
                    id=f"{kind.value}-{form.value}-{number}",
                    domain=self._benchmark.name,
                    task=task.id,
                    title=task.title,
                    kind=kind,
                    form=form,
                    depth=item.depth,
                    options=phrased.options,
                    prompt=phrased.prompt,
                    answer=phrased.answer,
                    accept=phrased.accept,
                )
        return None

    def _setting(self, task: Task, seed: int) -> Setting:
        if (task.id, seed) not in self._settings:
            own = _seed(seed, "way", task.id)
            self._settings[task.id, seed] = open_setting(task, self._rules, self._planner, own)
        return self._settings[task.id, seed]


def _generator(*parts: object) -> random.Random:
    return random.Random(_seed(*parts))  # noqa: S311 - chance, not secrets


def _seed(*parts: object) -> str:
    return "questions " + " ".join(map(str, parts))
