"""A small forward search with given operators. Few problems are left to an outside planner.

Greedy best-first search with deferred evaluation, guided by the length of a relaxed plan (Hoffmann and
Nebel 2001). The first actions of the relaxed plan are preferred, and even more so after progress (Helmert
2006, Richter and Helmert 2009). After progress, the relaxed plan is also carried out, and the state that it
leads to is visited next (`find_lookahead_actions_and_states`). Parts of operators that cannot matter are
left out (`restrict_to_relevant`).

The search first tries actions on the objects of the goal, then all actions. If it takes long, it tests
whether the goal's literals can hold together (`_ReachableLiteralPairs`). Effort is bounded by a number of
evaluated states, not by a clock, so equal input gives an equal answer on every machine. With the gold
operators the default limits leave no problem without a result.

The planner on a declared domain (`eai.planning.planner`) shares nodes, loop, limits and result with this
search. It does not replace this search: on models' operators that planner loses 17 correct proofs and takes
1.6 to 3.1 times as long.

Relevance is judged by predicates. An operator is never possible if it needs a predicate of which no atom is
ever true. An effect is useless if neither the goal nor a useful operator depends on its predicate. Without
such operators and effects there are far fewer ground actions, and many unreachable goals are detected before
grounding.
Quantifiers whose variable is not used in their body are dropped: eight of them would repeat an effect
millions of times.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import reduce
from math import inf
from operator import or_
from typing import NamedTuple, TypeAlias

import eai.logic.formula as f
import eai.pddl.model as m
from eai.logic.traversal import find_free_variables, find_predicates, map_subformulas
from eai.pddl.execute import DerivedPredicates, PlanStep
from eai.pddl.grounding import Grounder, GroundProblem, LiteralMask, StateMask, iterate_one_bit_masks
from eai.pddl.planning import PddlPlanner, PlannerOutcome, PlannerResult, PlanningTask, execute_found_plan
from eai.pddl.relaxation import Relaxation, find_lookahead_actions_and_states
from eai.planning.search import (
    Limits,
    OpenList,
    SearchEffort,
    SearchEndReason,
    SearchNode,
    SearchResult,
    run_best_first_search,
)

_Operator = tuple[m.PddlAction, Sequence[tuple[m.Add | m.Delete, tuple[f.Formula, ...]]]]
"""An operator with its additions and deletions, each with all conditions under which it takes place."""


def restrict_to_relevant(domain: m.PddlDomain, problem: m.PddlProblem) -> m.PddlDomain:
    """Return the domain with only the operators and effects that may matter for the problem.

    If several operators have equal parameters, precondition and effect, only the first is kept.
    """
    operators = [
        (operator, list(m.split_effect(operator.effect, (operator.precondition,))))
        for operator in domain.actions
    ]
    reached = _find_reachable_predicates(operators, domain, problem)
    possible = [operator for operator in operators if _may_condition_hold(operator[0].precondition, reached)]
    useful = reached & _find_relevant_predicates(possible, domain, problem)
    distinct: dict[tuple[object, ...], m.PddlAction] = {}
    for action, _ in possible:
        effect = _restrict_effect(action.effect, useful)
        if effect != m.NO_EFFECT:
            key = (action.parameters, action.precondition, effect)
            distinct.setdefault(key, replace(action, effect=effect))
    return replace(domain, actions=tuple(distinct.values()))


def _find_reachable_predicates(
    operators: Sequence[_Operator], domain: m.PddlDomain, problem: m.PddlProblem
) -> Set[str]:
    """Return all predicates with an atom that is or may become true, and all derived predicates."""
    reached = {axiom.name for axiom in domain.axioms} | {atom.predicate for atom in problem.initial}
    additions = [
        (part.atom.predicate, conditions)
        for _, parts in operators
        for part, conditions in parts
        if isinstance(part, m.Add)
    ]
    while True:
        new = {
            name
            for name, conditions in additions
            if name not in reached
            and all(_may_condition_hold(condition, reached) for condition in conditions)
        }
        if not new:
            return reached
        reached |= new


def _may_condition_hold(condition: f.Formula, reachable_predicates: Set[str]) -> bool:
    """Whether a condition may hold if only atoms of the reachable predicates can be true.

    Only atoms, conjunctions and existential quantifiers are tested. All other conditions count as possible.
    """
    match condition:
        case f.Atom(predicate):
            return predicate in reachable_predicates
        case f.And(operands):
            return all(_may_condition_hold(operand, reachable_predicates) for operand in operands)
        case f.Exists(_, body):
            return _may_condition_hold(body, reachable_predicates)
        case _:
            return True


def _find_relevant_predicates(
    operators: Sequence[_Operator], domain: m.PddlDomain, problem: m.PddlProblem
) -> Set[str]:
    """Return the predicates that the goal depends on, directly or through effects and axioms."""
    waiting = [(part.atom.predicate, conditions) for _, parts in operators for part, conditions in parts]
    waiting += [(axiom.name, (axiom.condition,)) for axiom in domain.axioms]
    relevant_ones, new = set[str](), {*find_predicates(problem.goal)}
    while new - relevant_ones:
        relevant_ones |= new
        matter = [conditions for name, conditions in waiting if name in relevant_ones]
        waiting = [(name, conditions) for name, conditions in waiting if name not in relevant_ones]
        new = {name for conditions in matter for name in find_predicates(*conditions)}
    return relevant_ones


def _restrict_effect(effect: m.PddlEffect, predicates: Set[str]) -> m.PddlEffect:
    """Return the part of an effect that changes given predicates; `NO_EFFECT` if it changes none of them."""
    if isinstance(effect, (m.Add, m.Delete)):
        return effect if effect.atom.predicate in predicates else m.NO_EFFECT
    match m.map_effect_parts(
        effect, lambda part: _restrict_effect(part, predicates), lambda condition: condition
    ):
        case m.AndEffect(parts):
            return m.AndEffect(tuple([part for part in parts if part != m.NO_EFFECT]))
        case m.ForAllEffect(part=m.NO_EFFECT) | m.WhenEffect(part=m.NO_EFFECT):
            return m.NO_EFFECT
        case kept:
            return kept


def drop_unused_quantifiers(task: PlanningTask) -> PlanningTask:
    """Return the task without quantifiers whose variable does not occur in the body.

    Quantifiers over types without objects are kept.
    """
    objects = m.group_objects_by_type(task.domain, task.problem)
    actions = [
        replace(
            action,
            precondition=_drop_needless_quantifiers(action.precondition, objects),
            effect=_drop_quantifiers_in_effect(action.effect, objects),
        )
        for action in task.domain.actions
    ]
    problem = replace(task.problem, goal=_drop_needless_quantifiers(task.problem.goal, objects))
    return replace(task, domain=replace(task.domain, actions=tuple(actions)), problem=problem)


def _drop_needless_quantifiers(formula: f.Formula, objects: Mapping[str, Sequence[str]]) -> f.Formula:
    mapped = map_subformulas(formula, lambda part: _drop_needless_quantifiers(part, objects))
    if isinstance(mapped, (f.ForAll, f.Exists)) and objects[m.get_variable_type(mapped.variable)]:
        return mapped if mapped.variable.name in find_free_variables(mapped.body) else mapped.body
    return mapped


def _drop_quantifiers_in_effect(effect: m.PddlEffect, objects: Mapping[str, Sequence[str]]) -> m.PddlEffect:
    mapped = m.map_effect_parts(
        effect,
        lambda part: _drop_quantifiers_in_effect(part, objects),
        lambda condition: _drop_needless_quantifiers(condition, objects),
    )
    if isinstance(mapped, m.ForAllEffect) and objects[m.get_variable_type(mapped.variable)]:
        return mapped if mapped.variable.name in m.find_effect_variables(mapped.part) else mapped.part
    return mapped


_NAME = "built-in search"

_STATES_BEFORE_PAIRS = 60
"""Number of evaluated states after which the search tests whether the goal's literals can hold together."""

