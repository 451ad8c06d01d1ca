"""Write questions. Kinds of question and forms of answer take turns, and tasks take turns, too."""

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
from eai.extensions.questions.question import Accept, Question, QuestionForm, QuestionKind
from eai.extensions.questions.setting import (
    ItemMaker,
    QuestionContent,
    QuestionSetting,
    format_list,
    make_question_setting,
)
from eai.extensions.questions.shortcuts import (
    LETTERS,
    ClosedQuestion,
    SurfaceCueCounts,
    draw_closed_question,
)
from eai.planning.planner import Planner
from eai.tasks.prompts.template import PromptTemplates
from eai.tasks.rules import DomainRules
from eai.tasks.source import USUAL_SOURCE, Source

ITEM_MAKERS: Mapping[QuestionKind, ItemMaker] = {
    QuestionKind.FORWARD: one_step.make_question_about_facts_after_action,
    QuestionKind.BACKWARD: one_step.make_question_about_action_for_fact,
    QuestionKind.INVERSE: one_step.make_question_about_action_with_given_changes,
    QuestionKind.STATE: plans.make_state_tracking_question,
    QuestionKind.APPLICABILITY: one_step.make_applicability_question,
    QuestionKind.WHY_NOT: one_step.make_why_not_question,
    QuestionKind.COUNTERFACTUAL: plans.make_counterfactual_question,
    QuestionKind.VALIDATION: plans.make_validation_question,
    QuestionKind.JUSTIFICATION: plans.make_justification_question,
    QuestionKind.REACHABILITY: plans.make_reachability_question,
    QuestionKind.NEXT_ACTION: plans.make_next_action_question,
    QuestionKind.LANDMARKS: plans.make_landmarks_question,
}
"""For each kind of question, the function that makes the content of such a question."""

_MIN_OBJECTS = 4
"""Minimum number of objects in the scene of a task. Smaller tasks get no questions."""

_MAX_TASKS_PER_QUESTION = 30
"""Maximum number of tasks that are tried to make one question."""

_ITEMS_PER_TASK = 2
"""Number of attempts to make a question about a task before the next task is tried."""

_MAX_FAILURES = 5
"""Maximum number of failed attempts in a row. Then no more questions of a kind and form are tried."""


_ANSWER_BLOCKS = 16
"""Number of blocks after which the order of right letters repeats.

In each block, every letter is the right answer once.
"""

_NEED_RULES = frozenset(
    [
        *((QuestionKind.WHY_NOT, form) for form in QuestionForm),
        (QuestionKind.COUNTERFACTUAL, QuestionForm.OPEN),
        (QuestionKind.VALIDATION, QuestionForm.OPEN),
    ]
)
"""Kinds of questions, with the form of the answer, that refer to the requirements of actions by number.

Their prompts must therefore list the rules of actions with these numbers.
"""


@dataclass(slots=True)
class _QuestionGroupProgress:
    """Progress of the questions of one kind and form while they are written.

    Attributes:
        kind: subject of the questions.
        form: form of the answers.
        ledger: how often the statements that shortcuts take were right.
        failures: number of failed attempts in a row.
    """

    kind: QuestionKind
    form: QuestionForm
    ledger: SurfaceCueCounts
    failures: int = 0


class _QuestionDraft(NamedTuple):
    """A question before it is put into words: its setting, its content, and choices (None in open form)."""

    setting: QuestionSetting
    item: QuestionContent
    closed: ClosedQuestion | None


