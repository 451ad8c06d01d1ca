"""Roles of operators: movement, taking an object, releasing an object, or another change of the world.

The roles reveal which predicates describe the places of objects, and which describe held objects.
"""

from __future__ import annotations

from collections.abc import Iterator

from eai.logic.formula import Term
from eai.planning.effect_schema import EffectSchema, make_effect_schemas
from eai.world.domain import Domain
from eai.world.effect import ANYTHING
from eai.world.frame import AGENT
from eai.world.operator import Operator, OperatorRole


def infer_operator_role(operator: Operator) -> OperatorRole:
    """Return the declared role of an operator, or infer the role from its effects.

    A movement changes only facts about the agent alone, and relations between the agent and the objects that
    it leaves or reaches. The operator deletes such a relation to any object (``at(agent, *)``) and adds it to
    one (``at(agent, x)``). The same relations may also change for objects that the agent carries.

    An operator takes an object if it adds only a relation of the agent to the object, such as ``holds(agent,
    x)``. It may also delete relations of the object.
    """
    if operator.role is not None:
        return operator.role
    changes = list(make_effect_schemas(operator))
    if _is_movement(changes):
        return OperatorRole.MOVEMENT
    return OperatorRole.TAKES if _only_adds_agent_relations(changes) else OperatorRole.CHANGE


def _is_movement(changes: list[EffectSchema]) -> bool:
    own_predicates = {change.atom.predicate for change in changes if change.atom.arguments == (AGENT,)}
    left_predicates = {
        change.atom.predicate for change in changes if _deletes_agent_relation_to_every_object(change)
    }
    binary_changes = [change for change in changes if len(change.atom.arguments) == 2]
    added_predicates = {
        change.atom.predicate for change in binary_changes if change.adds and AGENT in change.atom.arguments
    }
    return bool(changes) and all(
        change.atom.predicate in own_predicates | (left_predicates & added_predicates) for change in changes
    )


def _deletes_agent_relation_to_every_object(effect: EffectSchema) -> bool:
    """Whether an effect deletes a relation of the agent to any object, not only to a parameter."""
    if effect.adds or AGENT not in effect.atom.arguments or len(effect.atom.arguments) != 2:
        return False
    (other,) = [term for term in effect.atom.arguments if term != AGENT] or [AGENT]
    return other == ANYTHING or other not in effect.operator.parameters


def _only_adds_agent_relations(changes: list[EffectSchema]) -> bool:
    """Whether an operator adds only facts that relate the agent to arguments of the operator."""
    added = [change for change in changes if change.adds]
    return bool(added) and all(
        change.atom.arguments[:1] == (AGENT,) and change.atom.arguments[1:] == change.operator.parameters
        for change in added
    )


def find_holding_and_location_predicates(domain: Domain) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the stored predicates that describe places, in the order of a domain's operators.

    The first tuple has the predicates for objects in a hand, with or without the agent as first argument. The
    second tuple has the predicates for objects in, on or under another object.

    A predicate describes held objects if an operator that takes an object adds its facts, and another
    operator deletes its facts. A predicate describes a place if an operator that releases a held object adds
    a fact of the predicate about this object and another object. Symmetric predicates ("beside each other"),
    whose facts an operator adds in both directions, are left out.
    """
    changes = {operator.name: list(make_effect_schemas(operator)) for operator in domain.operators}
    takers = [
        operator for operator in domain.operators if infer_operator_role(operator) is OperatorRole.TAKES
    ]
    added = [
        change
        for operator in takers
        for change in changes[operator.name]
        if change.adds and _is_about_one_parameter_and_maybe_agent(change, operator)
    ]
    deleted = {
        change.atom.predicate
        for operator_changes in changes.values()
        for change in operator_changes
        if not change.adds
    }
    held = dict.fromkeys([change.atom.predicate for change in added if change.atom.predicate in deleted])
    handling = [
        operator_changes
        for operator_changes in changes.values()
        if any(change.atom.predicate in held for change in operator_changes)
    ]
    visible = {change.name for change in domain.vocabulary.predicates if change.visible}
    for operator_changes in handling:
        pairs = set(_find_added_relations(operator_changes))
        visible -= {predicate for predicate, first, second in pairs if (predicate, second, first) in pairs}
    supports: dict[str, None] = {}
    for operator_changes in handling:
        released = {e.atom.arguments[-1] for e in operator_changes if not e.adds and e.atom.predicate in held}
        names = [
            name
            for name, first, second in _find_added_relations(operator_changes)
            if first in released and second != AGENT
        ]
        supports |= dict.fromkeys(names)
    return tuple([name for name in held if name in visible]), tuple(
        [name for name in supports if name in visible]
    )


def _is_about_one_parameter_and_maybe_agent(effect: EffectSchema, operator: Operator) -> bool:
    *before, last = effect.atom.arguments or (AGENT,)
    return last in operator.parameters and before in ([], [AGENT])


def _find_added_relations(changes: list[EffectSchema]) -> Iterator[tuple[str, Term, Term]]:
    for change in changes:
        if change.adds and len(change.atom.arguments) == 2:
            first, second = change.atom.arguments
            yield change.atom.predicate, first, second
