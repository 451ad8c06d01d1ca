"""Refinement: which actions carry out a subgoal, found by a small search on the declared domain.

For each literal of a subgoal at most one *deed* is done, in any order. Three things are no deeds (`Role`) and
are done as often as the deeds need them: *movement*, *taking* what the subgoal names into a hand, and
*letting go* of what a hand holds, where nothing else helps. So the goal of a task is no subgoal, unless one
deed for each of its literals reaches it. The shortest sequence is taken; of equally short ones all are handed
on, for the search that carries out the whole answer to try. Effort is bounded by a number of applied actions,
never by time; operators and objects are tried in their order. (Paper, section "Ability Module 2: Subgoal
Decomposition": a breadth-first search with a bounded number of actions for each subgoal.)
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import permutations, product
from typing import NamedTuple

from eai.abilities.subgoal_decomposition.program import Plan, Plans
from eai.abilities.subgoal_decomposition.progress import StateTest
from eai.abilities.subgoal_decomposition.refining import (
    Aim,
    Ground,
    Holds,
    Means,
    Nearest,
    Refining,
    is_needless,
)
from eai.logic.formula import Atom, Constant, Formula, Not, Variable
from eai.logic.traversal import walk
from eai.planning.change import Change, changes_for
from eai.planning.effect_schema import EffectSchema, effect_schemas
from eai.planning.role import role_of
from eai.planning.subgoal import GroundAtom
from eai.world.derived import Defined
from eai.world.domain import CompiledOperator, Domain
from eai.world.effect import ANYTHING
from eai.world.execution import Action
from eai.world.fault import FaultKind
from eai.world.frame import AGENT
from eai.world.operator import Operator, Role
from eai.world.state import Scene, State


class _Serving(NamedTuple):
    """What can make some operators possible: what takes things and lets them go, and movement, by name."""

    helping: Sequence[Operator]
    movement: Mapping[str, CompiledOperator]


class Refinement:
    """Finds what carries out subgoals of one domain.

    Args:
        domain: the domain.
        budget: how many actions a search may apply to states for each literal of a subgoal.
    """

    def __init__(self, domain: Domain, budget: int = 300) -> None:
        self._domain = domain
        self._budget = budget
        self._roles = {operator.name: role_of(operator) for operator in domain.operators}
        self._effects = {operator.name: tuple(effect_schemas(operator)) for operator in domain.operators}
        self._writes = {
            name: frozenset([effect.atom.predicate for effect in effects])
            for name, effects in self._effects.items()
        }
        self._checks = {o.name: self._sources(_predicates(_checks(o))) for o in domain.operators}
        self._asks = {
            name: self._checks[name] | self._sources(_predicates([f for e in effects for f in e.given]))
            for name, effects in self._effects.items()
        }
        self._movement = _without_doubles(self._of(domain.operators, Role.MOVEMENT))
        moved = frozenset().union(*[self._writes[operator.name] for operator in self._movement])
        self._mended = {
            operator.name: tuple(
                [
                    check.fault is not FaultKind.ADDITIONAL_STEP
                    and not moved.isdisjoint(self._sources(_predicates([check.condition])))
                    for check in operator.checks
                ]
                + [False]
            )
            for operator in domain.operators
        }
        self._served: dict[frozenset[str], _Serving] = {}

    def brings_about(self, literal: GroundAtom) -> bool:
        """Whether any action changes what the literal is about."""
        return bool(self._writers(literal.predicate))

    def plans(
        self,
        literals: Sequence[GroundAtom],
        holds: Holds,
        scene: Scene,
        objects: Sequence[int],
        told_apart: Collection[str] = (),
        *,
        may_be_needless: bool = True,
    ) -> Plans:
        """What is done in a state so that a subgoal holds.

        Where it holds already, that is nothing, or the actions which would bring it about and say themselves
        that they are not needed. Where it cannot be made to hold, it is what comes nearest, and then the
        action that fails, to be diagnosed.

        Args:
            literals: what the subgoal says of objects.
            holds: whether the subgoal holds; it may say more than its literals.
            scene: the scene.
            objects: what actions may be about.
            told_apart: the operators of which it matters that they are taken.
            may_be_needless: whether actions that are not needed are told where the subgoal holds already.
        """
        parts = [StateTest(_formula(literal, scene), scene) for literal in literals]
        wanted = self._wanted(literals, scene)
        named = _named([literal.arguments for literal in literals], scene)

        def met(state: State, _: Action | None = None) -> int:
            return sum([1 << i for i, part in enumerate(parts) if part(state)])

        aim = Aim(met, (1 << len(parts)) - 1, holds, len(literals), told_apart)

        def plans(state: State) -> Sequence[Plan]:
            if met(state) == aim.everything and holds(state):
                needless = self._needless(wanted, state) if may_be_needless else ()
                return (needless,) if needless else ()
            wider = partial(self._wanted, literals, scene, objects)
            return self._search(state, aim, self._means(wanted, named, objects, wider))

        return plans

    def plans_to_take(self, action: Action, scene: Scene, objects: Sequence[int]) -> Plans:
        """An action, after the shortest sequence that makes it possible; the attempt where there is none."""
        aim = Aim(lambda _, last: int(last == action), 1, lambda _: True, 1, ())
        named = _named([action.arguments], scene)

        def plans(state: State) -> Sequence[Plan]:
            if self._is_needless(action, state):
                return ((action,),)
            return self._search(state, aim, self._means({action: 1}, named, objects))

        return plans

    def _search(self, state: State, aim: Aim, phases: Iterable[Means]) -> Sequence[Plan]:
        """The shortest plans by the first means that are enough; where none are, the best attempt of all."""
        best: Nearest | None = None
        for means in phases:
            refining = Refining(aim, means, self._budget)
            found = refining.shortest(state)
            if found:
                return found
            nearest = refining.nearest()
            best = nearest if best is None or nearest.rank > best.rank else best
        return () if best is None else (best.plan,)

    def _means(
        self,
        wanted: Mapping[Action, int],
        named: Sequence[int],
        objects: Sequence[int],
        wider: Callable[[], Mapping[Action, int]] | None = None,
    ) -> Iterator[Means]:
        """What may be done, widened step by step.

        First what is about nothing but the objects that are named; then letting go of any object; then going
        to any object, and deeds about any where the literal leaves open about which.

        Args:
            wanted: what may bring the subgoal about, and the mask of the parts that each action is for.
            named: the objects that the subgoal names.
            objects: what actions may be about.
            wider: gives what may bring it about by means of other objects; None where an action is wanted for
                its own sake, not for where it leads.
        """
        helping, movement = self._serving(frozenset([action.operator for action in wanted]))
        moves, deeds = self._split(wanted, leading=wider is not None)
        handled = any(self._roles[action.operator] is not Role.LETS_GO for action in wanted)
        takes = [self._grounded(a) for a in _about(self._of(helping, Role.TAKES), named) if handled]
        yield Means(deeds, takes, moves, movement, named)
        lets_go = [self._grounded(a) for a in _about(self._of(helping, Role.LETS_GO), objects)]
        if lets_go:
            yield Means(deeds, [*takes, *lets_go], moves, movement, named)
        if wider is not None:
            wanted = wider()
            helping, movement = self._serving(frozenset([action.operator for action in wanted]))
            moves, deeds = self._split(wanted, leading=True)
        if movement:
            yield Means(deeds, [*takes, *lets_go], moves, movement, objects)

    def _split(self, wanted: Mapping[Action, int], *, leading: bool) -> tuple[list[Ground], list[Ground]]:
        """The movement that is wanted for where it leads, and all else that is wanted."""
        ways = [self._grounded(action, parts) for action, parts in wanted.items()]
        moves = [way for way in ways if leading and self._roles[way.action.operator] is Role.MOVEMENT]
        return moves, [way for way in ways if way not in moves]

    def _wanted(
        self, literals: Sequence[GroundAtom], scene: Scene, objects: Sequence[int] = ()
    ) -> dict[Action, int]:
        """The actions that may bring literals about, each with the mask of those that it is for."""
        wanted: dict[Action, int] = {}
        for i, literal in enumerate(literals):
            for action in self._ways(literal, scene, objects):
                wanted[action] = wanted.get(action, 0) | 1 << i
        return wanted

    def _serving(self, names: frozenset[str]) -> _Serving:
        """The other operators that can make true what those of some names ask for, and so on."""
        serving = self._served.get(names)
        if serving is None:
            asking = [operator for operator in self._domain.operators if operator.name in names]
            hands = [o for o in self._domain.operators if self._roles[o.name] in (Role.TAKES, Role.LETS_GO)]
            helping = _closure(asking, hands, self._asks, self._writes)
            movement = _closure([*asking, *helping], self._movement, self._checks, self._writes)
            compiled = {
                o.name: self._domain.compiled[o.name]
                for o in self._movement
                if o in movement or o.name in names
            }
            serving = self._served[names] = _Serving(helping, compiled)
        return serving

    def _ways(self, literal: GroundAtom, scene: Scene, others: Sequence[int]) -> list[Action]:
        """The actions that may bring a literal about: of its objects, or of others where it leaves them open.

        Where the agent is, what it faces and its posture is a matter of movement only.
        """
        objects = _named([literal.arguments, tuple(others)], scene)
        changes = changes_for(literal, scene)
        found: dict[Action, None] = {}
        for operator in self._writers(literal.predicate):
            for effect, change in product(self._effects[operator.name], changes):
                scope = _match(effect, change, scene)
                if scope is not None:
                    choices = [[scope[p.name]] if p.name in scope else objects for p in operator.parameters]
                    for arguments in product(*choices):
                        if len({*arguments, scene.agent}) > len(arguments):
                            found[Action(operator.name, arguments)] = None
        moving = [action for action in found if self._roles[action.operator] is Role.MOVEMENT]
        return moving if moving and scene.agent in literal.arguments else list(found)

    def _needless(self, wanted: Mapping[Action, int], state: State) -> tuple[Action, ...]:
        """For each literal the first action that says it is not needed: its object is as it makes it."""
        found: list[Action] = []
        told = 0
        for action, parts in wanted.items():
            letting_go = self._roles[action.operator] is Role.LETS_GO
            if not letting_go and parts & ~told and self._is_needless(action, state):
                found.append(action)
                told |= parts
        return tuple(found)

    def _is_needless(self, action: Action, state: State) -> bool:
        return is_needless(self._domain.compiled[action.operator], action, state)

    def _of(self, operators: Iterable[Operator], role: Role) -> list[Operator]:
        return [operator for operator in operators if self._roles[operator.name] is role]

    def _grounded(self, action: Action, parts: int = 0) -> Ground:
        name = action.operator
        is_deed = self._roles[name] is Role.DEED
        return Ground(action, self._domain.compiled[name], is_deed, self._mended[name], parts)

    def _writers(self, predicate: str) -> list[Operator]:
        """The operators that change what a predicate comes down to, in the order of their declaration."""
        sources = self._sources([predicate])
        return [o for o in self._domain.operators if not self._writes[o.name].isdisjoint(sources)]

    def _sources(self, predicates: Iterable[str]) -> frozenset[str]:
        """The stored predicates that predicates come down to."""
        derived = self._domain.vocabulary.derived_by_name
        pending, seen = list(predicates), set[str]()
        while pending:
            name = pending.pop()
            if name not in seen:
                seen.add(name)
                match derived.get(name):
                    case None:
                        pass
                    case Defined(definition=definition):
                        pending += _predicates([definition])
                    case lookup:
                        pending += lookup.reads
        return frozenset(seen.difference(derived))


def _without_doubles(operators: Iterable[Operator]) -> list[Operator]:
    """Of operators that check and do the same the first."""
    kept: dict[object, Operator] = {}
    for operator in operators:
        kept.setdefault((operator.parameters, operator.checks, operator.effects, operator.tries), operator)
    return list(kept.values())


def _named(arguments: Iterable[tuple[int, ...]], scene: Scene) -> tuple[int, ...]:
    """Objects, each once, without the agent."""
    return tuple(dict.fromkeys([i for each in arguments for i in each if i != scene.agent]))


def _formula(literal: GroundAtom, scene: Scene) -> Formula:
    atom = Atom(literal.predicate, tuple([Constant(scene.objects[i].name) for i in literal.arguments]))
    return atom if literal.truth else Not(atom)


def _predicates(formulas: Iterable[Formula]) -> list[str]:
    return [part.predicate for formula in formulas for part in walk(formula) if isinstance(part, Atom)]


def _about(operators: Iterable[Operator], objects: Sequence[int]) -> list[Action]:
    """The actions by operators about different objects."""
    return [Action(o.name, arguments) for o in operators for arguments in permutations(objects, o.arity)]


def _match(effect: EffectSchema, change: Change, scene: Scene) -> dict[str, int] | None:
    """The parameters' objects where an effect makes a change; None if it does not."""
    if effect.atom.predicate != change.predicate or effect.adds is not change.truth:
        return None
    scope: dict[str, int] = {}
    for term, index in zip(effect.atom.arguments, change.arguments, strict=True):
        if index is None or term == ANYTHING:
            continue
        if isinstance(term, Variable):
            if scope.setdefault(term.name, index) != index:
                return None
        elif term == AGENT and index != scene.agent:
            return None
    return scope


def _checks(operator: Operator) -> Iterator[Formula]:
    """All that an operator's checks ask for."""
    for checks in (operator.checks, *(each.checks for each in operator.tries)):
        yield from (check.condition for check in checks)


def _closure(
    operators: Iterable[Operator],
    candidates: Sequence[Operator],
    asks: Mapping[str, frozenset[str]],
    writes: Mapping[str, frozenset[str]],
) -> list[Operator]:
    """The candidates that change what operators ask for, or what such candidates do, in their order."""
    found: list[Operator] = []
    asking = list(operators)
    while asking:
        asked = frozenset[str]().union(*[asks[operator.name] for operator in asking])
        asking = [o for o in candidates if o not in found and not writes[o.name].isdisjoint(asked)]
        found += asking
    return [operator for operator in candidates if operator in found]
