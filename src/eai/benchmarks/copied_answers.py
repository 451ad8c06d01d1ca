"""The models `eai/copy`, `eai/empty` and `eai/lookup`: baselines that copy the question or published answers.

A sound metric gives no points to `eai/copy` and `eai/empty`. The model `eai/copy` uses only the question (its
goals, its instruction, the names of its operators), never a right answer. The model `eai/lookup` takes the
published answer to the most similar other task, and renames the objects. Anybody who has the published
answers can do this without understanding a task.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from itertools import product
from typing import Any, TypeAlias

import eai.logic.formula as f
from eai.abilities.notation.goal_lexicon import GoalLexicon, write_goals
from eai.abilities.notation.goals import WrittenGoal
from eai.abilities.notation.subgoals import SubgoalNotation
from eai.abilities.protocol import Ability
from eai.abilities.verdict import Unreadable
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import (
    AnswersByTask,
    make_answers_by_task,
    make_no_answer_error,
    open_gold_answers,
)
from eai.benchmarks.random_answers import list_predicates_with_arguments
from eai.logic.choice import Literal, build_and_or_tree, generate_dnf_terms_of_tree
from eai.logic.ltl_printer import format_ltl
from eai.logic.rewriting import rename_objects, standardize_variable_names, substitute_terms
from eai.logic.traversal import find_object_names, walk_subformulas, wrap_in_quantifiers
from eai.pddl.declaration import split_conjuncts
from eai.pddl.model import Add, AndEffect, Delete
from eai.pddl.writer import write_action
from eai.planning.achievers import Achiever, AchieversByPredicate
from eai.planning.effect_schema import find_changes_for_literal
from eai.planning.search import Limits, SearchEffort
from eai.planning.subgoal import GroundAtom, find_object
from eai.tasks.goal_test import list_actions_that_meet_goal, solves_task
from eai.tasks.operator_task import TransitionTask
from eai.tasks.source import USUAL_SOURCE, Source, TaskSet
from eai.tasks.task import GoalKind, Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.relation import iterate_bits, make_mask
from eai.world.state import Scene

_WORD = re.compile(r"[a-z]{2,}")

_MAX_NAME_WORDS = 3
"""Maximum number of words of an instruction that form one name, as in ``floor lamp`` or ``next to``."""


_AchieverMatch: TypeAlias = tuple[Achiever, Mapping[str, int]]
"""A pair: an action schema that achieves a fact, and a mapping from the schema's variables to objects."""


def write_goal_parts_as_subgoals(task: Task, notation: SubgoalNotation) -> list[f.Formula]:
    """Return each part of a task's goals as a subgoal: action goals in order, then final conditions.

    Subgoals for actions allow any objects. Quantifiers are expanded, because not every notation has them. A
    goal about a number of objects or pairs becomes a goal about the first objects or pairs in scene order.
    Goals over time are left out. Each conjunct becomes a subgoal, because few actions are executed for a
    subgoal.
    """
    lexicon = notation.make_lexicon_of_names_in_subgoals(task.scene)
    arities = notation.domain.operator_arities
    actions = [
        _join_formulas(
            f.Or,
            [
                _make_formula_action_occurs_on_any_objects(name, arities[name])
                for name in list_actions_that_meet_goal(goal)
            ],
        )
        for goal in task.get_goals_of_kind(GoalKind.ACTION)
    ]
    lasting = [
        part
        for goal in task.without_goals_over_time.goals
        if goal.kind is not GoalKind.ACTION
        for part in split_conjuncts(_expand_quantifiers(goal.formula, task.scene))
    ]
    return [
        lexicon.replace_domain_names_by_lexicon_names(part) for part in (*actions, *dict.fromkeys(lasting))
    ]


def _join_formulas(kind: type[f.And | f.Or], parts: Sequence[f.Formula]) -> f.Formula:
    return parts[0] if len(parts) == 1 else kind(tuple(parts))


