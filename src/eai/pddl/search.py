"""A small forward search with given operators, which decides most problems without an outside planner.

Greedy best-first search with deferred evaluation, guided by the length of a relaxed plan (Hoffmann and
Nebel 2001). The first actions of the relaxed plan are preferred, and even more so after progress (Helmert
2006, Richter and Helmert 2009). After progress, the relaxed plan is also carried out, and the state that it
leads to is visited next (`look_ahead`). Parts of operators that cannot matter are left out
(`restrict_to_relevant`).

The search first tries actions on the objects of the goal, then all actions. If it takes long, it tests
whether the goal's literals can hold together (`_Pairs`). Effort is bounded by a number of evaluated states,
not by a clock, so equal input gives an equal answer on every machine. With the gold operators the default
limits leave no problem undecided.

The planner on a declared domain (`eai.planning.planner`) shares nodes, loop, limits and result with this
search. It does not replace this search: on models' operators that planner loses 17 correct proofs and takes
1.6 to 3.1 times as long.

Relevance is judged by predicates. An operator is never possible if it needs a predicate of which no atom is
ever true. An effect is useless if neither the goal nor a useful operator depends on its predicate. Without
both there are far fewer ground actions, and many unreachable goals are detected before grounding.
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
from eai.logic.traversal import free_variables, map_parts, predicates_of
from eai.pddl.execute import DerivedPredicates, PlanStep
from eai.pddl.grounding import Grounder, GroundProblem, bits
from eai.pddl.planning import PddlPlanner, PlannerOutcome, PlannerResult, PlanningTask, check_plan
from eai.pddl.relaxation import Relaxation, look_ahead
from eai.planning.search import Effort, Limits, Node, OpenList, SearchEnd, SearchResult, best_first

_Operator = tuple[m.PddlAction, Sequence[tuple[m.Add | m.Delete, tuple[f.Formula, ...]]]]
"""An operator, its additions and deletions, and the conditions of each, the precondition among them."""


def restrict_to_relevant(domain: m.PddlDomain, problem: m.PddlProblem) -> m.PddlDomain:
    """The domain with what of its operators may matter, and of several that do the same then the first."""
    operators = [(each, list(m.effect_parts(each.effect, (each.precondition,)))) for each in domain.actions]
    reached = _reachable_predicates(operators, domain, problem)
    possible = [each for each in operators if _may_hold(each[0].precondition, reached)]
    kept = reached & _relevant_predicates(possible, domain, problem)
    distinct: dict[tuple[object, ...], m.PddlAction] = {}
    for action, _ in possible:
        effect = _restrict(action.effect, kept)
        if effect != m.NO_EFFECT:
            key = (action.parameters, action.precondition, effect)
            distinct.setdefault(key, replace(action, effect=effect))
    return replace(domain, actions=tuple(distinct.values()))


def _reachable_predicates(
    operators: Sequence[_Operator], domain: m.PddlDomain, problem: m.PddlProblem
) -> Set[str]:
    """The predicates of which something is true at the start, or may become so, and the derived ones."""
    reached = {axiom.name for axiom in domain.axioms} | {atom.predicate for atom in problem.initial}
    additions = [
        (part.atom.predicate, conditions)
        for _, parts in operators
        for part, conditions in parts
        if isinstance(part, m.Add)
    ]
    while True:
        found = {
            name
            for name, conditions in additions
            if name not in reached and all(_may_hold(each, reached) for each in conditions)
        }
        if not found:
            return reached
        reached |= found


def _may_hold(condition: f.Formula, reached: Set[str]) -> bool:
    """Whether a condition may hold where only atoms of some predicates may; only conjuncts are looked at."""
    match condition:
        case f.Atom(predicate):
            return predicate in reached
        case f.And(operands):
            return all(_may_hold(operand, reached) for operand in operands)
        case f.Exists(_, body):
            return _may_hold(body, reached)
        case _:
            return True


def _relevant_predicates(
    operators: Sequence[_Operator], domain: m.PddlDomain, problem: m.PddlProblem
) -> Set[str]:
    """The predicates that the goal is about, or what makes a difference to it."""
    waiting = [(part.atom.predicate, conditions) for _, parts in operators for part, conditions in parts]
    waiting += [(axiom.name, (axiom.condition,)) for axiom in domain.axioms]
    relevant_ones, new = set[str](), {*predicates_of(problem.goal)}
    while new - relevant_ones:
        relevant_ones |= new
        matter = [conditions for name, conditions in waiting if name in relevant_ones]
        waiting = [(name, conditions) for name, conditions in waiting if name not in relevant_ones]
        new = {name for conditions in matter for name in predicates_of(*conditions)}
    return relevant_ones


def _restrict(effect: m.PddlEffect, predicates: Set[str]) -> m.PddlEffect:
    """The part of an effect on atoms of some predicates; `NO_EFFECT` if there is none."""
    if isinstance(effect, (m.Add, m.Delete)):
        return effect if effect.atom.predicate in predicates else m.NO_EFFECT
    match m.map_effect_parts(effect, lambda part: _restrict(part, predicates), lambda condition: condition):
        case m.Both(parts):
            return m.Both(tuple([part for part in parts if part != m.NO_EFFECT]))
        case m.Each(part=m.NO_EFFECT) | m.WhenEffect(part=m.NO_EFFECT):
            return m.NO_EFFECT
        case kept:
            return kept


def drop_idle_quantifiers(task: PlanningTask) -> PlanningTask:
    """The task without quantifiers over objects, of which there are some, that nothing is said of."""
    objects = m.objects_by_type(task.domain, task.problem)
    actions = [
        replace(
            each, precondition=_condition(each.precondition, objects), effect=_effect(each.effect, objects)
        )
        for each in task.domain.actions
    ]
    problem = replace(task.problem, goal=_condition(task.problem.goal, objects))
    return replace(task, domain=replace(task.domain, actions=tuple(actions)), problem=problem)


def _condition(formula: f.Formula, objects: Mapping[str, Sequence[str]]) -> f.Formula:
    kept = map_parts(formula, lambda part: _condition(part, objects))
    if isinstance(kept, (f.ForAll, f.Exists)) and objects[m.type_of(kept.variable)]:
        return kept if kept.variable.name in free_variables(kept.body) else kept.body
    return kept


def _effect(effect: m.PddlEffect, objects: Mapping[str, Sequence[str]]) -> m.PddlEffect:
    kept = m.map_effect_parts(
        effect, lambda part: _effect(part, objects), lambda condition: _condition(condition, objects)
    )
    if isinstance(kept, m.Each) and objects[m.type_of(kept.variable)]:
        return kept if kept.variable.name in m.effect_variables(kept.part) else kept.part
    return kept


_NAME = "built-in search"

_STATES_BEFORE_PAIRS = 60
"""After how many evaluated states it is asked whether the goal's literals may hold together at all."""