_BOOSTED_STATES = 1000
"""Number of states taken from the list of preferred states after the search came nearer to the goal."""

_MAX_CENTRAL_STATES = 60
"""Maximum number of evaluated states in the first search, which only has actions on the goal's objects."""

_MAX_GROUNDING_LOOKS = 50_000
"""Maximum number of objects visited to ground operators and goal. Answers of nine LLMs needed fewer."""


@dataclass(frozen=True, slots=True)
class BuiltInPlanner:
    """The search of this package as a planner.

    Attributes:
        limits: the limits of the search.
        then: the next planner, for tasks that the search neither solves nor proves unsolvable. If None, the
            outcome is `PlannerOutcome.TIME` if a limit is exceeded, and `PlannerOutcome.UNSUPPORTED` if the
            task cannot be grounded.
    """

    limits: Limits = field(default_factory=Limits)
    then: PddlPlanner | None = None

    @property
    def name(self) -> str:
        """The planner's name in stored verdicts. It includes the name of the next planner, if any."""
        return _NAME if self.then is None else f"{_NAME}, then {self.then.name}"

    def solve(self, task: PlanningTask) -> PlannerResult:
        """Search for a plan."""
        result = self._search_plan(task)
        decided = result.outcome in {PlannerOutcome.SOLVED, PlannerOutcome.UNSOLVABLE}
        return result if decided or self.then is None else self.then.solve(task)

    def _search_plan(self, task: PlanningTask) -> PlannerResult:
        if task.fatal is not None:
            return PlannerResult(PlannerOutcome.UNSUPPORTED, detail="an effect adds an unbound variable")
        if DerivedPredicates(task.domain.axioms).cycles:
            detail = "a derived predicate depends on itself"
            return PlannerResult(PlannerOutcome.UNSUPPORTED, detail=detail)
        task = drop_unused_quantifiers(task)
        result = search(task.domain, task.problem, self.limits)
        match result.end:
            case SearchEndReason.SOLVED:
                return execute_found_plan(task, result.plan, _NAME)
            case SearchEndReason.UNREACHABLE:
                return PlannerResult(PlannerOutcome.UNSOLVABLE, detail=_NAME)
            case SearchEndReason.STATES:
                looked = f"{result.states} states evaluated" if result.states else "too large a search"
                return PlannerResult(PlannerOutcome.TIME, detail=looked)


