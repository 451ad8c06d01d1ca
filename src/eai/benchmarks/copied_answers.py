"""Copies as baselines: the answers of the built-in models `eai/copy`, `eai/empty` and `eai/lookup`.

A measure that pays the first two pays for nothing. Copies are made of what the question says (its goals, its
instruction, the names of its operators), never of a right answer. A lookup table has the answer of the most
similar public task, objects renamed: whoever has seen the public answers can do as much without deciding
anything. The task itself is left out.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any, TypeAlias

import eai.logic.formula as f
from eai.abilities.notation.goal_lexicon import GoalLexicon, write_goals
from eai.abilities.notation.goals import WrittenGoal
from eai.abilities.notation.subgoals import SubgoalNotation
from eai.abilities.protocol import Ability
from eai.abilities.verdict import Unreadable
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import AnswerBook, book_of, no_answer, open_answer_book
from eai.logic.choice import Literal, choice_options, ground
from eai.logic.ltl_printer import print_ltl
from eai.logic.rewriting import rename_objects, rename_variables, substitute
from eai.logic.traversal import object_names, quantify, walk
from eai.pddl.model import Add, Both, Delete, Each, PddlEffect
from eai.pddl.writer import write_action
from eai.planning.achievers import Achiever, Achievers
from eai.planning.effect_schema import changes_for
from eai.planning.search import Effort, Limits
from eai.planning.subgoal import GroundAtom, find_object
from eai.tasks.goal_test import alternatives, solves
from eai.tasks.operator_task import TransitionTask
from eai.tasks.source import USUAL, Source, TaskSet
from eai.tasks.task import GoalKind, Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.relation import bits
from eai.world.state import Scene

_WORD = re.compile(r"[a-z]{2,}")

_LONGEST = 3
"""In how many words of an instruction a name is looked for: ``floor lamp``, ``next to``."""


_Match: TypeAlias = tuple[Achiever, Mapping[str, int]]
"""A way to make something so, and the objects that are given."""


def copied_goal(task: Task, notation: SubgoalNotation) -> f.Formula:
    """The goal of a task as one subgoal: its actions in order, on any objects, then all it says of the end.

    Quantifiers are written out, since not every notation has them; of pairs the first that there are. Goals
    over time are left out.
    """
    lexicon = notation.lexicon(task.scene)
    arities = notation.domain.arities
    actions = [
        _joined(f.Or, [_on_anything(name, arities[name]) for name in alternatives(goal)])
        for goal in task.goals_of(GoalKind.ACTION)
    ]
    lasting = [
        _without_quantifiers(goal.formula, task.scene)
        for goal in task.at_the_end.goals
        if goal.kind is not GoalKind.ACTION
    ]
    at_the_end = [_joined(f.And, lasting)] if lasting else []
    return lexicon.worded(_joined(f.Then, [*actions, *at_the_end]))


def _joined(kind: type[f.And | f.Or | f.Then], parts: Sequence[f.Formula]) -> f.Formula:
    """Some formulas as one; a single one stays as it is."""
    return parts[0] if len(parts) == 1 else kind(tuple(parts))


def _on_anything(action: str, arity: int) -> f.Formula:
    """That an action is taken, whatever it is about."""
    variables = [f.Variable(f"x{i}") for i in range(arity)]
    taken: f.Formula = f.Occurs(action, tuple(variables))
    return quantify(f.Exists, variables, taken)


def _without_quantifiers(formula: f.Formula, scene: Scene) -> f.Formula:
    """A formula that makes one with quantifiers true, written out for the objects of a scene."""

    def objects(variable: f.Variable) -> list[f.Constant]:
        return [f.Constant(scene.objects[i].name) for i in bits(scene.category(variable.category))]

    def each(variable: f.Variable, body: f.Formula, of: Iterable[f.Constant]) -> list[f.Formula]:
        name = f.Variable(variable.name)
        return [_without_quantifiers(substitute(body, {name: value}), scene) for value in of]

    match formula:
        case f.And(parts) | f.Or(parts):
            return _joined(type(formula), [_without_quantifiers(part, scene) for part in parts])
        case f.Not(operand):
            return f.Not(_without_quantifiers(operand, scene))
        case f.ForAll(variable, body):
            return _joined(f.And, each(variable, body, objects(variable)))
        case f.Exists(variable, body):
            return _joined(f.Or, each(variable, body, objects(variable)))
        case f.Exactly(count, variable, body):
            return _joined(f.And, each(variable, body, objects(variable)[:count]))
        case f.ForPairs(first, second, body, count):
            pairs = zip(objects(first), objects(second), strict=False)
            one = f.Variable(first.name)
            chosen = [each(second, substitute(body, {one: x}), [y])[0] for x, y in pairs]
            return _joined(f.And, chosen[:count])
        case _:
            return formula


def open_copy_book(benchmark: Benchmark, ability: Ability, source: Source = USUAL) -> AnswerBook:
    """The question copied.

    Goals are all that the instruction's words can state. The one subgoal is the goal, its actions before its
    states. A plan has for each part of the goal an action that makes it so, without what that needs.
    Operators need nothing, and bring about of everything what the goal says of something.

    Raises:
        DataError: the data cannot be had.
    """
    if ability not in _COPIED:
        raise no_answer("copy", benchmark, ability)
    return book_of(benchmark, ability, source, partial(_COPIED[ability], benchmark))


def open_empty_book(benchmark: Benchmark, ability: Ability, source: Source = USUAL) -> AnswerBook:
    """Answers in the form that is asked for, with nothing in them.

    Raises:
        DataError: the data cannot be had.
    """
    book = open_copy_book(benchmark, ability, source)
    return TaskSet(book, lambda task_id: replace(book[task_id], parts=()), "")


def mentions(words: Sequence[str], name: str) -> list[int]:
    """Where words name a thing, by the place of the first of them; endings do not matter."""
    meant = _stem("".join(_WORD.findall(name.lower())))
    spans = [(i, n) for i in range(len(words)) for n in range(1, _LONGEST + 1) if i + n <= len(words)]
    return [i for i, n in spans if meant and _stem("".join(words[i : i + n])) == meant]


def instruction_words(task: Task) -> list[str]:
    """The words of a task's title and instruction, in order."""
    return _WORD.findall(f"{task.title} {task.instruction}".lower())