_BOOSTED_STATES = 1000
"""How many preferred states are taken before any other after a state that is nearer to the goal than all
before."""

_MAX_CENTRAL_STATES = 60
"""How many states may be evaluated with actions on the goal's objects only."""

_MAX_GROUNDING_LOOKS = 50_000
"""How many objects may be looked at to ground operators and goal; of the operators of nine models none is too
large for it."""


@dataclass(frozen=True, slots=True)
class BuiltInPlanner:
    """The search of this package.

    Attributes:
        limits: of its effort.
        then: is asked about what the search cannot decide. If None, what exceeds its effort is
            `PlannerOutcome.TIME`, and what it cannot ground `PlannerOutcome.UNSUPPORTED`.
    """

    limits: Limits = field(default_factory=Limits)
    then: PddlPlanner | None = None

    @property
    def name(self) -> str:
        """The names in records of the search and of what is asked then."""
        return _NAME if self.then is None else f"{_NAME}, then {self.then.name}"

    def solve(self, task: PlanningTask) -> PlannerResult:
        """Look for a plan."""
        result = self._solve(task)
        decided = result.outcome in {PlannerOutcome.SOLVED, PlannerOutcome.UNSOLVABLE}
        return result if decided or self.then is None else self.then.solve(task)

    def _solve(self, task: PlanningTask) -> PlannerResult:
        if task.fatal is not None:
            return PlannerResult(PlannerOutcome.UNSUPPORTED, detail="an effect adds an unbound variable")
        if DerivedPredicates(task.domain.axioms).circles:
            detail = "a derived predicate depends on itself"
            return PlannerResult(PlannerOutcome.UNSUPPORTED, detail=detail)
        task = drop_idle_quantifiers(task)
        result = search(task.domain, task.problem, self.limits)
        match result.end:
            case SearchEnd.SOLVED:
                return check_plan(task, result.plan, _NAME)
            case SearchEnd.UNREACHABLE:
                return PlannerResult(PlannerOutcome.UNSOLVABLE, detail=_NAME)
            case SearchEnd.STATES:
                looked = f"{result.states} states evaluated" if result.states else "too large a search"
                return PlannerResult(PlannerOutcome.TIME, detail=looked)