def search(domain: m.PddlDomain, problem: m.PddlProblem, limits: Limits) -> SearchResult[PlanStep]:
    """Search for a plan.

    `SearchEndReason.UNREACHABLE` is a proof: the goal is unreachable even in relaxed planning, or two of its
    literals never hold together, or the whole state space was searched. There is no result for a
    problem that is too large to be grounded, or if a derived predicate depends on itself.
    """
    if DerivedPredicates(domain.axioms).cycles:
        return SearchResult(SearchEndReason.STATES)
    looks = SearchEffort(_MAX_GROUNDING_LOOKS)
    grounder = Grounder(restrict_to_relevant(domain, problem), problem, looks)
    goal = grounder.goal()
    if goal is None and not looks.is_limit_exceeded:
        return SearchResult(SearchEndReason.UNREACHABLE)
    objects = grounder.find_objects_of_goal_and_parameter_types()
    central, all_are_central = list(grounder.generate_actions(objects)), objects >= grounder.problem_objects
    if goal is None or looks.is_limit_exceeded:
        return SearchResult(SearchEndReason.STATES)
    work = SearchEffort(limits.looks)
    states = limits.states if all_are_central else min(_MAX_CENTRAL_STATES, limits.states)
    result = _GroundSearch(GroundProblem(grounder, central, goal, work), work, states).run()
    if result.end is SearchEndReason.SOLVED or all_are_central:
        return result
    everything = list(grounder.generate_actions())
    if looks.is_limit_exceeded:
        return SearchResult(SearchEndReason.STATES, states=result.states)
    return _GroundSearch(GroundProblem(grounder, everything, goal, work), work, limits.states).run()


_GroundSearchNode: TypeAlias = SearchNode[int, PlanStep]


