"""Roles: what operators are for (movement, taking an object, releasing it, or another change of the world).

From the roles follows which predicates say where things are: how they are put, and what holds them.
"""

from __future__ import annotations

from collections.abc import Iterator

from eai.logic.formula import Term
from eai.planning.effect_schema import EffectSchema, effect_schemas
from eai.world.domain import Domain
from eai.world.effect import ANYTHING
from eai.world.frame import AGENT
from eai.world.operator import Operator, Role


def role_of(operator: Operator) -> Role:
    """The role that is declared, or else what follows from the effects.

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
    return Role.TAKES if _takes(changes) else Role.CHANGE


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


def spatial_predicates(domain: Domain) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The stored predicates that say where things are, in the order of a domain's operators.

    First those that say that something is in a hand, of the agent and it, or of it alone. Then those that say
    that something is at the place where it was put: in, on, under another one.

    What an operator that takes something says of it then, and another operator ends, is that it is held. What
    an operator says of a held thing and another one, and ends that it is held, is where the thing is. What an
    operator says of two things both ways (that they are beside each other) is neither.
    """
    changes = {operator.name: list(effect_schemas(operator)) for operator in domain.operators}
    taking = [operator for operator in domain.operators if role_of(operator) is Role.TAKES]
    taken = [
        each for one in taking for each in changes[one.name] if each.adds and _is_of_parameter(each, one)
    ]
    ended = {each.atom.predicate for of_one in changes.values() for each in of_one if not each.adds}
    held = dict.fromkeys([each.atom.predicate for each in taken if each.atom.predicate in ended])
    handling = [of_one for of_one in changes.values() if any(each.atom.predicate in held for each in of_one)]
    shown = {each.name for each in domain.vocabulary.predicates if each.visible}
    for of_one in handling:
        pairs = set(_pairs(of_one))
        shown -= {predicate for predicate, first, second in pairs if (predicate, second, first) in pairs}
    supports: dict[str, None] = {}
    for of_one in handling:
        released = {e.atom.arguments[-1] for e in of_one if not e.adds and e.atom.predicate in held}
        found = [name for name, first, second in _pairs(of_one) if first in released and second != AGENT]
        supports |= dict.fromkeys(found)
    return tuple([name for name in held if name in shown]), tuple(
        [name for name in supports if name in shown]
    )


def _is_of_parameter(change: EffectSchema, operator: Operator) -> bool:
    """Whether it is said of a parameter alone, or of the agent and one."""
    *before, last = change.atom.arguments or (AGENT,)
    return last in operator.parameters and before in ([], [AGENT])


def _pairs(changes: list[EffectSchema]) -> Iterator[tuple[str, Term, Term]]:
    """The relations that are added."""
    for change in changes:
        if change.adds and len(change.atom.arguments) == 2:
            first, second = change.atom.arguments
            yield change.atom.predicate, first, second
