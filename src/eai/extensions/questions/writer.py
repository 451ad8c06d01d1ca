"""Write questions. Kinds of question and forms of answer take turns, and tasks take turns, too.

The questions of one kind and form are a group. A group does not depend on other groups, so worker processes
can write several groups at once.
"""

from __future__ import annotations

import hashlib
import random
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from itertools import groupby
from operator import itemgetter
from typing import NamedTuple

from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.base.store import ignore_progress
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark
from eai.extensions.questions import one_step, plans
from eai.extensions.questions.question import Accept, Question, QuestionForm, QuestionKind
from eai.extensions.questions.setting import (
    ItemMaker,
    QuestionSetting,
    QuestionWithRightAndWrongTexts,
    format_list,
    make_question_setting,
)
from eai.extensions.questions.shortcuts import (
    LETTERS,
    SurfaceCueCounts,
    YesNoOrChoiceQuestion,
    draw_question_with_least_shortcut_bias,
)
from eai.planning.planner import Planner
from eai.results.workers import WorkerPool
from eai.tasks.prompts.template import PromptTemplates
from eai.tasks.rules import DomainRulesInPrompts
from eai.tasks.source import USUAL_SOURCE, Source

ITEM_MAKERS: Mapping[QuestionKind, ItemMaker] = {
    QuestionKind.FORWARD: one_step.make_question_about_facts_after_action,
    QuestionKind.BACKWARD: one_step.make_question_about_action_that_changes_fact,
    QuestionKind.INVERSE: one_step.make_question_about_action_that_made_changes,
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

_ATTEMPTS_PER_TASK = 2
"""Number of attempts to make a question about a task before the next task is tried."""

_MAX_FAILURES = 5
"""Number of failures in a row after which no more questions of a kind and form are tried."""

_MAX_QUESTIONS_PER_BATCH = 8
"""Maximum number of turns in a batch. In each turn, a worker tries to write a question of one kind and form.

The worker returns the questions at the end of the batch.
"""

_ANSWER_BLOCKS = 16
"""Number of blocks in the order in which right answers follow each other.

A block is a random order of the letters of all choices, A to D. After the last block, the first one follows.
"""

_GROUPS = tuple([(kind, form) for form in QuestionForm for kind in QuestionKind])
"""All pairs of a kind of question and a form of answer. The questions of one pair are a group.

All groups take the tasks in one random order. Each group begins at a different position of this order, which
is proportional to the index of the pair in this tuple.
"""

_NEED_RULES = frozenset(
    [
        *((QuestionKind.WHY_NOT, form) for form in QuestionForm),
        (QuestionKind.COUNTERFACTUAL, QuestionForm.OPEN),
        (QuestionKind.VALIDATION, QuestionForm.OPEN),
    ]
)
"""Pairs of kind and form whose questions refer to the requirements of actions by number.

The prompt of such a question must therefore list the rules of actions with these numbers.
"""


@dataclass(slots=True)
class _QuestionGroupProgress:
    """Progress of the questions of one kind and form while they are written.

    Attributes:
        kind: subject of the questions.
        form: form of the answers.
        turn: number of the next question.
        tried_tasks: number of tasks that were tried so far.
        cue_counts: how often shortcuts (rules without knowledge of the world) chose a right statement.
        prompt_hashes: SHA-256 digests of all prompts.
        failures: number of failed attempts in a row.
    """

    kind: QuestionKind
    form: QuestionForm
    turn: int = 0
    tried_tasks: int = 0
    cue_counts: SurfaceCueCounts = field(default_factory=SurfaceCueCounts)
    prompt_hashes: set[bytes] = field(default_factory=set)
    failures: int = 0


class _QuestionBatch(NamedTuple):
    """The next questions of a group.

    Attributes:
        group: the group, with its progress after these questions.
        questions: an entry for each attempt: the question, or None if the attempt failed. After too many
            failures, no more attempts are made.
    """

    group: _QuestionGroupProgress
    questions: Sequence[Question | None]


class _QuestionDraft(NamedTuple):
    """A question before it is put into words: its setting, its content, and choices (None in open form)."""

    setting: QuestionSetting
    item: QuestionWithRightAndWrongTexts
    closed: YesNoOrChoiceQuestion | None


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
        self._source = source
        self._tasks = benchmark.tasks_for(Ability.ACTION_SEQUENCING, source)
        self._templates = templates or PromptTemplates()
        self._rules = DomainRulesInPrompts(benchmark.domain)
        self._planner = Planner(benchmark.domain)
        self._setting = cache(self._make_question_setting_of_task)
        self._order = cache(self._draw_task_order)

    def __reduce__(
        self,
    ) -> tuple[Callable[..., QuestionGenerator], tuple[str, Source, PromptTemplates]]:
        """Pickle this object as a call that makes it again. Functions of domains cannot be pickled."""
        if not self._benchmark.reference:
            raise InputError(
                f"{self._benchmark.name}: worker processes need a benchmark opened by name or module:object"
            )
        source = replace(self._source, report=ignore_progress)
        return _open_question_generator, (self._benchmark.reference, source, self._templates)

    def write_questions(
        self,
        kinds: Sequence[QuestionKind] = tuple(QuestionKind),
        forms: Sequence[QuestionForm] = tuple(QuestionForm),
        number: int = 500,
        seed: int = 0,
        *,
        rules: bool = True,
        pool: WorkerPool | None = None,
        report: Callable[[int], None] = lambda written: None,
    ) -> Iterator[Question]:
        """Yield questions, with kinds and forms in turn.

        So the first questions contain all kinds and forms about equally often. There are fewer than
        ``number`` questions if the tasks do not allow more. Equal arguments give equal questions, with any
        number of workers.

        Args:
            kinds: the kinds of question.
            forms: the forms of answer.
            number: number of questions, spread evenly over kinds and forms.
            seed: seed of all random choices.
            rules: whether prompts state the rules of actions. Without rules, questions that refer to
                requirements of actions by number are left out (`_NEED_RULES`). All other questions have the
                same ids with rules and without.
            pool: worker processes that write the questions; None if this process writes them.
            report: is called with the number of questions so far.
        """
        pool = WorkerPool() if pool is None else pool
        groups = [
            _QuestionGroupProgress(kind, form)
            for form in dict.fromkeys(forms)
            for kind in dict.fromkeys(kinds)
            if rules or (kind, form) not in _NEED_RULES
        ]
        write = partial(_write_question_batches, self, seed, rules)
        written = 0
        while groups and written < number:
            missing = number - written
            turns = max(1, min(_MAX_QUESTIONS_PER_BATCH, missing // len(groups)))
            upcoming = [(group, turns) for group in groups[:missing]]
            results: list[_QuestionBatch] = []
            for result in pool.map_batches(write, upcoming, batch_sizes=(1, 1)):
                results.append(result)
                written += sum(question is not None for question in result.questions)
                report(written)
            for questions_of_turn in zip(*[result.questions for result in results], strict=True):
                yield from [question for question in questions_of_turn if question is not None]
            groups = [
                *groups[missing:],
                *[result.group for result in results if result.group.failures < _MAX_FAILURES],
            ]

    def write_next_questions_of_group(
        self, group: _QuestionGroupProgress, seed: int, question_count: int, *, show_action_rules: bool
    ) -> _QuestionBatch:
        """Try to write the next questions of a group.

        Args:
            group: the group, whose progress is updated.
            seed: seed of all random choices.
            question_count: number of questions to try.
            show_action_rules: whether prompts state the rules of actions.
        """
        questions = [
            self._write_next_question(group, seed, show_action_rules=show_action_rules)
            for _ in range(question_count)
        ]
        return _QuestionBatch(group, questions)

    def _write_next_question(
        self, group: _QuestionGroupProgress, seed: int, *, show_action_rules: bool
    ) -> Question | None:
        if group.failures == _MAX_FAILURES:
            return None
        turn, group.turn = group.turn, group.turn + 1
        for draft in self._make_drafts(self._yield_next_task_ids(group, seed), group, turn, seed):
            question, closed = self._write_question_and_closed_book_prompt(draft, group, turn)
            prompt_hash = hashlib.sha256(question.prompt.encode()).digest()
            if prompt_hash in group.prompt_hashes:
                continue
            group.failures = 0
            group.prompt_hashes.add(prompt_hash)
            shortcuts = (
                {}
                if draft.closed is None
                else group.cue_counts.score_shortcuts_and_update_cue_counts(draft.closed)
            )
            prompt = question.prompt if show_action_rules else closed
            return question.model_copy(update={"prompt": prompt, "shortcuts": shortcuts})
        group.failures += 1
        return None

    def _yield_next_task_ids(self, group: _QuestionGroupProgress, seed: int) -> Iterator[str]:
        """Yield the ids of the tasks to try next for a group of questions.

        All groups use one random order of the tasks, but begin at different positions.
        """
        order = self._order(seed)
        start = _GROUPS.index((group.kind, group.form)) * len(order) // len(_GROUPS)
        for _ in range(_MAX_TASKS_PER_QUESTION if order else 0):
            group.tried_tasks += 1
            yield order[(start + group.tried_tasks) % len(order)]

    def _draw_task_order(self, seed: int) -> list[str]:
        return _make_random_generator(seed, "tasks").sample(list(self._tasks), len(self._tasks))

    def _make_drafts(
        self, tasks: Iterator[str], group: _QuestionGroupProgress, number: int, seed: int
    ) -> Iterator[_QuestionDraft]:
        """Yield several drafts of the question with this number; each draft is about one of the tasks.

        A shortcut is a rule that answers without knowledge of the world. First come the drafts that keep the
        bias towards shortcuts within the tolerated bias. The other drafts follow, with the smallest bias
        first.
        """
        rng = _make_random_generator(seed, group.kind.value, group.form.value, number)
        order = _draw_balanced_right_answer_positions(f"{seed} {group.kind.value} {group.form.value}")
        others: list[tuple[int, _QuestionDraft]] = []
        for task_id in (name for name in tasks for _ in range(_ATTEMPTS_PER_TASK)):
            setting = self._setting(task_id, seed)
            if len(setting.scene.objects) < _MIN_OBJECTS:
                continue
            item = ITEM_MAKERS[group.kind](setting, rng, number)
            if item is None:
                continue
            posed, excess = None, 0
            if group.form is not QuestionForm.OPEN:
                question_text = _format_question_text(item, setting, group, self._templates)
                best = draw_question_with_least_shortcut_bias(
                    item,
                    setting,
                    group.form,
                    question_text,
                    group.cue_counts,
                    rng,
                    order[number % len(order)],
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

    def _write_question_and_closed_book_prompt(
        self, draft: _QuestionDraft, group: _QuestionGroupProgress, number: int
    ) -> tuple[Question, str | None]:
        """Return the question made from a draft, and a second prompt, which omits the rules of actions.

        A draft is a question before it is put into words. The second prompt is None if the question refers to
        requirements in the rules by number.
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
            "facts": _format_state_facts_for_question_prompt(setting, item, operators),
            "rules": setting.rules.write_rules(operators, item.formulas),
            "actions": setting.rules.write_operator_signatures(operators),
            "question": _format_question_text(item, setting, group, self._templates, choices),
            "answer": self._templates.read(f"questions/answer.{form}.txt"),
        }

    def _make_question_setting_of_task(self, task_id: str, seed: int) -> QuestionSetting:
        task_seed = _make_seed(seed, "way", task_id)
        return make_question_setting(self._tasks[task_id], self._rules, self._planner, task_seed)


def _open_question_generator(reference: str, source: Source, templates: PromptTemplates) -> QuestionGenerator:
    return QuestionGenerator(find_benchmark(reference), source, templates)


def _write_question_batches(
    generator: QuestionGenerator,
    seed: int,
    show_action_rules: bool,
    groups_and_turns: Sequence[tuple[_QuestionGroupProgress, int]],
) -> list[_QuestionBatch]:
    return [
        generator.write_next_questions_of_group(group, seed, turns, show_action_rules=show_action_rules)
        for group, turns in groups_and_turns
    ]


def _format_question_text(
    item: QuestionWithRightAndWrongTexts,
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


def _format_state_facts_for_question_prompt(
    setting: QuestionSetting, item: QuestionWithRightAndWrongTexts, operators: Collection[str]
) -> str:
    """Return the lines in which a prompt lists facts, one line for each predicate.

    The lines have all facts that actions can change, and the other facts to which the shown rules of actions
    or the goals refer. ``p(a, {b, c})`` stands for ``p(a, b)`` and ``p(a, c)``.
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


def _draw_balanced_right_answer_positions(seed: str) -> list[int]:
    """Return the right answers of consecutive questions, as random numbers from 0 to 3.

    A number stands for the letter of the right choice; in yes-no questions, an even number stands for yes. In
    each block of four numbers, every letter occurs once, and yes and no occur twice. After the last number,
    the first follows again.
    """
    rng = random.Random(seed)  # noqa: S311 - chance, not secrets
    return [turn for _ in range(_ANSWER_BLOCKS) for turn in rng.sample(range(len(LETTERS)), len(LETTERS))]


def _make_random_generator(*parts: object) -> random.Random:
    return random.Random(_make_seed(*parts))  # noqa: S311 - chance, not secrets


def _make_seed(*parts: object) -> str:
    return "questions " + " ".join(map(str, parts))