def _stem(word: str) -> str:
    """A word without its ending: ``slice``, ``sliced`` and ``slices`` are one."""
    for ending in ("ing", "ed", "es", "s", "e"):
        if word.endswith(ending) and len(word) > len(ending) + 2:
            return word.removesuffix(ending)
    return word


def _goals(benchmark: Benchmark, task: Task) -> Iterable[str]:
    """Each named state of each named object, each relation named between two objects, each named action."""
    task = task.at_the_end
    notation, words = benchmark.notation.goals, instruction_words(task)
    lexicon = GoalLexicon(task, benchmark.domain, notation)
    objects = {name: found for name in lexicon.objects if (found := mentions(words, name))}
    goals = []
    for predicate, arity in lexicon.words:
        places = mentions(words, predicate)
        if arity == 1 and places:
            goals += [WrittenGoal(predicate, (name,)) for name in objects]
        elif arity == 2:
            goals += [
                WrittenGoal(predicate, (name, other))
                for name, before in objects.items()
                for other, after in objects.items()
                if name != other and any(before[0] < place < after[-1] for place in places)
            ]
    if notation.states_actions:
        goals += [WrittenGoal(name, is_action=True) for name in lexicon.actions if mentions(words, name)]
    return notation.write(goals)


def _subgoals(benchmark: Benchmark, task: Task) -> Iterable[str]:
    """One subgoal: the goal."""
    task = task.at_the_end
    return [print_ltl(copied_goal(task, benchmark.subgoals()))] if task.goals else []


_achievers = lru_cache(maxsize=8)(Achievers)
"""Achievers of a domain, compiled once for all its tasks."""


def _plan(benchmark: Benchmark, task: Task) -> Iterable[str]:
    """An action for each goal about states, then the action goals, about the first objects that will do."""
    task, achievers = task.at_the_end, _achievers(benchmark.domain)
    plan = [_first(_making(literal, task, achievers), task) for literal in _literals(task)]
    actions = [achievers.find_operators(alternatives(goal)) for goal in task.goals_of(GoalKind.ACTION)]
    plan += [_first([(each, {}) for each in ways], task) for ways in actions]
    steps = dict.fromkeys(action for action in plan if action is not None)
    return benchmark.notation.plans.write(tuple(steps), task.scene)


def _literals(task: Task) -> Iterator[Literal]:
    """The conditions of the first way to meet each goal about states."""
    for goal in task.goals:
        if goal.kind is not GoalKind.ACTION:
            yield from next(choice_options(ground(goal.formula, task.scene.names_of_category)), ())


def _making(literal: Literal, task: Task, achievers: Achievers) -> Iterator[_Match]:
    """The actions that make a condition true that speaks of its objects, the straight ways first."""
    atom = literal.operand if isinstance(literal, f.Not) else literal
    if not isinstance(atom, f.Atom):
        return
    objects = tuple([task.scene.index[term.name] for term in atom.arguments])
    wanted = GroundAtom(atom.predicate, objects, atom is literal)
    of_scene = partial(find_object, scene=task.scene)
    for change in changes_for(wanted, task.scene.vocabulary, of_scene):
        places = [index for index in change.arguments if index is not None]
        if len(places) == len(change.arguments):
            for achiever in achievers.find(change.predicate, adding=change.truth):
                scope = achiever.match(tuple(places), task.scene)
                if scope is not None:
                    yield achiever, scope


def _first(matches: Iterable[_Match], task: Task) -> Action | None:
    """The first action among these that can ever be taken with objects of the task; None if there is none."""
    usable = sum(1 << index for index in task.relevant)
    for achiever, scope in matches:
        for binding in achiever.bindings(task.initial, scope, usable, Effort(Limits().bindings)):
            return Action(achiever.schema.operator.name, achiever.arguments(binding))
    return None