def _make_formula_action_occurs_on_any_objects(action: str, arity: int) -> f.Formula:
    variables = [f.Variable(f"x{i}") for i in range(arity)]
    taken: f.Formula = f.Occurs(action, tuple(variables))
    return wrap_in_quantifiers(f.Exists, variables, taken)


def _expand_quantifiers(formula: f.Formula, scene: Scene) -> f.Formula:
    """Return a formula without quantifiers about the objects of a scene.

    Each quantifier becomes a conjunction or disjunction over objects. Numbers of objects or pairs become the
    first of them, so that the result may differ from the formula.
    """

    def list_objects_of_category(variable: f.Variable) -> list[f.Constant]:
        return [
            f.Constant(scene.objects[i].name)
            for i in iterate_bits(scene.get_category_mask(variable.category))
        ]

    def instantiate(
        variable: f.Variable, body: f.Formula, constants: Iterable[f.Constant]
    ) -> list[f.Formula]:
        name = f.Variable(variable.name)
        return [_expand_quantifiers(substitute_terms(body, {name: value}), scene) for value in constants]

    match formula:
        case f.And(parts) | f.Or(parts):
            return _join_formulas(type(formula), [_expand_quantifiers(part, scene) for part in parts])
        case f.Not(operand):
            return f.Not(_expand_quantifiers(operand, scene))
        case f.ForAll(variable, body):
            return _join_formulas(f.And, instantiate(variable, body, list_objects_of_category(variable)))
        case f.Exists(variable, body):
            return _join_formulas(f.Or, instantiate(variable, body, list_objects_of_category(variable)))
        case f.Exactly(count, variable, body):
            return _join_formulas(
                f.And, instantiate(variable, body, list_objects_of_category(variable)[:count])
            )
        case f.ForPairs(first, second, body, count):
            pairs = zip(list_objects_of_category(first), list_objects_of_category(second), strict=False)
            first_variable = f.Variable(first.name)
            chosen = [
                instantiate(second, substitute_terms(body, {first_variable: x}), [y])[0] for x, y in pairs
            ]
            return _join_formulas(f.And, chosen[:count])
        case _:
            return formula


def open_answers_copied_from_questions(
    benchmark: Benchmark, ability: Ability, source: Source = USUAL_SOURCE
) -> AnswersByTask:
    """Return answers that are copied from the question without understanding it.

    An answer to goal interpretation has all goals that words of the instruction can state. The subgoals are
    the parts of the task's goal, actions before conditions. A plan has, for each condition of the goal, an
    action that achieves this condition, but no steps that make the action possible. Operators have no
    preconditions, and their effects apply the goal's predicates to their parameters.

    Raises:
        DataError: the data cannot be obtained.
    """
    if ability not in _COPIERS:
        raise make_no_answer_error(model="copy", benchmark=benchmark, ability=ability)
    return make_answers_by_task(benchmark, ability, source, partial(_COPIERS[ability], benchmark))


def open_empty_answers(
    benchmark: Benchmark, ability: Ability, source: Source = USUAL_SOURCE
) -> AnswersByTask:
    """Return empty answers that have the required form, such as plans without steps.

    Raises:
        DataError: the data cannot be obtained.
    """
    book = open_answers_copied_from_questions(benchmark, ability, source)
    return TaskSet(book, lambda task_id: replace(book[task_id], parts=()), "")


def find_mentions(words: Sequence[str], name: str) -> list[int]:
    """Return the positions in a list of words at which the name of an object or predicate begins.

    Endings of words are ignored.
    """
    stem = _remove_word_ending("".join(_WORD.findall(name.lower())))
    spans = [(i, n) for i in range(len(words)) for n in range(1, _MAX_NAME_WORDS + 1) if i + n <= len(words)]
    return [i for i, n in spans if stem and _remove_word_ending("".join(words[i : i + n])) == stem]


def list_instruction_words(task: Task) -> list[str]:
    """Return the words of a task's title and instruction, in order."""
    return _WORD.findall(f"{task.title} {task.instruction}".lower())