class _AlternatingQueues:
    """Two open lists, used in turn: all states to be evaluated, and the preferred states among them.

    A state is preferred if an action of the relaxed plan leads to it. States are ordered by the estimate of
    their predecessor. If estimates are equal, the last state to arrive comes first.
    """

    def __init__(self) -> None:
        self._everything: OpenList[_GroundSearchNode] = OpenList()
        self._preferred: OpenList[_GroundSearchNode] = OpenList()
        self._lead = 0
        self._arrivals = 0

    def push_node(self, estimate: int, node: _GroundSearchNode, *, preferred: bool) -> None:
        self._arrivals += 1
        self._everything.push(node, estimate, -self._arrivals)
        if preferred:
            self._preferred.push(node, estimate, -self._arrivals)

    def pop(self) -> _GroundSearchNode | None:
        """Return the next state from the list of all states or the list of preferred states.

        A preferred state is in both lists, so it is returned twice.
        """
        if self._preferred and self._lead < 0:
            self._lead += 1
            return self._preferred.pop()
        self._lead -= 1
        return self._everything.pop()

    def prioritize_preferred_states(self) -> None:
        """Let `_BOOSTED_STATES` more states come from the list of preferred states before other states."""
        self._lead -= _BOOSTED_STATES


class _GroundSearch:
    """One best-first search with a fixed set of ground actions."""

    def __init__(self, problem: GroundProblem, looks: SearchEffort, states: int) -> None:
        self._problem = problem
        self._relaxation = Relaxation(problem, looks)
        self._looks = looks
        self._states = states
        self._open = _AlternatingQueues()
        self._ahead: _GroundSearchNode | None = SearchNode(problem.initial)
        self._seen, self._done = {problem.initial}, set[int]()
        self._least = inf

    def run(self) -> SearchResult[PlanStep]:
        outcome = run_best_first_search(self._pop_next_node, self._visit_node)
        if isinstance(outcome, SearchNode):
            return SearchResult(SearchEndReason.SOLVED, outcome.list_actions(), len(self._done))
        end = SearchEndReason.STATES if self._looks.is_limit_exceeded else outcome
        return SearchResult(end, states=len(self._done))

    def _pop_next_node(self) -> _GroundSearchNode | None:
        """Return the state that the last lookahead reached, unless it was visited, or else an open state."""
        node = self._ahead or self._open.pop()
        self._ahead = None
        while node is not None and node.state in self._done:
            node = self._open.pop()
        return node

    def _visit_node(self, node: _GroundSearchNode) -> _GroundSearchNode | SearchEndReason | None:
        """Test whether a state is the goal, evaluate it and queue its successors."""
        literals = self._problem.find_state_literals(node.state)
        if not self._problem.goal & ~literals:
            return node
        if len(self._done) == self._states or self._looks.is_limit_exceeded:
            return SearchEndReason.STATES
        if len(self._done) == _STATES_BEFORE_PAIRS and not _ReachableLiteralPairs(
            self._problem, self._looks
        ).may_hold_together(self._problem.goal):
            return SearchEndReason.UNREACHABLE
        self._done.add(node.state)
        estimate = self._relaxation.find_relaxed_plan(node.state, literals)
        if estimate is None:
            return None
        if estimate.length < self._least:
            self._least = estimate.length
            self._open.prioritize_preferred_states()
            self._ahead = self._follow_relaxed_plan_to_end(node, literals)
        for action, state in self._problem.generate_successors(node.state, literals):
            if state not in self._seen:
                self._seen.add(state)
                child = self._make_child_node(node, action.bit_length() - 1, state)
                self._open.push_node(estimate.length, child, preferred=bool(action & estimate.helpful))
        if self._ahead is not None:
            self._seen.add(self._ahead.state)
        return None

    def _make_child_node(self, node: _GroundSearchNode, action: int, state: StateMask) -> _GroundSearchNode:
        return SearchNode(state, 0, node.depth + 1, node, (self._problem.actions[action].step,))

    def _follow_relaxed_plan_to_end(
        self, node: _GroundSearchNode, true_literals: LiteralMask
    ) -> _GroundSearchNode:
        """Return the node that the search reaches by carrying out the relaxed plan from a node."""
        for action, state in find_lookahead_actions_and_states(
            self._problem, self._relaxation, node.state, true_literals
        ):
            node = self._make_child_node(node, action, state)
        return node


class _ConditionalEffect(NamedTuple):
    """A conditional effect as bit masks of literals: needed, made true, and lost (made false).

    `always` and `perhaps` are literals that other effects of the action always make true, or may make true.
    """

    needs: int
    makes: int
    always: int
    perhaps: int
    lost: int