def search(domain: m.PddlDomain, problem: m.PddlProblem, limits: Limits) -> SearchResult[PlanStep]:
    """Look for a plan.

    `SearchEnd.UNREACHABLE` is a proof: the goal is out of reach even if nothing is ever lost, or two of
    its literals never hold together, or the whole state space was searched. What is too large to be grounded
    is undecided, and so is what a derived predicate that depends on itself says.
    """
    if DerivedPredicates(domain.axioms).circles:
        return SearchResult(SearchEnd.STATES)
    looks = Effort(_MAX_GROUNDING_LOOKS)
    grounder = Grounder(restrict_to_relevant(domain, problem), problem, looks)
    goal = grounder.goal()
    if goal is None and not looks.is_exceeded:
        return SearchResult(SearchEnd.UNREACHABLE)
    objects = grounder.central_objects()
    central, all_are_central = list(grounder.actions(objects)), objects >= grounder.objects
    if goal is None or looks.is_exceeded:
        return SearchResult(SearchEnd.STATES)
    work = Effort(limits.looks)
    states = limits.states if all_are_central else min(_MAX_CENTRAL_STATES, limits.states)
    result = _GroundSearch(GroundProblem(grounder, central, goal, work), work, states).run()
    if result.end is SearchEnd.SOLVED or all_are_central:
        return result
    everything = list(grounder.actions())
    if looks.is_exceeded:
        return SearchResult(SearchEnd.STATES, states=result.states)
    return _GroundSearch(GroundProblem(grounder, everything, goal, work), work, limits.states).run()


_SearchNode: TypeAlias = Node[int, PlanStep]


class _Alternation:
    """Two open lists in turn: all states to be evaluated, and those again that a preferred action leads to.

    A state comes where the estimate of the one before says; of equal ones the last to arrive is the first.
    """

    def __init__(self) -> None:
        self._everything: OpenList[_SearchNode] = OpenList()
        self._preferred: OpenList[_SearchNode] = OpenList()
        self._lead = 0
        self._arrivals = 0

    def push(self, estimate: int, node: _SearchNode, *, preferred: bool) -> None:
        self._arrivals += 1
        self._everything.push(node, estimate, -self._arrivals)
        if preferred:
            self._preferred.push(node, estimate, -self._arrivals)

    def pop(self) -> _SearchNode | None:
        """The next state; one that is in both lists comes twice."""
        if self._preferred and self._lead < 0:
            self._lead += 1
            return self._preferred.pop()
        self._lead -= 1
        return self._everything.pop()

    def boost(self) -> None:
        """Take more of the preferred states."""
        self._lead -= _BOOSTED_STATES


class _GroundSearch:
    """One search over one set of ground actions."""

    def __init__(self, problem: GroundProblem, looks: Effort, states: int) -> None:
        self._problem = problem
        self._relaxation = Relaxation(problem, looks)
        self._looks = looks
        self._states = states
        self._open = _Alternation()
        self._ahead: _SearchNode | None = Node(problem.initial)
        self._seen, self._done = {problem.initial}, set[int]()
        self._least = inf

    def run(self) -> SearchResult[PlanStep]:
        found = best_first(self._following, self._visit)
        if isinstance(found, Node):
            return SearchResult(SearchEnd.SOLVED, found.plan(), len(self._done))
        end = SearchEnd.STATES if self._looks.is_exceeded else found
        return SearchResult(end, states=len(self._done))

    def _following(self) -> _SearchNode | None:
        """The state that lookahead has led to, or else the next one; it has not been evaluated."""
        node = self._ahead or self._open.pop()
        self._ahead = None
        while node is not None and node.state in self._done:
            node = self._open.pop()
        return node

    def _visit(self, node: _SearchNode) -> _SearchNode | SearchEnd | None:
        """Test a state, evaluate it and queue what comes after."""
        literals = self._problem.literals_of(node.state)
        if not self._problem.goal & ~literals:
            return node
        if len(self._done) == self._states or self._looks.is_exceeded:
            return SearchEnd.STATES
        if len(self._done) == _STATES_BEFORE_PAIRS and not _Pairs(self._problem, self._looks).allow(
            self._problem.goal
        ):
            return SearchEnd.UNREACHABLE
        self._done.add(node.state)
        estimate = self._relaxation.estimate(node.state, literals)
        if estimate is None:
            return None
        if estimate.length < self._least:
            self._least = estimate.length
            self._open.boost()
            self._ahead = self._look_ahead(node, literals)
        for action, state in self._problem.successors(node.state, literals):
            if state not in self._seen:
                self._seen.add(state)
                child = self._child(node, action.bit_length() - 1, state)
                self._open.push(estimate.length, child, preferred=bool(action & estimate.helpful))
        if self._ahead is not None:
            self._seen.add(self._ahead.state)
        return None

    def _child(self, node: _SearchNode, action: int, state: int) -> _SearchNode:
        return Node(state, 0, node.depth + 1, node, (self._problem.actions[action].step,))

    def _look_ahead(self, node: _SearchNode, literals: int) -> _SearchNode:
        """Where carrying out the relaxed plan leads."""
        for action, state in look_ahead(self._problem, self._relaxation, node.state, literals):
            node = self._child(node, action, state)
        return node