class QuestionGenerator:
    """Writes questions about the tasks of one benchmark.

    Args:
        benchmark: the benchmark.
        source: access to the benchmark's data.
        templates: the templates of prompts.
    """

    def __init__(
        self, benchmark: Benchmark, source: Source = USUAL_SOURCE, templates: PromptTemplates | None = None
    ) -> None:
        self._benchmark = benchmark
        self._tasks = benchmark.tasks_for(Ability.ACTION_SEQUENCING, source)
        self._templates = templates or PromptTemplates()
        self._rules = DomainRules(benchmark.domain)
        self._planner = Planner(benchmark.domain)
        self._setting = cache(self._open_setting)

    def write_questions(
        self,
        kinds: Sequence[QuestionKind] = tuple(QuestionKind),
        forms: Sequence[QuestionForm] = tuple(QuestionForm),
        number: int = 500,
        seed: int = 0,
        *,
        rules: bool = True,
    ) -> Iterator[Question]:
        """Yield questions. Kinds and forms take turns, so any first questions are spread evenly over them.

        There are fewer than ``number`` questions if the tasks do not allow more. Equal arguments give equal
        questions.

        Args:
            kinds: the kinds of question.
            forms: the forms of answer.
            number: number of questions, spread evenly over kinds and forms.
            seed: seed of all random choices.
            rules: whether prompts state the rules of actions. Without rules, questions about numbered
                requirements are left out. All other questions keep their id.
        """
        order = _make_random_generator(seed, "tasks").sample(list(self._tasks), len(self._tasks))
        tasks = cycle(order) if order else iter(())
        groups = [_QuestionGroupProgress(kind, form, SurfaceCueCounts()) for form in forms for kind in kinds]
        written, seen = 0, set[str]()
        for turn in count():
            groups = [group for group in groups if group.failures < _MAX_FAILURES]
            if not any(rules or (group.kind, group.form) not in _NEED_RULES for group in groups):
                return
            for group in groups:
                if written == number:
                    return
                drafts = self._make_drafts(islice(tasks, _MAX_TASKS_PER_QUESTION), group, turn, seed)
                phrased = (
                    (draft, *self._write_question_and_prompt_without_rules(draft, group, turn))
                    for draft in drafts
                )
                phrased_draft = next(
                    (candidate for candidate in phrased if candidate[1].prompt not in seen), None
                )
                group.failures = group.failures + 1 if phrased_draft is None else 0
                if phrased_draft is None:
                    continue
                draft, question, closed = phrased_draft
                seen.add(question.prompt)
                shortcuts = (
                    {}
                    if draft.closed is None
                    else group.ledger.add_question_and_score_shortcuts(draft.closed)
                )
                prompt = question.prompt if rules else closed
                if prompt is not None:
                    written += 1
                    yield question.model_copy(update={"prompt": prompt, "shortcuts": shortcuts})

    def _make_drafts(
        self, tasks: Iterator[str], group: _QuestionGroupProgress, number: int, seed: int
    ) -> Iterator[_QuestionDraft]:
        """Yield several drafts of the question with this number; each draft is about one of the tasks.

        Drafts that keep all shortcuts near chance come first. The other drafts follow; drafts that favour
        shortcuts least come first.
        """
        rng = _make_random_generator(seed, group.kind.value, group.form.value, number)
        order = _draw_answer_order(f"{seed} {group.kind.value} {group.form.value}")
        others: list[tuple[int, _QuestionDraft]] = []
        for task_id in (name for name in tasks for _ in range(_ITEMS_PER_TASK)):
            setting = self._setting(task_id, seed)
            if len(setting.scene.objects) < _MIN_OBJECTS:
                continue
            item = ITEM_MAKERS[group.kind](setting, rng, number)
            if item is None:
                continue
            posed, excess = None, 0
            if group.form is not QuestionForm.OPEN:
                question_text = _format_question_text(item, setting, group, self._templates)
                best = draw_closed_question(
                    item, setting, group.form, question_text, group.ledger, rng, order[number % len(order)]
                )
                if best is None:
                    continue
                excess, posed = best
            if excess:
                others.append((excess, _QuestionDraft(setting, item, posed)))
            else:
                yield _QuestionDraft(setting, item, posed)
        for _, draft in sorted(others, key=itemgetter(0)):
            yield draft

    def _write_question_and_prompt_without_rules(
        self, draft: _QuestionDraft, group: _QuestionGroupProgress, number: int
    ) -> tuple[Question, str | None]:
        """Return the question that a draft becomes, and its prompt without the rules of actions.

        This prompt is None if the question needs the rules.
        """
        setting, item, posed = draft
        form, shown = group.form, [] if posed is None else posed.shown
        right = None if posed is None else posed.right
        match form:
            case QuestionForm.OPEN:
                choices, answer = "", tuple(item.answer)
            case QuestionForm.YES_NO:
                choices, answer = shown[0], ("no" if right is None else "yes",)
            case QuestionForm.CHOICE:
                choices = "\n".join(
                    [f"{letter}. {text}" for letter, text in zip(LETTERS, shown, strict=True)]
                )
                answer = (LETTERS[right or 0],)
        accept = item.accept if form is QuestionForm.OPEN else "all"
        values = self._make_question_template_values(draft, group, choices, accept)
        question = Question(
            id=f"{group.kind.value}-{form.value}-{number}",
            domain=self._benchmark.name,
            task=setting.task.id,
            title=setting.task.title,
            kind=group.kind,
            form=form,
            depth=item.depth,
            options=2 if form is QuestionForm.YES_NO else len(shown),
            prompt=self._templates.fill_template("question.txt", values),
            answer=answer,
            accept=accept,
        )
        needs_rules = (group.kind, form) in _NEED_RULES
        return question, None if needs_rules else self._templates.fill_template("closed_book.txt", values)

    def _make_question_template_values(
        self, draft: _QuestionDraft, group: _QuestionGroupProgress, choices: str, required_answers: Accept
    ) -> Mapping[str, str]:
        setting, item, posed = draft
        operators = item.operators
        if item.are_actions and posed is not None:
            operators = {text.partition("(")[0] for text in posed.shown}
        form = "any" if required_answers == "any" else group.form.value
        return {
            "objects": _format_objects(setting),
            "facts": _format_facts(setting, item, operators),
            "rules": setting.rules.write_rules(operators, item.formulas),
            "actions": setting.rules.write_operator_heads(operators),
            "question": _format_question_text(item, setting, group, self._templates, choices),
            "answer": self._templates.read(f"questions/answer.{form}.txt"),
        }

    def _open_setting(self, task_id: str, seed: int) -> QuestionSetting:
        task_seed = _make_seed(seed, "way", task_id)
        return make_question_setting(self._tasks[task_id], self._rules, self._planner, task_seed)


