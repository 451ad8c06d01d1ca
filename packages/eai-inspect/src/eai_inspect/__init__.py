"""The tasks of eai for Inspect's register."""

from eai_inspect.tasks import (
    behavior_acting,
    behavior_action_sequencing,
    behavior_goal_interpretation,
    behavior_subgoal_decomposition,
    behavior_transition_modeling,
    virtualhome_acting,
    virtualhome_action_sequencing,
    virtualhome_goal_interpretation,
    virtualhome_subgoal_decomposition,
    virtualhome_transition_modeling,
)

__all__ = [
    "behavior_acting",
    "behavior_action_sequencing",
    "behavior_goal_interpretation",
    "behavior_subgoal_decomposition",
    "behavior_transition_modeling",
    "virtualhome_acting",
    "virtualhome_action_sequencing",
    "virtualhome_goal_interpretation",
    "virtualhome_subgoal_decomposition",
    "virtualhome_transition_modeling",
]
