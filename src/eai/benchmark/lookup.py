"""A lookup table as a baseline: the answer of the most similar public task, objects renamed.

Whoever has seen the public answers can do as much without deciding anything. The task itself is left out.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import eai.logic.formula as f
from eai.abilities.goal_test import solves
from eai.abilities.notation.goal_lexicon import GoalLexicon, write_goals
from eai.abilities.operator_task import TransitionTask
from eai.abilities.protocol import Ability
from eai.abilities.task import Task
from eai.abilities.verdict import Unreadable
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.copied_answers import instruction_words
from eai.benchmark.gold_answers import AnswerBook, book_of, no_answer, open_answer_book
from eai.data.grouping import grouped
from eai.logic.ltl_printer import print_ltl
from eai.logic.rewriting import rename_objects, rename_variables
from eai.logic.traversal import objects
from eai.tasks.source import USUAL, Source, TaskSet
from eai.world.domain import Domain
from eai.world.execution import Action

_NAME = re.compile(r"[\w.]+")

_OF_TASKS = (Ability.GOAL_INTERPRETATION, Ability.SUBGOAL_DECOMPOSITION, Ability.ACTION_SEQUENCING)
"""The abilities whose answers are those of similar tasks; episodes of acting take plans."""


def open_lookup_book(benchmark: Benchmark, ability: Ability, source: Source = USUAL) -> AnswerBook:
    """Return the answer of the lookup table.

    Plans and subgoals are those of the task with the most similar goals, goals those of the task whose
    instruction shares most words, operators those of any other task that asks for them.

    Raises:
        DataError: the data cannot be had.
    """
    if ability is Ability.TRANSITION_MODELING:
        return book_of(benchmark, ability, source, _operators(benchmark.operators(source)))
    if ability not in _OF_TASKS:
        raise no_answer("lookup", benchmark, ability)
    known = replace(benchmark, open_tasks=benchmark.open_public or benchmark.open_tasks)
    public = known.tasks_for(ability, source).values()
    if ability is Ability.GOAL_INTERPRETATION:
        texts = [(task, Counter(instruction_words(task))) for task in public]
        return book_of(benchmark, ability, source, partial(_goal_parts, benchmark, texts))
    table = LookupTable(public, benchmark.domain)
    if ability is Ability.SUBGOAL_DECOMPOSITION:
        answers = open_answer_book(known, ability, source)
        return book_of(benchmark, ability, source, partial(_subgoals, benchmark, table, answers))
    plans = benchmark.plans
    return book_of(benchmark, ability, source, lambda task: plans.write(table.plan(task), task.scene))


class LookupTable:
    """The tasks whose plans are known.

    Args:
        public: the tasks; those without a plan are passed over.
        domain: the declaration.
    """

    def __init__(self, public: Iterable[Task], domain: Domain) -> None:
        self._entries = [(task, _lifted(task)) for task in public if task.script]
        numbered = enumerate(self._entries)
        self._of_goal = grouped((text, number) for number, (_, goals) in numbered for text in goals)
        self._domain = domain

    def plan(self, task: Task) -> tuple[Action, ...]:
        """The plan of the nearest other task, about this one's objects; steps of no operator are left out."""
        nearest = self.nearest(task)
        plan = () if nearest is None else tuple(_renamed(nearest, task))
        arities = self._domain.arities
        return tuple([each for each in plan if arities.get(each.operator) == len(each.arguments)])

    def solves(self, task: Task) -> bool:
        """Whether the plan of the nearest other task solves a task."""
        return solves(self._domain, task, self.plan(task))

    def nearest(self, task: Task) -> Task | None:
        """The other task that shares most goals, of those of either; the first of several."""
        goals = _lifted(task)
        sharing = sorted({number for text in goals for number in self._of_goal.get(text, ())})
        alike = _most_similar(goals, task, map(self._entries.__getitem__, sharing))
        return alike or next((other for other, _ in self._entries if other.id != task.id), None)


