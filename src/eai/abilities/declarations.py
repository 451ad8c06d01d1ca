"""The paper's four abilities by their names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from eai.abilities.action_sequencing.declaration import ACTION_SEQUENCING
from eai.abilities.declaration import AbilityDeclaration
from eai.abilities.goal_interpretation.declaration import GOAL_INTERPRETATION
from eai.abilities.protocol import Ability
from eai.abilities.subgoal_decomposition.declaration import SUBGOAL_DECOMPOSITION
from eai.abilities.transition_modeling.declaration import TRANSITION_MODELING

DECLARATIONS: Mapping[Ability, AbilityDeclaration[Any]] = {
    declared.ability: declared
    for declared in (GOAL_INTERPRETATION, SUBGOAL_DECOMPOSITION, ACTION_SEQUENCING, TRANSITION_MODELING)
}
"""What each ability declares, in the order of `Ability`."""
