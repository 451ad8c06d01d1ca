"""Write questions: kinds and forms take turns, and so do the tasks."""

from __future__ import annotations

import random
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import count, cycle, groupby, islice
from operator import itemgetter
from typing import NamedTuple

from eai.abilities.protocol import Ability
from eai.benchmarks.benchmark import Benchmark
from eai.extensions.questions import one_step, plans
from eai.extensions.questions.question import Accept, Form, Kind, Question
from eai.extensions.questions.setting import Item, Maker, Setting, listed, open_setting
from eai.extensions.questions.shortcuts import LETTERS, Ledger, Posed, pose
from eai.planning.planner import Planner
from eai.tasks.prompts.template import Templates
from eai.tasks.rules import DomainRules
from eai.tasks.source import USUAL_SOURCE, Source

MAKERS: Mapping[Kind, Maker] = {
    Kind.FORWARD: one_step.forward,
    Kind.BACKWARD: one_step.backward,
    Kind.INVERSE: one_step.inverse,
    Kind.STATE: plans.state_tracking,
    Kind.APPLICABILITY: one_step.applicability,
    Kind.WHY_NOT: one_step.why_not,
    Kind.COUNTERFACTUAL: plans.counterfactual,
    Kind.VALIDATION: plans.validation,
    Kind.JUSTIFICATION: plans.justification,
    Kind.REACHABILITY: plans.reachability,
    Kind.NEXT_ACTION: plans.next_action,
    Kind.LANDMARKS: plans.landmarks,
}
"""The function that makes the items of each kind."""

_LEAST_OBJECTS = 4
"""Minimum number of objects in the scene of a task."""

_TASKS_TRIED = 30
"""Maximum number of tasks that are tried for one question."""

_ITEMS = 2
"""Number of items that are tried for each task."""

_GIVEN_UP = 5
"""Maximum number of failed attempts in a row for one kind and form."""


_BLOCKS = 16
"""Number of blocks, each with every letter once, before the order of right answers repeats."""

_ABOUT_RULES = frozenset(
    [*((Kind.WHY_NOT, form) for form in Form), (Kind.COUNTERFACTUAL, Form.OPEN), (Kind.VALIDATION, Form.OPEN)]
)
"""Kinds and forms that refer to numbered requirements, so they need the rules in the prompt."""


@dataclass(slots=True)
class _Cell:
    """State of one kind and form while questions are written.

    Attributes:
        kind: subject of the questions.
        form: form of their answers.
        ledger: counts of what shortcuts gain.
        failed: number of failed attempts in a row.
    """

    kind: Kind
    form: Form
    ledger: Ledger
    failed: int = 0


class _Draft(NamedTuple):
    """A draft of a question: its material, its content and its choices; no choices in open form."""

    setting: Setting
    item: Item
    posed: Posed | None