def _remove_word_ending(word: str) -> str:
    """Return a word without its ending: ``slice`` for ``sliced`` and ``slices``."""
    for ending in ("ing", "ed", "es", "s", "e"):
        if word.endswith(ending) and len(word) > len(ending) + 2:
            return word.removesuffix(ending)
    return word


def _copy_goals_mentioned_in_instruction(benchmark: Benchmark, task: Task) -> Iterable[str]:
    """Return all goals that can be made from the words of an instruction.

    They are mentioned states, each for every mentioned object, and mentioned actions. A relation of two
    mentioned objects is a goal if it is mentioned between them.
    """
    task = task.without_goals_over_time
    notation, words = benchmark.notation.goals, list_instruction_words(task)
    lexicon = GoalLexicon(task, benchmark.domain, notation)
    objects = {name: positions for name in lexicon.objects if (positions := find_mentions(words, name))}
    goals = []
    for predicate, arity in lexicon.words:
        mentioned_at = find_mentions(words, predicate)
        if arity == 1 and mentioned_at:
            goals += [WrittenGoal(predicate, (name,)) for name in objects]
        elif arity == 2:
            goals += [
                WrittenGoal(predicate, (name, other))
                for name, before in objects.items()
                for other, after in objects.items()
                if name != other and any(before[0] < position < after[-1] for position in mentioned_at)
            ]
    if notation.states_actions:
        goals += [WrittenGoal(name, is_action=True) for name in lexicon.actions if find_mentions(words, name)]
    return notation.write(goals)


def _copy_goal_parts_as_subgoals(benchmark: Benchmark, task: Task) -> Iterable[str]:
    return map(format_ltl, write_goal_parts_as_subgoals(task, benchmark.subgoal_notation()))


_achievers = lru_cache(maxsize=8)(AchieversByPredicate)
"""Returns the actions of a domain by the predicates that they make true or false. Results are cached."""


def _make_plan_with_action_per_goal_condition(benchmark: Benchmark, task: Task) -> Iterable[str]:
    """Return a plan with one action for each condition in the goals, and no other actions.

    Each action makes its condition true. Actions for goals about states come before actions for action goals.
    The arguments of an action are the first objects of the task that fit.
    """
    task, achievers = task.without_goals_over_time, _achievers(benchmark.domain)
    plan = [
        _ground_first_matching_schema(_find_achieving_actions(literal, task, achievers), task)
        for literal in _list_goal_conditions(task)
    ]
    actions = [
        achievers.get_operators_as_achievers(list_actions_that_meet_goal(goal))
        for goal in task.get_goals_of_kind(GoalKind.ACTION)
    ]
    plan += [_ground_first_matching_schema([(achiever, {}) for achiever in ways], task) for ways in actions]
    steps = dict.fromkeys(action for action in plan if action is not None)
    return benchmark.notation.plans.write(tuple(steps), task.scene)


def _list_goal_conditions(task: Task) -> Iterator[Literal]:
    """Yield conditions that together satisfy the goals about states.

    If several sets of conditions satisfy a goal, the first set is used.
    """
    for goal in task.goals:
        if goal.kind is not GoalKind.ACTION:
            yield from next(
                generate_dnf_terms_of_tree(build_and_or_tree(goal.formula, task.scene.names_of_category)),
                (),
            )


def _find_achieving_actions(
    literal: Literal, task: Task, achievers: AchieversByPredicate
) -> Iterator[_AchieverMatch]:
    """Yield the action schemas that make a ground condition true.

    Actions that change the predicate of this condition directly come first.
    """
    atom = literal.operand if isinstance(literal, f.Not) else literal
    if not isinstance(atom, f.Atom):
        return
    objects = tuple([task.scene.index[term.name] for term in atom.arguments])
    wanted = GroundAtom(atom.predicate, objects, atom is literal)
    of_scene = partial(find_object, scene=task.scene)
    for change in find_changes_for_literal(wanted, task.scene.vocabulary, of_scene):
        places = [index for index in change.arguments if index is not None]
        if len(places) == len(change.arguments):
            for achiever in achievers.find_achievers(change.predicate, adding=change.truth):
                scope = achiever.match_atom_arguments(tuple(places), task.scene)
                if scope is not None:
                    yield achiever, scope


