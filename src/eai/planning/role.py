"""What operators are for: movement, taking an object, letting go of it, or a deed."""

from __future__ import annotations

from eai.planning.effect_schema import EffectSchema, effect_schemas
from eai.world.effect import ANYTHING
from eai.world.frame import AGENT
from eai.world.operator import Operator, Role


def role_of(operator: Operator) -> Role:
    """The role that is declared, or else what the effects tell.

    Movement changes what is true of the agent alone, and relations in which the agent stands to something
    else afterwards instead of what it was (``at(agent, *)`` is deleted and ``at(agent, x)`` added). What the
    agent takes along changes in the same relations. What only brings the agent into a relation with an object
    (``holds(agent, x)`` is added), and may end those of the object, takes it.
    """
    if operator.role is not None:
        return operator.role
    changes = list(effect_schemas(operator))
    if _is_movement(changes):
        return Role.MOVEMENT
    return Role.TAKES if _takes(changes) else Role.DEED


def _is_movement(changes: list[EffectSchema]) -> bool:
    own = {change.atom.predicate for change in changes if change.atom.arguments == (AGENT,)}
    left = {change.atom.predicate for change in changes if _is_left(change)}
    related = [change for change in changes if len(change.atom.arguments) == 2]
    taken = {change.atom.predicate for change in related if change.adds and AGENT in change.atom.arguments}
    return bool(changes) and all(change.atom.predicate in own | (left & taken) for change in changes)


def _is_left(change: EffectSchema) -> bool:
    """Whether a change ends the agent's relation to whatever it is, and not to an argument only."""
    if change.adds or AGENT not in change.atom.arguments or len(change.atom.arguments) != 2:
        return False
    (other,) = [term for term in change.atom.arguments if term != AGENT] or [AGENT]
    return other == ANYTHING or other not in change.operator.parameters


def _takes(changes: list[EffectSchema]) -> bool:
    """Whether all that is added relates the agent to an argument; and something is."""
    added = [change for change in changes if change.adds]
    return bool(added) and all(
        change.atom.arguments[:1] == (AGENT,) and change.atom.arguments[1:] == change.operator.parameters
        for change in added
    )
