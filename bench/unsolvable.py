"""Prove that tasks have no plan, from the facts that could ever become true.

    python -m bench unsolvable [SUITE] [--every N] [--solved]

The proof relaxes the rules. A fact may be true or false as soon as an action could change it, whatever else
holds. An object that can be held may be anywhere. A fact that stays impossible under these rules is never
true, so a goal that needs it has no plan. Goals whose facts exclude each other have no plan either.

By default the excluded activities of BEHAVIOR-1K are tried. `--solved` tries activities with a plan; a proof
for one of them is a fault of this program.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace

import eai.logic.formula as f
from bench.record import add_write_option, write_figures
from eai.benchmarks.registry import find_benchmark
from eai.planning.exclusion import MutualExclusionRules
from eai.planning.possible import PossibleFacts
from eai.planning.subgoal import GroundAtom, Subgoal, split_conjuncts
from eai.tasks.source import Source
from eai.tasks.task import Task
from eai.world.derived import DefinedPredicate
from eai.world.domain import Domain
from eai.world.effect import Add, Delete, Effect, ForEach, Let, When
from eai.world.operator import Operator
from eai.world.state import Fact, State

FREE = frozenset(("stands_by", "stands_under", "robot_on"))
"""Predicates that may have any value in this proof."""

SUPPORTS = frozenset(("lies_in", "lies_on", "attached_to", "laid_over", "draped_on"))
"""Predicates of support, which may hold anywhere if an object is ever in or on something, or held."""


class _Possible(PossibleFacts):
    """Facts of BEHAVIOR-1K that may ever hold. Objects that can be held may be anywhere."""

    def __init__(self, domain: Domain, initial: State, usable: Sequence[int]) -> None:
        at_start = list(initial.facts())
        self._placed = {arguments[0] for predicate, arguments in at_start if predicate in SUPPORTS}
        changing = {predicate for predicate, _ in at_start}
        chosen = [operator for operator in domain.operators if _does_more_than_put_down(operator, changing)]
        super().__init__(replace(domain, operators=tuple(chosen)), initial, usable)

    def count_possible_literals(self) -> int:
        return super().count_possible_literals() + len(self._placed)

    def may_atom_hold(self, predicate: str, arguments: tuple[int, ...], truth: bool) -> bool:
        if predicate in FREE:
            return True
        if predicate in SUPPORTS:
            thing = arguments[0]
            return not truth or thing in self._placed or Fact("held", (thing,)) in self.possibly_true
        derived = self.domain.vocabulary.derived_by_name.get(predicate)
        if isinstance(derived, DefinedPredicate) and derived.values is not None:
            return True
        return super().may_atom_hold(predicate, arguments, truth)

    def add(self, fact: Fact) -> None:
        if fact.predicate in SUPPORTS:
            self._placed.add(fact.arguments[0])
        else:
            super().add(fact)


def _does_more_than_put_down(operator: Operator, changing: Collection[str]) -> bool:
    """Return whether an action does more than to put down a held object."""
    held = {check.condition for check in operator.checks}
    for adds, atom in _find_changed_atoms(operator.effects):
        predicate, first = atom.predicate, atom.arguments[0]
        if predicate in FREE or (not adds and (predicate in SUPPORTS or predicate not in changing)):
            continue
        if predicate not in SUPPORTS or f.Atom("held", (first,)) not in held:
            return True
    return False


def _find_changed_atoms(effects: Iterable[Effect]) -> Iterator[tuple[bool, f.Atom]]:
    """Return the atoms that effects add (True) or delete (False)."""
    for effect in effects:
        match effect:
            case Add(atom) | Delete(atom):
                yield isinstance(effect, Add), atom
            case When(_, inner, otherwise):
                yield from _find_changed_atoms((*inner, *otherwise))
            case ForEach(_, _, inner) | Let(_, _, inner):
                yield from _find_changed_atoms(inner)


def _list_required_facts(task: Task) -> Iterator[GroundAtom]:
    """Return the facts that the goals require in any case, and the facts that they forbid."""
    scene = task.scene
    for goal in task.goals:
        for formula, scope, truth in split_conjuncts(Subgoal(goal.formula, {}, True), scene):
            if isinstance(formula, f.Atom):
                indices = (scope.get(t.name, scene.index.get(t.name, -1)) for t in formula.arguments)
                yield GroundAtom(formula.predicate, tuple(indices), truth)


def main() -> int:
    """Print for each task the goals that cannot be reached."""
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
    rules, proved, start = MutualExclusionRules(benchmark.domain), 0, time.process_time()
    for task in chosen:
        possible = _Possible(benchmark.domain, task.initial, task.relevant)
        never = [goal for goal in task.goals if not possible.may_hold(goal.formula, {})]
        shown = "; ".join(str(goal.formula) for goal in never)
        if not never and rules.make_mutual_exclusion_prover(task.initial).are_exclusive(
            _list_required_facts(task)
        ):
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