def _ground_first_matching_schema(matches: Iterable[_AchieverMatch], task: Task) -> Action | None:
    """Return the first action schema applied to the first fitting objects, or None if no objects fit.

    The action need not be possible.
    """
    usable = make_mask(task.relevant)
    for achiever, scope in matches:
        for binding in achiever.generate_complete_bindings(
            task.initial, scope, usable, SearchEffort(Limits().bindings)
        ):
            return Action(achiever.schema.operator.name, achiever.get_operator_arguments(binding))
    return None


def _copy_goal_predicates_to_operator_effects(benchmark: Benchmark, task: TransitionTask) -> Iterable[str]:
    """Yield the task's operators in PDDL, without preconditions. Their effects are copied from the goal.

    Each predicate of the goal becomes an effect, negated if the goal negates it. An operator has this effect
    for every combination of different parameters whose types fit the predicate.
    """
    subformulas = list(walk_subformulas(task.problem.goal))
    denied = {
        p.operand.predicate for p in subformulas if isinstance(p, f.Not) and isinstance(p.operand, f.Atom)
    }
    wanted = dict.fromkeys(
        subformula.predicate for subformula in subformulas if isinstance(subformula, f.Atom)
    )
    for gold in task.gold_operators.values():
        fitting = dict(list_predicates_with_arguments(task, gold))
        effects = [
            (Delete if name in denied else Add)(f.Atom(name, tuple(map(f.Variable, terms))))
            for name in wanted
            if name in fitting
            for terms in product(*fitting[name])
            if len({*terms}) == len(terms)
        ]
        yield write_action(replace(gold, precondition=f.TRUE, effect=AndEffect(tuple(effects))))


_COPIERS: dict[Ability, Callable[[Benchmark, Any], Iterable[str]]] = {
    Ability.GOAL_INTERPRETATION: _copy_goals_mentioned_in_instruction,
    Ability.SUBGOAL_DECOMPOSITION: _copy_goal_parts_as_subgoals,
    Ability.ACTION_SEQUENCING: _make_plan_with_action_per_goal_condition,
    Ability.TRANSITION_MODELING: _copy_goal_predicates_to_operator_effects,
}


_NAME = re.compile(r"[\w.]+")

_LOOKED_UP_ABILITIES = (Ability.GOAL_INTERPRETATION, Ability.SUBGOAL_DECOMPOSITION, Ability.ACTION_SEQUENCING)
"""Abilities for which the built-in model `eai/lookup` copies and adapts the answer of a similar task."""


def open_answers_of_similar_tasks(
    benchmark: Benchmark, ability: Ability, source: Source = USUAL_SOURCE
) -> AnswersByTask:
    """Return answers that the model `eai/lookup` takes from the most similar task with a published answer.

    Plans and subgoals are taken from the other task with the most similar goals. Goals are taken from the
    other task whose instruction has most words in common. An operator is taken from any other task that needs
    this operator.

    Raises:
        DataError: the data cannot be obtained.
    """
    if ability is Ability.TRANSITION_MODELING:
        return make_answers_by_task(
            benchmark,
            ability,
            source,
            _make_function_listing_shared_operators(benchmark.operator_tasks(source)),
        )
    if ability not in _LOOKED_UP_ABILITIES:
        raise make_no_answer_error(model="lookup", benchmark=benchmark, ability=ability)
    public_benchmark = replace(benchmark, open_tasks=benchmark.data.open_public or benchmark.open_tasks)
    public = public_benchmark.tasks_for(ability, source).values()
    if ability is Ability.GOAL_INTERPRETATION:
        texts = [(task, Counter(list_instruction_words(task))) for task in public]
        return make_answers_by_task(
            benchmark, ability, source, partial(_adapt_goals_of_similar_task, benchmark, texts)
        )
    table = SimilarTaskTable(public, benchmark.domain)
    if ability is Ability.SUBGOAL_DECOMPOSITION:
        answers = open_gold_answers(public_benchmark, ability, source)
        return make_answers_by_task(
            benchmark, ability, source, partial(_adapt_subgoals_of_similar_task, benchmark, table, answers)
        )
    plans = benchmark.notation.plans
    return make_answers_by_task(
        benchmark,
        ability,
        source,
        lambda task: plans.write(table.adapt_plan_of_most_similar_task(task), task.scene),
    )