class _PairRule(NamedTuple):
    """A conditional effect: what it needs and makes, what always and perhaps is made too, what is lost."""

    needs: int
    makes: int
    always: int
    perhaps: int
    lost: int


class _Pairs:
    """Reachable pairs: the literals that may hold together in a state that actions lead to from a first one.

    That a hand which holds one thing holds no other is a statement on pairs, which a relaxed plan forgets.
    Two literals may hold together at the start, or after an action that makes one of them and makes or keeps
    the other (h2; Haslum and Geffner 2000). Choices in conditions are left out, and conditional effects that
    may take place may do so together: more pairs are found than there are, never fewer. So a goal with a pair
    that is not found has no plan.

    Args:
        problem: the ground problem.
        looks: how many literals may be looked at. Where they are used up, what is found means nothing.
    """

    def __init__(self, problem: GroundProblem, looks: Effort) -> None:
        self._atoms = problem.atoms
        self._every_atom = (1 << self._atoms) - 1
        self._looks = looks
        self._reached = problem.initial | (~problem.initial & self._every_atom) << self._atoms
        self._beside = dict.fromkeys(bits(self._reached), self._reached)
        rules = [rule for action in problem.actions for rule in self._rules(action.needs, action.changes)]
        while self._grow(rules):
            pass

    def allow(self, needed: int) -> bool:
        """Whether all literals that are needed may hold together, as far as pairs tell."""
        return self._looks.is_exceeded or self._find_companions(self._plain(needed)) is not None

    def _rules(self, needs: int, changes: Iterable[tuple[int, int, int]]) -> Iterator[_PairRule]:
        """The rules of an action: what it needs, and what its effects need, add and delete."""
        made = [(also, add | (delete & ~add) << self._atoms) for also, add, delete in changes]
        always = reduce(or_, [makes for also, makes in made if not also], 0)
        perhaps = reduce(or_, [makes for also, makes in made if also], 0)
        for also, makes in made:
            yield _PairRule(self._plain(needs | also), makes, always, perhaps, self._negate(makes | always))

    def _grow(self, rules: Sequence[_PairRule]) -> bool:
        """Add the pairs that effects make, in turn; whether there are any new ones."""
        grew = False
        for rule in rules:
            if self._looks.is_exceeded:
                return False
            grew |= self._apply(rule)
        return grew

    def _apply(self, rule: _PairRule) -> bool:
        """Add the pairs that one effect makes."""
        kept = self._find_companions(rule.needs)
        if kept is None:
            return False
        together = kept & ~rule.lost | rule.makes | rule.always | rule.perhaps & self._reached
        grew = False
        for literal in bits(rule.makes):
            new = together & ~self._beside.get(literal, 0) & ~self._negate(literal)
            if new:
                grew = True
                self._beside[literal] = self._beside.get(literal, 0) | new
                for other in bits(new):
                    self._beside[other] = self._beside.get(other, 0) | literal
                self._reached |= new
                self._looks.used += new.bit_count()
        return grew

    def _find_companions(self, needed: int) -> int | None:
        """The literals that may hold together with each of those that are needed; None if those may not."""
        self._looks.used += 1 + needed.bit_count()
        found = self._reached
        for literal in bits(needed):
            found &= self._beside.get(literal, 0)
        return None if needed & ~found else found

    def _plain(self, needed: int) -> int:
        """The literals of atoms, without choices."""
        return needed & (1 << 2 * self._atoms) - 1

    def _negate(self, literals: int) -> int:
        """The opposites of literals."""
        return literals >> self._atoms | (literals & self._every_atom) << self._atoms