class Writer:
    """Writes questions about the tasks of one benchmark.

    Args:
        benchmark: the benchmark.
        source: access to its data.
        templates: the templates of prompts.
    """

    def __init__(
        self, benchmark: Benchmark, source: Source = USUAL_SOURCE, templates: Templates | None = None
    ) -> None:
        self._benchmark = benchmark
        self._tasks = benchmark.tasks_for(Ability.ACTION_SEQUENCING, source)
        self._templates = templates or Templates()
        self._rules = DomainRules(benchmark.domain)
        self._planner = Planner(benchmark.domain)
        self._setting = cache(self._open_setting)

    def write(
        self,
        kinds: Sequence[Kind] = tuple(Kind),
        forms: Sequence[Form] = tuple(Form),
        number: int = 500,
        seed: int = 0,
        *,
        rules: bool = True,
    ) -> Iterator[Question]:
        """Yield questions. Any first part of them is spread evenly over kinds and forms.

        There are fewer than ``number`` if the tasks do not yield enough. Equal arguments, equal questions.

        Args:
            kinds: the kinds of question.
            forms: the forms of answer.
            number: number of questions, spread evenly over kinds and forms.
            seed: seed of all random choices.
            rules: whether prompts state the rules. If not, questions about numbered requirements are
                then left out. All other questions keep their id.
        """
        order = _generator(seed, "tasks").sample(list(self._tasks), len(self._tasks))
        tasks = cycle(order) if order else iter(())
        cells = [_Cell(kind, form, Ledger()) for form in forms for kind in kinds]
        written, seen = 0, set[str]()
        for turn in count():
            cells = [cell for cell in cells if cell.failed < _GIVEN_UP]
            if not any(rules or (cell.kind, cell.form) not in _ABOUT_RULES for cell in cells):
                return
            for cell in cells:
                if written == number:
                    return
                drafts = self._drafts(islice(tasks, _TASKS_TRIED), cell, turn, seed)
                phrased = ((draft, *self._phrased(draft, cell, turn)) for draft in drafts)
                found = next((each for each in phrased if each[1].prompt not in seen), None)
                cell.failed = cell.failed + 1 if found is None else 0
                if found is None:
                    continue
                draft, question, closed = found
                seen.add(question.prompt)
                shortcuts = {} if draft.posed is None else cell.ledger.add(draft.posed)
                prompt = question.prompt if rules else closed
                if prompt is not None:
                    written += 1
                    yield question.model_copy(update={"prompt": prompt, "shortcuts": shortcuts})

    def _drafts(self, tasks: Iterator[str], cell: _Cell, number: int, seed: int) -> Iterator[_Draft]:
        """Yield drafts about the tasks: first drafts that keep shortcuts near chance, then the rest."""
        rng = _generator(seed, cell.kind.value, cell.form.value, number)
        order = _turns(f"{seed} {cell.kind.value} {cell.form.value}")
        others: list[tuple[int, _Draft]] = []
        for task_id in (each for each in tasks for _ in range(_ITEMS)):
            setting = self._setting(task_id, seed)
            if len(setting.scene.objects) < _LEAST_OBJECTS:
                continue
            item = MAKERS[cell.kind](setting, rng, number)
            if item is None:
                continue
            posed, excess = None, 0
            if cell.form is not Form.OPEN:
                asked = _question_text(item, setting, cell, self._templates)
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

    def _phrased(self, draft: _Draft, cell: _Cell, turn: int) -> tuple[Question, str | None]:
        """Return a draft as a question, and its closed-book prompt if it does not need the rules."""
        setting, item, posed = draft
        form, shown = cell.form, [] if posed is None else posed.shown
        right = None if posed is None else posed.right
        match form:
            case Form.OPEN:
                choices, answer = "", tuple(item.answer)
            case Form.YES_NO:
                choices, answer = shown[0], ("no" if right is None else "yes",)
            case Form.CHOICE:
                choices = "\n".join(
                    [f"{letter}. {text}" for letter, text in zip(LETTERS, shown, strict=True)]
                )
                answer = (LETTERS[right or 0],)
        accept = item.accept if form is Form.OPEN else "all"
        values = self._values(draft, cell, choices, accept)
        question = Question(
            id=f"{cell.kind.value}-{form.value}-{turn}",
            domain=self._benchmark.name,
            task=setting.task.id,
            title=setting.task.title,
            kind=cell.kind,
            form=form,
            depth=item.depth,
            options=2 if form is Form.YES_NO else len(shown),
            prompt=self._templates.fill("question.txt", values),
            answer=answer,
            accept=accept,
        )
        needs_rules = (cell.kind, form) in _ABOUT_RULES
        return question, None if needs_rules else self._templates.fill("closed_book.txt", values)

    def _values(self, draft: _Draft, cell: _Cell, choices: str, accept: Accept) -> Mapping[str, str]:
        setting, item, posed = draft
        operators = item.operators
        if item.actions and posed is not None:
            operators = {text.partition("(")[0] for text in posed.shown}
        form = "any" if accept == "any" else cell.form.value
        return {
            "objects": _objects(setting),
            "facts": _facts(setting, item, operators),
            "rules": setting.rules.write_rules(operators, item.formulas),
            "actions": setting.rules.write_heads(operators),
            "question": _question_text(item, setting, cell, self._templates, choices),
            "answer": self._templates.read(f"questions/answer.{form}.txt"),
        }

    def _open_setting(self, task_id: str, seed: int) -> Setting:
        own = _seed(seed, "way", task_id)
        return open_setting(self._tasks[task_id], self._rules, self._planner, own)


def _question_text(item: Item, setting: Setting, cell: _Cell, templates: Templates, choices: str = "") -> str:
    """Return the text of a question, with the choices if they are given."""
    fluents = ", ".join(sorted(setting.rules.fluents))
    values = {**item.values, "statement": choices, "choices": choices, "fluents": fluents}
    return templates.fill(f"questions/{cell.kind.value}.{cell.form.value}.txt", values)


def _objects(setting: Setting) -> str:
    agent = setting.scene.agent
    return listed(
        [
            f"{thing.name} [{thing.category}]{', the agent' if i == agent else ''}"
            for i, thing in enumerate(setting.scene.objects)
        ]
    )


def _facts(setting: Setting, item: Item, operators: Collection[str]) -> str:
    """Return the shown facts as lines: all changeable facts, and the other facts that the rules refer to.

    Each predicate has a line, in which ``p(a, {b, c})`` stands for ``p(a, b)`` and ``p(a, c)``.
    """
    shown = setting.rules.fluents | setting.rules.find_predicates(operators, item.formulas)
    names = [thing.name for thing in setting.scene.objects]
    lines: dict[str, list[str]] = {}
    facts = [fact for fact in item.state.facts() if fact.predicate in shown]
    for (predicate, first), alike in groupby(facts, lambda fact: (fact.predicate, fact.arguments[:-1])):
        last = [[names[i] for i in fact.arguments[-1:]] for fact in alike]
        if first and len(last) > 1:
            last = [["{" + ", ".join([name for (name,) in last]) + "}"]]
        before = [names[i] for i in first]
        texts = [f"{predicate}({', '.join([*before, *each])})" for each in last]
        lines.setdefault(predicate, []).extend(texts)
    return listed([", ".join(texts) for texts in lines.values()]) or "- nothing"


def _turns(seed: str) -> list[int]:
    """Return the order of right answers, which repeats.

    Of four consecutive turns, two are yes and two are no, and each letter occurs once.
    """
    rng = random.Random(seed)  # noqa: S311 - chance, not secrets
    return [turn for _ in range(_BLOCKS) for turn in rng.sample(range(len(LETTERS)), len(LETTERS))]


def _generator(*parts: object) -> random.Random:
    return random.Random(_seed(*parts))  # noqa: S311 - chance, not secrets


def _seed(*parts: object) -> str:
    return "questions " + " ".join(map(str, parts))