class SimilarTaskTable:
    """Finds, for a task, the most similar other task with a plan, and adapts this plan to the task.

    Args:
        public: the tasks to search. Tasks without a plan are skipped.
        domain: the domain.
    """

    def __init__(self, public: Iterable[Task], domain: Domain) -> None:
        self._entries = [(task, _count_goals_by_category(task)) for task in public if task.script]
        numbered = enumerate(self._entries)
        self._of_goal = group_pairs((text, number) for number, (_, goals) in numbered for text in goals)
        self._domain = domain

    def adapt_plan_of_most_similar_task(self, task: Task) -> tuple[Action, ...]:
        """Return the plan of the most similar other task, with objects of this task.

        Actions that the domain lacks are left out.
        """
        nearest = self.find_most_similar_task(task)
        plan = () if nearest is None else tuple(_adapt_steps(nearest, task))
        arities = self._domain.operator_arities
        return tuple([action for action in plan if arities.get(action.operator) == len(action.arguments)])

    def solves_by_adapted_plan(self, task: Task) -> bool:
        """Whether the adapted plan of the most similar other task solves this task."""
        return solves_task(self._domain, task, self.adapt_plan_of_most_similar_task(task))

    def find_most_similar_task(self, task: Task) -> Task | None:
        """Return the other task with the most similar goals, or None if there is no other task.

        Similarity is the number of goals that both tasks have, divided by the number of goals that at least
        one of them has. Goals are compared after categories replace objects. On a tie, the first task is
        returned.
        """
        goals = _count_goals_by_category(task)
        sharing = sorted({number for text in goals for number in self._of_goal.get(text, ())})
        alike = _find_task_with_most_similar_texts(goals, task, map(self._entries.__getitem__, sharing))
        return alike or next((other for other, _ in self._entries if other.id != task.id), None)


def _adapt_subgoals_of_similar_task(
    benchmark: Benchmark, similar_tasks: SimilarTaskTable, answers: AnswersByTask, task: Task
) -> Sequence[str]:
    """Return the subgoals of the most similar task, with objects renamed to this task's objects.

    A subgoal is left out if one of its objects has no match in this task.
    """
    nearest = similar_tasks.find_most_similar_task(task)
    if nearest is None:
        return ()
    notation = benchmark.subgoal_notation()
    parts, here = answers[nearest.id].parts, notation.make_lexicon_of_names_in_subgoals(task.scene)
    there = notation.make_lexicon_of_names_in_subgoals(nearest.scene).objects
    mentioned = [there[word] for part in parts for word in _NAME.findall(part) if word in there]
    counterparts = _match_objects(nearest, task, mentioned)
    names = {
        word: here.get_object_name(counterparts[index])
        for word, index in there.items()
        if index in counterparts
    }
    complete_parts = [part for part in parts if all(w in names for w in _NAME.findall(part) if w in there)]
    return [_NAME.sub(lambda match: names.get(match[0], match[0]), part) for part in complete_parts]


def _adapt_goals_of_similar_task(
    benchmark: Benchmark, word_counts: Iterable[tuple[Task, Counter[str]]], task: Task
) -> Sequence[str]:
    """Return the right goals of the task whose instruction is most similar to that of the given task.

    Goals with names that do not occur in the given task are left out.
    """
    notation = benchmark.notation.goals
    nearest = _find_task_with_most_similar_texts(Counter(list_instruction_words(task)), task, word_counts)
    parts = () if nearest is None else write_goals(nearest, benchmark.domain, notation)
    read = notation.read(notation.join(parts))
    stated = () if isinstance(read, Unreadable) else read.goals
    lexicon = GoalLexicon(task, benchmark.domain, notation)
    return notation.write([goal for goal in stated if lexicon.find_unknown_name(goal) is None])


