"""Plain functions that return Inspect tasks, as Inspect's register requires.

The tasks are those of `eai.run.registry`, which makes a task for every installed benchmark. They have all its
options: ``-T`` sets them.
"""

from __future__ import annotations

from typing import Any

from inspect_ai import Task, task

from eai.run.registry import TASKS  # inspect-evals-lint: ignore[external_dependencies] -- module of eai-bench


@task
def virtualhome_goal_interpretation(**options: Any) -> Task:
    """Translate instructions into goals in VirtualHome."""
    return TASKS["virtualhome_goal_interpretation"](**options)


@task
def virtualhome_subgoal_decomposition(**options: Any) -> Task:
    """Write the states that lead to a goal in VirtualHome."""
    return TASKS["virtualhome_subgoal_decomposition"](**options)


@task
def virtualhome_action_sequencing(**options: Any) -> Task:
    """Write a plan in VirtualHome."""
    return TASKS["virtualhome_action_sequencing"](**options)


@task
def virtualhome_transition_modeling(**options: Any) -> Task:
    """Write operators in PDDL in VirtualHome."""
    return TASKS["virtualhome_transition_modeling"](**options)


@task
def virtualhome_acting(**options: Any) -> Task:
    """Act one action at a time, through tools in VirtualHome."""
    return TASKS["virtualhome_acting"](**options)


@task
def behavior_goal_interpretation(**options: Any) -> Task:
    """Translate instructions into goals in BEHAVIOR."""
    return TASKS["behavior_goal_interpretation"](**options)


@task
def behavior_subgoal_decomposition(**options: Any) -> Task:
    """Write the states that lead to a goal in BEHAVIOR."""
    return TASKS["behavior_subgoal_decomposition"](**options)


@task
def behavior_action_sequencing(**options: Any) -> Task:
    """Write a plan in BEHAVIOR."""
    return TASKS["behavior_action_sequencing"](**options)


@task
def behavior_transition_modeling(**options: Any) -> Task:
    """Write operators in PDDL in BEHAVIOR."""
    return TASKS["behavior_transition_modeling"](**options)


@task
def behavior_acting(**options: Any) -> Task:
    """Act one action at a time, through tools in BEHAVIOR."""
    return TASKS["behavior_acting"](**options)