def _format_question_text(
    item: QuestionContent,
    setting: QuestionSetting,
    group: _QuestionGroupProgress,
    templates: PromptTemplates,
    choices: str = "",
) -> str:
    fluents = ", ".join(sorted(setting.rules.changeable_visible_predicates))
    values = {**item.values, "statement": choices, "choices": choices, "fluents": fluents}
    return templates.fill_template(f"questions/{group.kind.value}.{group.form.value}.txt", values)


def _format_objects(setting: QuestionSetting) -> str:
    agent, list_kinds = setting.scene.agent, setting.scene.vocabulary.list_kind_with_ancestors
    return format_list(
        [
            f"{thing.name} [{', '.join(list_kinds(thing.category))}]{', the agent' if i == agent else ''}"
            for i, thing in enumerate(setting.scene.objects)
        ]
    )


def _format_facts(setting: QuestionSetting, item: QuestionContent, operators: Collection[str]) -> str:
    """Return the facts that a prompt shows as lines, one line for each predicate.

    They are all facts that actions can change, and the other facts that the rules refer to. ``p(a, {b, c})``
    stands for ``p(a, b)`` and ``p(a, c)``.
    """
    shown = setting.rules.changeable_visible_predicates | setting.rules.find_used_predicates(
        operators, item.formulas
    )
    names = [thing.name for thing in setting.scene.objects]
    lines: dict[str, list[str]] = {}
    facts = [fact for fact in item.state.facts() if fact.predicate in shown]
    for (predicate, first), group in groupby(facts, lambda fact: (fact.predicate, fact.arguments[:-1])):
        last = [[names[i] for i in fact.arguments[-1:]] for fact in group]
        if first and len(last) > 1:
            last = [["{" + ", ".join([name for (name,) in last]) + "}"]]
        before = [names[i] for i in first]
        texts = [f"{predicate}({', '.join([*before, *arguments])})" for arguments in last]
        lines.setdefault(predicate, []).extend(texts)
    return format_list([", ".join(texts) for texts in lines.values()]) or "- nothing"


def _draw_answer_order(seed: str) -> list[int]:
    """Return random numbers from 0 to 3, of which each places the right answer of one question.

    Later questions begin again with the first number. A number stands for a letter, or for yes or no. In each
    block of four numbers, every letter occurs once, and yes and no occur twice.
    """
    rng = random.Random(seed)  # noqa: S311 - chance, not secrets
    return [turn for _ in range(_ANSWER_BLOCKS) for turn in rng.sample(range(len(LETTERS)), len(LETTERS))]


def _make_random_generator(*parts: object) -> random.Random:
    return random.Random(_make_seed(*parts))  # noqa: S311 - chance, not secrets


def _make_seed(*parts: object) -> str:
    return "questions " + " ".join(map(str, parts))