def _make_function_listing_shared_operators(
    tasks: TaskSet[TransitionTask],
) -> Callable[[TransitionTask], Sequence[str]]:
    """Return a function that lists, as PDDL, the operators of a task that another task needs, too."""
    uses = Counter([name for task in tasks.values() for name in task.operators])
    return lambda task: [task.domain.operators[name].write_pddl for name in task.operators if uses[name] > 1]


def _count_goals_by_category(task: Task) -> Counter[str]:
    """Return the goals of a task as texts in which categories replace objects, and count equal texts."""
    return Counter([text for _, text in _format_goals_with_categories_for_objects(task)])


def _format_goals_with_categories_for_objects(task: Task) -> Iterator[tuple[f.Formula, str]]:
    """Yield each goal of a task with its text, in which categories replace objects."""
    category = {obj.name: obj.category for obj in task.scene.objects}
    for goal in task.goals:
        named = {name: category[name] for name in find_object_names(goal.formula)}
        yield goal.formula, format_ltl(standardize_variable_names(rename_objects(goal.formula, named)))


def _find_task_with_most_similar_texts(
    texts: Counter[str], excluded_task: Task, tasks_and_texts: Iterable[tuple[Task, Counter[str]]]
) -> Task | None:
    """Return the other task that has the largest share of texts in common with the given texts, if any."""
    others = [(task, task_texts) for task, task_texts in tasks_and_texts if task.id != excluded_task.id]
    nearest = max(
        others, key=lambda entry: _compute_text_overlap_in_millionths(texts, entry[1]), default=None
    )
    return None if nearest is None else nearest[0]


def _compute_text_overlap_in_millionths(texts: Counter[str], others: Counter[str]) -> int:
    """Return the share of texts that two tasks have in common, in millionths."""
    return 1_000_000 * (texts & others).total() // max(1, (texts | others).total())


def _adapt_steps(source: Task, target: Task) -> Iterator[Action]:
    """Yield the steps of one task's plan, with objects replaced by matching objects of another task.

    A step is left out if one of its objects has no match.
    """
    counterparts = _match_objects(
        source, target, [index for action in source.script for index in action.arguments]
    )
    for action in source.script:
        arguments = [counterparts.get(index) for index in action.arguments]
        indices = tuple([index for index in arguments if index is not None])
        if len(indices) == len(arguments):
            yield Action(action.operator, indices)


def _match_objects(source: Task, target: Task, source_objects: Iterable[int]) -> Mapping[int, int]:
    """Return a mapping from objects of one task (`source`) to matching objects of another task, by index.

    Objects match if they occur in equal positions of equal goals, or else if they have the same category.
    """
    counterparts: dict[int, int] = {}
    goals = list(_format_goals_with_categories_for_objects(target))
    for formula, text in _format_goals_with_categories_for_objects(source):
        position = next((i for i, (_, other) in enumerate(goals) if other == text), None)
        if position is not None:
            target_names = find_object_names(goals.pop(position)[0])
            pairs = zip(find_object_names(formula), target_names, strict=False)
            counterparts |= {source.scene.index[a]: target.scene.index[b] for a, b in pairs}
    relevant = dict.fromkeys((*target.relevant, *range(len(target.scene.objects))))
    for index in dict.fromkeys(source_objects):
        obj = source.scene.objects[index]
        if index not in counterparts:
            candidates = [i for i in relevant if target.scene.objects[i].category == obj.category]
            free = [i for i in candidates if i not in counterparts.values()] or candidates
            namesakes = [i for i in free if target.scene.objects[i].name == obj.name]
            if free:
                counterparts[index] = (namesakes or free)[0]
    return counterparts
