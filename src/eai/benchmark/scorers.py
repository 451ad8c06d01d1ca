"""How the suites of a benchmark are opened: one scorer an ability, over tasks, declaration and notation.

Each scorer is imported where it is made: scoring plans loads no planner of operators.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from eai.abilities.protocol import Ability
from eai.abilities.scorer import Scorer
from eai.abilities.task import Task
from eai.benchmark.benchmark import Benchmark, Form, Opened
from eai.tasks.source import Source


def open_scorers(benchmark: Benchmark, ability: Ability, form: Form, source: Source) -> Opened:
    """The suite of an ability as the paper has it (protocol ``strict``)."""
    if ability is Ability.TRANSITION_MODELING:
        return _transition_modeling(benchmark, source)
    tasks = benchmark.tasks_for(ability, source)
    make = _MAKERS[ability](benchmark)
    return Opened(tuple(tasks), tasks.sha256, lambda task_id: make(tasks[task_id]))


def _action_sequencing(benchmark: Benchmark) -> Callable[[Task], Scorer]:
    from eai.abilities.action_sequencing.scorer import ActionSequencing

    return partial(ActionSequencing, domain=benchmark.domain, notation=benchmark.plans)


def _goal_interpretation(benchmark: Benchmark) -> Callable[[Task], Scorer]:
    from eai.abilities.goal_interpretation.scorer import GoalInterpretation

    return partial(GoalInterpretation, domain=benchmark.domain, notation=benchmark.goals)


def _subgoal_decomposition(benchmark: Benchmark) -> Callable[[Task], Scorer]:
    from eai.abilities.subgoal_decomposition.refinement import Refinement
    from eai.abilities.subgoal_decomposition.scorer import SubgoalDecomposition

    domain = benchmark.subgoal_domain or benchmark.domain
    return partial(
        SubgoalDecomposition, domain=domain, notation=benchmark.subgoals, refinement=Refinement(domain)
    )


def _transition_modeling(benchmark: Benchmark, source: Source) -> Opened:
    from eai.abilities.transition_modeling.planners import make_planner
    from eai.abilities.transition_modeling.rules import PaperRules
    from eai.abilities.transition_modeling.scorer import TransitionModeling

    tasks = benchmark.operators(source)
    rules = PaperRules.with_planner(make_planner(source.planner, benchmark.planner_seconds, source.terms))
    return Opened(tuple(tasks), tasks.sha256, lambda task_id: TransitionModeling(tasks[task_id], rules))


_MAKERS: Mapping[Ability, Callable[[Benchmark], Callable[[Task], Scorer]]] = {
    Ability.ACTION_SEQUENCING: _action_sequencing,
    Ability.GOAL_INTERPRETATION: _goal_interpretation,
    Ability.SUBGOAL_DECOMPOSITION: _subgoal_decomposition,
}
