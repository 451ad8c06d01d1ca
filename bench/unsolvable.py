"""Prove that tasks have no plan, from the facts that could ever become true.

    python -m bench unsolvable [SUITE] [--every N] [--solved]

Every fact may be so, or not, from when an action could make it so, whatever else is so then; what can be held
may be anywhere. What cannot be so even then is never so: a goal that cannot is proved out of reach. So are
goals whose facts exclude each other. By default the activities of BEHAVIOR-1K that are left out are tried;
`--solved` takes those with a plan, of which none may be out of reach.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace

import eai.logic.formula as f
from bench.record import add_write_option, write_figures
from eai.benchmarks.registry import find_benchmark
from eai.planning.exclusion import ExclusionRules
from eai.planning.possible import PossibleFacts
from eai.planning.subgoal import GroundAtom, Subgoal, conjuncts
from eai.tasks.source import Source
from eai.tasks.task import Task
from eai.world.derived import Defined
from eai.world.domain import Domain
from eai.world.effect import Add, Delete, Effect, ForEach, Let, When
from eai.world.operator import Operator
from eai.world.state import Fact, State

FREE = frozenset(("stands_by", "stands_under", "robot_on"))
"""The predicates that are taken to be anything."""

SUPPORTS = frozenset(("lies_in", "lies_on", "attached_to", "laid_over", "draped_on"))
"""Those of what a thing is in or on: that may be anything where it ever is in or on something, or held."""


class _Possible(PossibleFacts):
    """What may ever be so in BEHAVIOR-1K: what can be held may be anywhere, and what touches what is free."""

    def __init__(self, domain: Domain, initial: State, usable: Sequence[int]) -> None:
        at_start = list(initial.facts())
        self._placed = {arguments[0] for predicate, arguments in at_start if predicate in SUPPORTS}
        changing = {predicate for predicate, _ in at_start}
        chosen = [operator for operator in domain.operators if _matters(operator, changing)]
        super().__init__(replace(domain, operators=tuple(chosen)), initial, usable)

    def count_literals(self) -> int:
        return super().count_literals() + len(self._placed)

    def atom(self, predicate: str, arguments: tuple[int, ...], truth: bool) -> bool:
        if predicate in FREE:
            return True
        if predicate in SUPPORTS:
            thing = arguments[0]
            return not truth or thing in self._placed or Fact("held", (thing,)) in self.possibly_true
        derived = self.domain.vocabulary.derived_by_name.get(predicate)
        if isinstance(derived, Defined) and derived.values is not None:
            return True
        return super().atom(predicate, arguments, truth)

    def add(self, fact: Fact) -> None:
        if fact.predicate in SUPPORTS:
            self._placed.add(fact.arguments[0])
        else:
            super().add(fact)


def _matters(operator: Operator, changing: Collection[str]) -> bool:
    """Whether an action does more than to put down what was in a hand."""
    held = {check.condition for check in operator.checks}
    for adds, atom in _changes(operator.effects):
        predicate, first = atom.predicate, atom.arguments[0]
        if predicate in FREE or (not adds and (predicate in SUPPORTS or predicate not in changing)):
            continue
        if predicate not in SUPPORTS or f.Atom("held", (first,)) not in held:
            return True
    return False


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
    add_write_option(parser)
    arguments = parser.parse_args()
    benchmark = find_benchmark(arguments.suite)
    tasks = benchmark.tasks(Source())
    chosen = [task for task in tasks.values() if bool(task.script) == arguments.solved][:: arguments.every]
    rules, proved, start = ExclusionRules(benchmark.domain), 0, time.process_time()
    for task in chosen:
        possible = _Possible(benchmark.domain, task.initial, task.relevant)
        never = [goal for goal in task.goals if not possible.holds(goal.formula, {})]
        shown = "; ".join(str(goal.formula) for goal in never)
        if not never and rules.make_exclusion(task.initial).excludes(_literals(task)):
            never, shown = list(task.goals), "its facts exclude each other"
        proved += bool(never)
        print(f"{task.id}: {'out of reach' if never else 'open'} {shown}"[:200], flush=True)
    print(f"{proved} of {len(chosen)} proved out of reach, {time.process_time() - start:.0f} CPU s")
    if arguments.write:
        share = f"{proved} of {len(chosen)}"
        if arguments.solved:
            write_figures("unsolvable", {"Activities with a plan that are proved unsolvable": share})
        else:
            write_figures("unsolvable", {"Excluded BEHAVIOR-1K activities that are proved unsolvable": share})
    return int(arguments.solved and proved > 0)
