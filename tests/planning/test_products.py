"""Fewest edits compared with Fast Downward: plans with faults, and the few actions that edits may insert.

Each case is a planning problem: the product of the plan and the world. At a position of the plan, its step is
kept (cost 0), left out or replaced, or another action is inserted before it (cost 1 each). A needless step
may be kept without effect. A plan that A* finds with the blind heuristic costs as many edits as are needed.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache, partial
from itertools import count, islice
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

import pytest

import eai.logic.formula as f
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.logic.rewriting import substitute_terms
from eai.pddl.export import ExportedProblem, export_domain_and_problem
from eai.pddl.fast_downward import FastDownward
from eai.pddl.model import map_effect
from eai.pddl.writer import write_domain, write_effect, write_formula, write_problem
from eai.planning.search import SearchEffort
from eai.tasks.task import GoalKind, Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.fault import FaultKind
from eai.world.operator import Operator, missing_step
from eai.world.relation import iterate_bits, make_mask
from planning.repair.test_search import draw, restricted
from sweeps import swept

SKIPPED = "_SKIPPED_"
"""Suffix of operators without effects that stand for a skipped, needless action."""

PLACES = ("INSIDE", "ONTOP", "HOLDS_RH", "HOLDS_LH", "inside", "ontop", "onfloor", "holds_lh", "holds_rh")
"""The relations for the place of a thing, and for the things that the agent holds."""


@cache
def with_skips(domain: Domain) -> Domain:
    """Return the domain with an operator without effects for each check that makes an action needless."""
    return domain.replace_operators(*[skip for operator in domain.operators for skip in _skips(operator)])


def _skips(operator: Operator) -> Iterator[Operator]:
    for number, check in enumerate(operator.checks):
        if check.fault is FaultKind.ADDITIONAL_STEP:
            checks = (*operator.checks[:number], missing_step(f.Not(check.condition), "it is needed"))
            yield replace(
                operator, name=f"{operator.name}{SKIPPED}{number}", checks=checks, effects=(), alternatives=()
            )


def objects_of(task: Task, actions: Sequence[Action]) -> set[int]:
    """Return the objects of a task and of some actions, with everything that they are in, on or held by."""
    found = {*task.relevant, *task.find_objects_named_in_goals(task.goals)}.union(
        *[action.arguments for action in actions]
    )
    found |= set() if task.scene.agent is None else {task.scene.agent}
    pending = [*found]
    placed = [name for name in PLACES if name in task.scene.vocabulary.binary_slots]
    while pending:
        thing = pending.pop()
        beside = {place for name in placed for place in iterate_bits(task.initial.relation(name).row(thing))}
        pending += beside - found
        found |= beside
    return found


def product_of(
    task: Task, domain: Domain, plan: Sequence[Action | None], actions: Sequence[Action]
) -> tuple[str, str]:
    """Return the domain and the problem of a case as PDDL."""
    world = with_skips(domain)
    about = objects_of(task, [step for step in (*plan, *actions) if step is not None])
    exported = export_domain_and_problem(
        world, task.initial, [goal.formula for goal in task.goals], objects=make_mask(about)
    )
    written = [*_edits(exported, plan, actions), *_kept(exported, world, plan)]
    header = replace(
        exported.domain, constants=(*exported.domain.constants, *exported.problem.objects), actions=()
    )
    header = write_domain(header).rstrip().removesuffix(")")
    places = " ".join(f"(at-{place})" for place in range(len(plan) + 1))
    header = header.replace("(:predicates", f"(:predicates {places}", 1)
    before, mark, axioms = header.partition("(:derived")
    domain = "\n".join([before, "(:functions (total-cost) - number)", mark + axioms, *written, ")"])
    goal = f.And((exported.problem.goal, f.Atom(f"at-{len(plan)}")))
    begins = replace(
        exported.problem, objects=(), initial=(*exported.problem.initial, f.Atom("at-0")), goal=goal
    )
    problem = write_problem(begins).replace("(:init", "(:init (= (total-cost) 0)", 1).rstrip()
    return domain, f"{problem.removesuffix(')')}(:metric minimize (total-cost)))"


def _edits(
    exported: ExportedProblem, plan: Sequence[Action | None], actions: Sequence[Action]
) -> Iterator[str]:
    for place in range(len(plan) + 1):
        yield from (_move(exported, place, place, action, 1) for action in actions)
        if place < len(plan):
            yield _move(exported, place, place + 1, None, 1)
            yield from (_move(exported, place, place + 1, action, 1) for action in actions)


def _kept(exported: ExportedProblem, world: Domain, plan: Sequence[Action | None]) -> Iterator[str]:
    for place, action in enumerate(plan):
        if action is not None:
            names = [name for name in world.operator_arities if name.partition(SKIPPED)[0] == action.operator]
            kept = [action._replace(operator=name) for name in names]
            yield from (_move(exported, place, place + 1, each, 0) for each in kept)


NUMBERS = count()
"""Numbers of actions, which make their names unique."""


def _move(exported: ExportedProblem, place: int, after: int, taken: Action | None, cost: int) -> str:
    """Return one move from a position of the plan to another, by an action or without one."""
    moved = "" if after == place else f" (not (at-{place})) (at-{after})"
    condition, effect = "(and)", "(and)"
    if taken is not None:
        step = exported.to_pddl_step(taken)
        action = next(each for each in exported.domain.actions if each.name == step.action)
        things = dict(zip(action.parameters, map(f.Constant, step.arguments), strict=True))
        bound = partial(substitute_terms, values=things)
        condition = write_formula(bound(action.precondition))
        effect = write_effect(map_effect(action.effect, bound, bound))
    return (
        f"(:action move-{next(NUMBERS)} :parameters () :precondition (and (at-{place}) {condition})"
        f" :effect (and {effect}{moved} (increase (total-cost) {cost})))"
    )


def cheapest(domain: str, problem: str) -> int | None:
    """Return the cost of a cheapest plan, or None if no plan exists."""
    binaries = FastDownward.find_installed().binaries
    environment = {**os.environ, "PYTHONPATH": str(binaries), "PYTHONHASHSEED": "0"}
    run = partial(subprocess.run, env=environment, capture_output=True, text=True, timeout=60, check=True)
    with TemporaryDirectory() as folder:
        Path(folder, "domain.pddl").write_text(domain)
        Path(folder, "problem.pddl").write_text(problem)
        run([sys.executable, "-m", "fast_downward.translate", "domain.pddl", "problem.pddl"], cwd=folder)
        with Path(folder, "output.sas").open() as source:
            found = run([str(binaries / "downward"), "--search", "astar(blind())"], cwd=folder, stdin=source)
    cost = re.search(r"Plan cost: (\d+)", found.stdout)
    return int(cost[1]) if cost else None


def can_be_written(
    scorer: ActionSequencingScorer, plan: Sequence[Action | None], actions: Sequence[Action]
) -> bool:
    """Whether a case is small and has a PDDL form: unordered goals, and no operator with tries."""
    tries = {operator.name for operator in scorer.domain.operators if operator.alternatives}
    goals, steps = scorer.task.goals, [step for step in plan if step is not None]
    return (
        len(plan) <= 5
        and not any(goal.is_temporal for goal in goals)
        and sum(goal.kind is GoalKind.ACTION for goal in goals) < 2
        and tries.isdisjoint(step.operator for step in steps)
        and len(objects_of(scorer.task, [*steps, *actions])) <= 12
    )


@pytest.mark.skipif(not FastDownward.is_installed(), reason="Fast Downward is not installed")
@pytest.mark.parametrize(("name", "number"), [("behavior", 3), *swept(("behavior", 40), ("virtualhome", 6))])
def test_the_fewest_edits_equal_the_cost_of_a_cheapest_product_plan(name: str, number: int) -> None:
    random, seen = Random(11), set()
    cases = (draw(name, random) for _ in count())
    for scorer, plan, actions in islice((case for case in cases if can_be_written(*case)), number):
        at_least, edits = restricted(scorer, plan, actions).repair(plan, SearchEffort(100_000))
        assert edits is not None
        assert len(edits) == at_least
        cost = cheapest(*product_of(scorer.task, scorer.domain, plan, actions))
        assert cost == at_least, (scorer.task.id, plan, actions)
        seen.add(cost)
    assert len(seen) > 1
