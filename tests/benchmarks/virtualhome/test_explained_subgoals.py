"""Explanations report the step at which each part of a temporal goal is met."""

from __future__ import annotations

from collections.abc import Mapping

from eai.abilities.explanation import EXECUTED, GoalPartReport, VerdictExplanation
from eai.abilities.subgoal_decomposition.scorer import SubgoalDecompositionScorer
from eai.benchmarks.virtualhome.tasks import VirtualHomeTasks
from eai.logic.formula import Formula, Occurs, Then
from eai.logic.traversal import walk_subformulas
from eai.tasks.goal_test import StateTest
from eai.world.action import Action
from eai.world.execution import attempt_action
from eai.world.history import History
from eai.world.state import State
from oracle import Oracle
from subgoal_scorers import virtualhome_subgoals


def test_each_part_of_a_temporal_goal_is_met_at_its_reported_step(
    oracle: Oracle, virtualhome_tasks: VirtualHomeTasks
) -> None:
    wrong, reported = {}, 0
    scorer_of = virtualhome_subgoals()
    for row in oracle("virtualhome", "subgoal_decomposition", "gpt-4o-2024-05-13")["tasks"][::5]:
        scorer = scorer_of(virtualhome_tasks[row["id"].partition("@")[0]])
        explanation, goal = scorer.explain(row["llm_output"]), scorer.temporal_goal
        if goal is None or not explanation.parts:
            continue
        states = states_by_step(scorer, explanation)
        for part, report in zip(
            goal.parts if isinstance(goal, Then) else (goal,), explanation.parts, strict=True
        ):
            if report.first_met_time_text:
                reported += 1
                if not is_met(part, report, explanation, states):
                    wrong[row["id"]] = (report.part, report.first_met_time_text)
    assert wrong == {}
    assert reported >= 60


def states_by_step(scorer: SubgoalDecompositionScorer, explanation: VerdictExplanation) -> dict[int, State]:
    """Return the states after the executed steps by step number; 0 is the initial state."""
    state = scorer.task.initial
    states = {0: state}
    for number, step in enumerate(explanation.steps, 1):
        if step.outcome == EXECUTED:
            name, _, names = step.action.removesuffix(")").partition("(")
            objects = tuple(scorer.task.scene.index[word] for word in names.split(", ") if word)
            state = attempt_action(scorer.domain, History(state), Action(name, objects))
            assert isinstance(state, State)
            states[number] = state
    return states


def is_met(
    part: Formula, report: GoalPartReport, explanation: VerdictExplanation, states: Mapping[int, State]
) -> bool:
    """Whether the reported step meets a part of the goal, by its state or by its action."""
    actions = [formula.action for formula in walk_subformulas(part) if isinstance(formula, Occurs)]
    if not actions:
        number = report.met_after
        at = f"after step {number}" if number else "at the start"
        return (
            report.first_met_time_text == at
            and number in states
            and StateTest(part, states[0].scene)(states[number])
        )
    step = explanation.steps[int(report.first_met_time_text.removeprefix("at step ")) - 1]
    return step.outcome == EXECUTED and step.action.partition("(")[0] in actions
