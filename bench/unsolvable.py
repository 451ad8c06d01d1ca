"""Which tasks no plan can solve, proved by what could ever be so if nothing got in the way of anything.

    python bench/unsolvable.py [SUITE] [--every N] [--solved]

Every fact may be so, or not, from when an action could make it so, whatever else is so then; what can be held
may be anywhere. What cannot be so even then is never so: a goal that cannot is proved out of reach. So are
goals whose facts exclude each other. By default the activities of BEHAVIOR-1K that are left out are tried;
`--solved` takes those with a plan, of which none may be out of reach.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product

import eai.logic.formula as f
from eai.abilities.task import Task
from eai.benchmark.registry import find_benchmark
from eai.planning.exclusion import Exclusion, ExclusionRules
from eai.planning.subgoal import GroundAtom, Subgoal, conjuncts
from eai.tasks.source import Source
from eai.world.derived import Defined
from eai.world.domain import Domain
from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach, Let, When
from eai.world.frame import AGENT
from eai.world.operator import Operator
from eai.world.state import Fact, State

FREE = frozenset(("stands_by", "stands_under", "robot_on"))
"""The predicates that are taken to be anything."""

SUPPORTS = frozenset(("lies_in", "lies_on", "attached_to", "laid_over", "draped_on"))
"""Those of what a thing is in or on: that may be anything where it ever is in or on something, or held."""

Scope = Mapping[str, int]


class Possible:
    """What may ever be so in an episode of a domain, and what may ever not.

    Args:
        domain: the domain.
        initial: where the episode begins.
        usable: the objects that actions may be about.
    """

    def __init__(self, domain: Domain, initial: State, usable: Sequence[int]) -> None:
        self._domain = domain
        self._usable = usable
        self._scene = initial.scene
        self._at_start = set(initial.facts())
        self._so = set(self._at_start)
        self._not_so: set[Fact] = set()
        self._changing = {predicate for predicate, _ in self._at_start}
        self._placed = {arguments[0] for predicate, arguments in self._at_start if predicate in SUPPORTS}
        while self._grows():
            pass

    def holds(self, formula: f.Formula, scope: Scope, truth: bool = True) -> bool:
        """Whether a formula may be true, or false."""
        match formula:
            case f.Atom(predicate, terms):
                return self._atom(predicate, tuple([self._index(term, scope) for term in terms]), truth)
            case f.Equals(left, right):
                return (self._index(left, scope) == self._index(right, scope)) == truth
            case f.Not(part):
                return self.holds(part, scope, not truth)
            case f.And(parts) | f.Or(parts):
                each = (self.holds(part, scope, truth) for part in parts)
                return all(each) if isinstance(formula, f.And) == truth else any(each)
            case f.Implies(premise, conclusion):
                return self.holds(f.Or((f.Not(premise), conclusion)), scope, truth)
            case f.ForAll(variable, body) | f.Exists(variable, body):
                each = (self.holds(body, inner, truth) for inner in self._instances(variable, scope))
                return all(each) if isinstance(formula, f.ForAll) == truth else any(each)
            case f.Exactly(count, variable, body):
                instances = list(self._instances(variable, scope))
                may = sum(self.holds(body, inner) for inner in instances)
                must = sum(not self.holds(body, inner, truth=False) for inner in instances)
                return must <= count <= may if truth else (may, must) != (count, count)
            case f.ForPairs(first, second, body):
                rows = [list(self._instances(second, row)) for row in self._instances(first, scope)]
                met = sum(any(self.holds(body, inner) for inner in row) for row in rows)
                return not truth or met >= (formula.count or min(len(rows), len(rows[0]) if rows else 0))
        raise TypeError(f"expected a formula about one state, found {type(formula).__name__}")

    def _instances(self, variable: f.Variable, scope: Scope) -> Iterator[Scope]:
        mask = self._scene.category(variable.category)
        for index in range(len(self._scene.objects)):
            if mask >> index & 1:
                yield {**scope, variable.name: index}

    def _index(self, term: f.Term, scope: Scope) -> int:
        if isinstance(term, f.Variable) or term.name in scope:
            return scope[term.name]
        agent = self._scene.agent
        return agent if term == AGENT and agent is not None else self._scene.index[term.name]

    def _atom(self, predicate: str, arguments: tuple[int, ...], truth: bool) -> bool:
        derived = self._domain.vocabulary.derived_by_name.get(predicate)
        if derived is None:
            if predicate in FREE:
                return True
            if predicate in SUPPORTS:
                thing = arguments[0]
                return not truth or thing in self._placed or Fact("held", (thing,)) in self._so
            fact = Fact(predicate, arguments)
            return fact in self._so if truth else fact not in self._at_start or fact in self._not_so
        if not isinstance(derived, Defined) or derived.values is not None:
            return True
        names = [parameter.name for parameter in derived.parameters]
        return self.holds(derived.definition, dict(zip(names, arguments, strict=True)), truth)

    def _grows(self) -> bool:
        """Let every action do what it may, once; whether that makes more possible."""
        before = self._known()
        for operator in self._domain.operators:
            names = [parameter.name for parameter in operator.parameters]
            conditions = [check.condition for check in operator.checks]
            if operator.tries:
                raise TypeError(f"{operator.name}: expected an operator that tries nothing")
            if not self._matters(operator):
                continue
            for arguments in product(self._usable, repeat=len(names)):
                scope = dict(zip(names, arguments, strict=True))
                if all(self.holds(condition, scope) for condition in conditions):
                    self._do(operator.effects, scope)
        return self._known() > before

    def _known(self) -> int:
        return len(self._so) + len(self._not_so) + len(self._placed)

    def _matters(self, operator: Operator) -> bool:
        """Whether an action does more than to put down what was in a hand."""
        held = {check.condition for check in operator.checks}
        for adds, atom in _changes(operator.effects):
            predicate, first = atom.predicate, atom.arguments[0]
            if predicate in FREE or (not adds and (predicate in SUPPORTS or predicate not in self._changing)):
                continue
            if predicate not in SUPPORTS or f.Atom("held", (first,)) not in held:
                return True
        return False

    def _do(self, effects: Iterable[Effect], scope: Scope) -> None:
        for effect in effects:
            match effect:
                case Add(atom):
                    arguments = tuple([self._index(term, scope) for term in atom.arguments])
                    if atom.predicate in SUPPORTS:
                        self._placed.add(arguments[0])
                    else:
                        self._so.add(Fact(atom.predicate, arguments))
                case Delete(atom):
                    self._delete(atom, scope)
                case When(condition, inner, otherwise):
                    if self.holds(condition, scope):
                        self._do(inner, scope)
                    if otherwise and self.holds(condition, scope, truth=False):
                        self._do(otherwise, scope)
                case ForEach(variable, condition, inner) | Let(variable, condition, inner):
                    for each in list(self._instances(variable, scope)):
                        if self.holds(condition, each):
                            self._do(inner, each)

    def _delete(self, atom: f.Atom, scope: Scope) -> None:
        wanted = [None if term == ANYTHING else self._index(term, scope) for term in atom.arguments]
        for predicate, arguments in self._at_start:
            if predicate == atom.predicate and all(
                each in (None, own) for each, own in zip(wanted, arguments, strict=True)
            ):
                self._not_so.add(Fact(predicate, arguments))


def _changes(effects: Iterable[Effect]) -> Iterator[tuple[bool, f.Atom]]:
    """The atoms that effects add (True) or delete."""
    for effect in effects:
        match effect:
            case Add(atom) | Delete(atom):
                yield isinstance(effect, Add), atom
            case When(_, inner, otherwise):
                yield from _changes((*inner, *otherwise))
            case ForEach(_, _, inner) | Let(_, _, inner):
                yield from _changes(inner)


def _literals(task: Task) -> Iterator[GroundAtom]:
    """The facts that the goals ask for in any case, and those that they deny."""
    scene = task.scene
    for goal in task.goals:
        for formula, scope, truth in conjuncts(Subgoal(goal.formula, {}, True), scene):
            if isinstance(formula, f.Atom):
                indices = (scope.get(t.name, scene.index.get(t.name, -1)) for t in formula.arguments)
                yield GroundAtom(formula.predicate, tuple(indices), truth)


def main() -> int:
    """Print for each task which of its goals are out of reach."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("suite", nargs="?", default="behavior-1k")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--solved", action="store_true")
    arguments = parser.parse_args()
    benchmark = find_benchmark(arguments.suite)
    tasks = benchmark.tasks(Source())
    chosen = [task for task in tasks.values() if bool(task.script) == arguments.solved][:: arguments.every]
    rules, proved, start = ExclusionRules(benchmark.domain), 0, time.process_time()
    for task in chosen:
        possible = Possible(benchmark.domain, task.initial, task.relevant)
        never = [goal for goal in task.goals if not possible.holds(goal.formula, {})]
        shown = "; ".join(str(goal.formula) for goal in never)
        if not never and Exclusion(rules, task.initial).excludes(_literals(task)):
            never, shown = list(task.goals), "its facts exclude each other"
        proved += bool(never)
        print(f"{task.id}: {'out of reach' if never else 'open'} {shown}"[:200], flush=True)
    print(f"{proved} of {len(chosen)} proved out of reach, {time.process_time() - start:.0f} CPU s")
    return int(arguments.solved and proved > 0)


if __name__ == "__main__":
    sys.exit(main())