def _operators(benchmark: Benchmark, task: TransitionTask) -> Iterable[str]:
    """Operators of no condition, that assert of everything what the goal asserts, and deny what it denies."""
    parts = list(walk(task.problem.goal))
    denied = {p.operand.predicate for p in parts if isinstance(p, f.Not) and isinstance(p.operand, f.Atom)}
    wanted = dict.fromkeys(part.predicate for part in parts if isinstance(part, f.Atom))
    declared = {each.name: each.parameters for each in task.domain.header.predicates}
    effects = [_everywhere(n, declared[n], adds=n not in denied) for n in wanted if n in declared]
    effect = Both(tuple(effects))
    return [write_action(replace(gold, precondition=f.TRUE, effect=effect)) for gold in task.gold.values()]


def _everywhere(name: str, parameters: Sequence[f.Variable], *, adds: bool) -> PddlEffect:
    """A predicate of all objects that it can be said of."""
    atom = f.Atom(name, tuple([f.Variable(each.name) for each in parameters]))
    effect: PddlEffect = Add(atom) if adds else Delete(atom)
    return quantify(Each, parameters, effect)


_COPIED: dict[Ability, Callable[[Benchmark, Any], Iterable[str]]] = {
    Ability.GOAL_INTERPRETATION: _goals,
    Ability.SUBGOAL_DECOMPOSITION: _subgoals,
    Ability.ACTION_SEQUENCING: _plan,
    Ability.TRANSITION_MODELING: _operators,
}


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
        return book_of(benchmark, ability, source, _other_operators(benchmark.operators(source)))
    if ability not in _OF_TASKS:
        raise no_answer("lookup", benchmark, ability)
    known = replace(benchmark, open_tasks=benchmark.data.open_public or benchmark.open_tasks)
    public = known.tasks_for(ability, source).values()
    if ability is Ability.GOAL_INTERPRETATION:
        texts = [(task, Counter(instruction_words(task))) for task in public]
        return book_of(benchmark, ability, source, partial(_similar_goals, benchmark, texts))
    table = LookupTable(public, benchmark.domain)
    if ability is Ability.SUBGOAL_DECOMPOSITION:
        answers = open_answer_book(known, ability, source)
        return book_of(benchmark, ability, source, partial(_looked_up, benchmark, table, answers))
    plans = benchmark.notation.plans
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
        self._of_goal = group_pairs((text, number) for number, (_, goals) in numbered for text in goals)
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


def _looked_up(benchmark: Benchmark, table: LookupTable, answers: AnswerBook, task: Task) -> Sequence[str]:
    """The subgoals of the nearest other task, about this one's objects; what is about others is left out."""
    nearest = table.nearest(task)
    if nearest is None:
        return ()
    notation = benchmark.subgoals()
    parts, here = answers[nearest.id].parts, notation.lexicon(task.scene)
    there = notation.lexicon(nearest.scene).objects
    named = [there[word] for part in parts for word in _NAME.findall(part) if word in there]
    meant = _correspondence(nearest, task, named)
    names = {word: here.name(meant[index]) for word, index in there.items() if index in meant}
    kept = [part for part in parts if all(w in names for w in _NAME.findall(part) if w in there)]
    return [_NAME.sub(lambda match: names.get(match[0], match[0]), part) for part in kept]


def _similar_goals(
    benchmark: Benchmark, texts: Iterable[tuple[Task, Counter[str]]], task: Task
) -> Sequence[str]:
    """The goals of the task whose instruction shares most words, but for what does not exist here."""
    notation = benchmark.notation.goals
    nearest = _most_similar(Counter(instruction_words(task)), task, texts)
    parts = () if nearest is None else write_goals(nearest, benchmark.domain, notation)
    read = notation.read(notation.join(parts))
    stated = () if isinstance(read, Unreadable) else read.goals
    lexicon = GoalLexicon(task, benchmark.domain, notation)
    return notation.write([goal for goal in stated if lexicon.find_unknown_name(goal) is None])


def _other_operators(tasks: TaskSet[TransitionTask]) -> Callable[[TransitionTask], Sequence[str]]:
    """Writes those of a task's operators that some other task asks for, as it has them."""
    asked = Counter([name for task in tasks.values() for name in task.operators])
    return lambda task: [task.domain.operators[name].pddl for name in task.operators if asked[name] > 1]


def _lifted(task: Task) -> Counter[str]:
    """The goals of a task with objects by category."""
    return Counter([text for _, text in _goal_texts(task)])


def _goal_texts(task: Task) -> Iterator[tuple[f.Formula, str]]:
    """The goals of a task, each also as a text in which objects go by their category."""
    category = {thing.name: thing.category for thing in task.scene.objects}
    for goal in task.goals:
        named = {name: category[name] for name in object_names(goal.formula)}
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
    goals = list(_goal_texts(asked))
    for formula, text in _goal_texts(known):
        same = next((i for i, (_, other) in enumerate(goals) if other == text), None)
        if same is not None:
            there = object_names(goals.pop(same)[0])
            pairs = zip(object_names(formula), there, strict=False)
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