def _subgoals(benchmark: Benchmark, table: LookupTable, answers: AnswerBook, task: Task) -> Sequence[str]:
    """The subgoals of the nearest other task, about this one's objects; what is about others is left out."""
    nearest = table.nearest(task)
    if nearest is None:
        return ()
    notation = benchmark.subgoal_notation
    parts, here = answers[nearest.id].parts, notation.lexicon(task.scene)
    there = notation.lexicon(nearest.scene).objects
    named = [there[word] for part in parts for word in _NAME.findall(part) if word in there]
    meant = _correspondence(nearest, task, named)
    names = {word: here.name(meant[index]) for word, index in there.items() if index in meant}
    kept = [part for part in parts if all(w in names for w in _NAME.findall(part) if w in there)]
    return [_NAME.sub(lambda match: names.get(match[0], match[0]), part) for part in kept]


def _goal_parts(
    benchmark: Benchmark, texts: Iterable[tuple[Task, Counter[str]]], task: Task
) -> Sequence[str]:
    """The goals of the task whose instruction shares most words, but for what does not exist here."""
    notation = benchmark.goals
    nearest = _most_similar(Counter(instruction_words(task)), task, texts)
    parts = () if nearest is None else write_goals(nearest, benchmark.domain, notation)
    read = notation.read(notation.join(parts))
    stated = () if isinstance(read, Unreadable) else read.goals
    lexicon = GoalLexicon(task, benchmark.domain, notation)
    return notation.write([goal for goal in stated if lexicon.first_unknown(goal) is None])


def _operators(tasks: TaskSet[TransitionTask]) -> Callable[[TransitionTask], Sequence[str]]:
    """Writes those of a task's operators that some other task asks for, as it has them."""
    asked = Counter([name for task in tasks.values() for name in task.operators])
    return lambda task: [task.domain.operators[name].pddl for name in task.operators if asked[name] > 1]


def _lifted(task: Task) -> Counter[str]:
    """The goals of a task with objects by category."""
    return Counter([text for _, text in _goals(task)])


def _goals(task: Task) -> Iterator[tuple[f.Formula, str]]:
    """The goals of a task, each also as a text in which objects go by their category."""
    category = {thing.name: thing.category for thing in task.scene.objects}
    for goal in task.goals:
        named = {name: category[name] for name in objects(goal.formula)}
        yield goal.formula, print_ltl(rename_variables(rename_objects(goal.formula, named)))


def _most_similar(
    texts: Counter[str], asked: Task, among: Iterable[tuple[Task, Counter[str]]]
) -> Task | None:
    """Another task than the asked one, of tasks with their texts: that with most common texts among all."""
    others = [(task, known) for task, known in among if task.id != asked.id]
    nearest = max(others, key=lambda entry: _similarity(texts, entry[1]), default=None)
    return None if nearest is None else nearest[0]


def _similarity(texts: Counter[str], others: Counter[str]) -> int:
    """How near texts are to each other: the share of common ones among all, in millionths."""
    return 1_000_000 * (texts & others).total() // max(1, (texts | others).total())


def _renamed(known: Task, asked: Task) -> Iterator[Action]:
    """The plan of a known task about the objects of another, without steps about what the other lacks."""
    meant = _correspondence(known, asked, [index for action in known.script for index in action.arguments])
    for action in known.script:
        arguments = [meant.get(index) for index in action.arguments]
        found = tuple([index for index in arguments if index is not None])
        if len(found) == len(arguments):
            yield Action(action.operator, found)


def _correspondence(known: Task, asked: Task, named: Iterable[int]) -> Mapping[int, int]:
    """For each named object of a known task one of another task: of the same goal, or category and name."""
    meant: dict[int, int] = {}
    goals = list(_goals(asked))
    for formula, text in _goals(known):
        same = next((i for i, (_, other) in enumerate(goals) if other == text), None)
        if same is not None:
            there = objects(goals.pop(same)[0])
            pairs = zip(objects(formula), there, strict=False)
            meant |= {known.scene.index[a]: asked.scene.index[b] for a, b in pairs}
    relevant = dict.fromkeys((*asked.relevant, *range(len(asked.scene.objects))))
    for index in dict.fromkeys(named):
        thing = known.scene.objects[index]
        if index not in meant:
            alike = [i for i in relevant if asked.scene.objects[i].category == thing.category]
            free = [i for i in alike if i not in meant.values()] or alike
            same_name = [i for i in free if asked.scene.objects[i].name == thing.name]
            if free:
                meant[index] = (same_name or free)[0]
    return meant