class _ReachableLiteralPairs:
    """Pairs of literals that may hold together in a reachable state.

    For example, one hand never holds two objects together, but a relaxed plan ignores this. Two literals may
    hold together at the start, or after an action that makes one of them and makes or keeps the other (h2;
    Haslum and Geffner 2000). Disjunctions in conditions are ignored, and conditional effects may happen
    together. So too many pairs are found, never too few: a goal with an unreachable pair has no plan.

    Args:
        problem: the ground problem.
        looks: the budget of literals that may be tested. If the budget is exceeded, results are invalid.
    """

    def __init__(self, problem: GroundProblem, looks: SearchEffort) -> None:
        self._atoms = problem.atoms
        self._every_atom = (1 << self._atoms) - 1
        self._looks = looks
        self._reached = problem.initial | (~problem.initial & self._every_atom) << self._atoms
        self._beside = dict.fromkeys(iterate_one_bit_masks(self._reached), self._reached)
        rules = [
            rule
            for action in problem.actions
            for rule in self._make_conditional_effects(action.needs, action.changes)
        ]
        while self._add_literal_pairs_reached_by_all_effects(rules):
            pass

    def may_hold_together(self, needed: LiteralMask) -> bool:
        """Whether every two literals of a mask may hold together in a reachable state."""
        return (
            self._looks.is_limit_exceeded
            or self._find_literals_compatible_with_all(self._clear_bits_of_disjunctions(needed)) is not None
        )

    def _make_conditional_effects(
        self,
        precondition: LiteralMask,
        needs_adds_deletes: Iterable[tuple[LiteralMask, StateMask, StateMask]],
    ) -> Iterator[_ConditionalEffect]:
        """Yield the conditional effects of an action. The precondition becomes a part of their conditions."""
        made = [(also, add | (delete & ~add) << self._atoms) for also, add, delete in needs_adds_deletes]
        always = reduce(or_, [makes for also, makes in made if not also], 0)
        perhaps = reduce(or_, [makes for also, makes in made if also], 0)
        for also, makes in made:
            yield _ConditionalEffect(
                self._clear_bits_of_disjunctions(precondition | also),
                makes,
                always,
                perhaps,
                self._negate_literals(makes | always),
            )

    def _add_literal_pairs_reached_by_all_effects(self, effects: Sequence[_ConditionalEffect]) -> bool:
        """Add the pairs of literals that effects can make true together. Return whether any is new."""
        grew = False
        for rule in effects:
            if self._looks.is_limit_exceeded:
                return False
            grew |= self._add_literal_pairs_reached_by_effect(rule)
        return grew

    def _add_literal_pairs_reached_by_effect(self, effect: _ConditionalEffect) -> bool:
        """Add the pairs of literals that an effect can make true together. Return whether any is new."""
        companions = self._find_literals_compatible_with_all(effect.needs)
        if companions is None:
            return False
        together = companions & ~effect.lost | effect.makes | effect.always | effect.perhaps & self._reached
        grew = False
        for literal in iterate_one_bit_masks(effect.makes):
            new = together & ~self._beside.get(literal, 0) & ~self._negate_literals(literal)
            if new:
                grew = True
                self._beside[literal] = self._beside.get(literal, 0) | new
                for other in iterate_one_bit_masks(new):
                    self._beside[other] = self._beside.get(other, 0) | literal
                self._reached |= new
                self._looks.used += new.bit_count()
        return grew

    def _find_literals_compatible_with_all(self, needed_literals: LiteralMask) -> LiteralMask | None:
        """Return the literals that may hold together with all needed literals, as a mask.

        The result is None if the needed literals cannot hold together.
        """
        self._looks.used += 1 + needed_literals.bit_count()
        companions = self._reached
        for literal in iterate_one_bit_masks(needed_literals):
            companions &= self._beside.get(literal, 0)
        return None if needed_literals & ~companions else companions

    def _clear_bits_of_disjunctions(self, mask: LiteralMask) -> LiteralMask:
        """Return a mask with only the bits of true and false atoms, without the bits of disjunctions."""
        return mask & (1 << 2 * self._atoms) - 1

    def _negate_literals(self, literals: LiteralMask) -> LiteralMask:
        return literals >> self._atoms | (literals & self._every_atom) << self._atoms
