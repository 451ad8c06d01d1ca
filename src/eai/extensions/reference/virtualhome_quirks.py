"""The VirtualHome domain of eai-eval 1.0.5: defects (quirks) of its simulator, one function for each.

Each function replaces checks or effects of the declared domain and names the place in eai-eval. Together
they turn the domain of `strict` (rules of the paper's text) into the domain of `eai-1.0.5`. The engine knows
nothing of them. If an object has several containers, supports or neighbours, the first of them is the first
in the iteration order of a Python set of ids. An action that aborts in eai-eval fails here with the kind of
fault `UNCATEGORISED`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, reduce, wraps

from eai.benchmarks.virtualhome import operators as o
from eai.benchmarks.virtualhome import predicates as p
from eai.benchmarks.virtualhome.domain import make_domain_with_checks_in_reference_order
from eai.benchmarks.virtualhome.predicates import R, X, Y
from eai.benchmarks.virtualhome.tasks import VirtualHomeTask
from eai.logic.formula import FALSE, Exists, Formula
from eai.world.derived import LookupFunction, LookupPredicate
from eai.world.domain import Domain
from eai.world.effect import Add, ForEach, Let, make_symmetric_effects
from eai.world.fault import FaultKind
from eai.world.frame import AGENT
from eai.world.operator import Check, Operator, additional_step, affordance
from eai.world.relation import iterate_bits
from eai.world.state import State
from eai.world.vocabulary import DerivedPredicate, Vocabulary


@cache
def make_domain_with_all_quirks() -> Domain:
    """Return the VirtualHome domain with all quirks (defects) of eai-eval, and with its order of checks."""
    return reduce(lambda domain, quirk: quirk(domain), QUIRKS, make_domain_with_checks_in_reference_order())


def find_first_related_object_as_mask(state: State, relation: str, source: int, wanted_mask: int) -> int:
    """Return the first wanted object to which a relation leads from an object (``source``).

    The wanted objects and the result are bit masks. The result is 0 if the relation leads to no wanted
    object. First means: in the order of `_list_targets_in_python_set_order`.
    """
    targets = state.relation(relation).row(source) & wanted_mask
    if targets & (targets - 1) == 0:
        return targets
    return next(
        1 << y for y in _list_targets_in_python_set_order(state, relation, source) if targets >> y & 1
    )


def _list_targets_in_python_set_order(state: State, predicate: str, source: int) -> list[int]:
    """Return the objects to which an object has a relation, in the order of a Python set of their ids.

    This order depends on the order of insertion. Objects that actions added to the relation are inserted
    first, then those of the initial scene, both by ascending id. The package eai-eval
    inserts the initial objects in the order of the data set's file. For the objects of all tasks, the first
    object of the result is the same in both orders.
    """
    relation = state.relation(predicate)
    mask = relation.row(source)
    at_start = relation.get_initial_targets(source)
    by_id = {p.get_object_id(state, i): i for i in iterate_bits(mask | at_start)}
    added = sorted(p.get_object_id(state, i) for i in iterate_bits(mask & ~at_start))
    initial = sorted(p.get_object_id(state, i) for i in iterate_bits(at_start))
    return [by_id[i] for i in {*added, *initial} if mask >> by_id[i] & 1]


def _find_room_of_object(state: State, arguments: tuple[int, ...]) -> int:
    """Return the room of an object as a bit mask, 0 for no room (eai-eval: ``_get_room_node``).

    A room is its own room. If an object has several containers, its room is the first container that is a
    room. If an object has one container, the search follows the first container of each container upwards
    until it reaches a room.
    """
    (x,) = arguments
    is_room, inside = state.mask("ROOM"), state.relation("INSIDE")
    if is_room >> x & 1:
        return 1 << x
    containers = inside.row(x)
    if containers & (containers - 1):
        return find_first_related_object_as_mask(state, "INSIDE", x, is_room)
    seen = 0
    while containers and not containers & seen:
        if containers & (containers - 1):
            containers = find_first_related_object_as_mask(state, "INSIDE", x, containers)
        if containers & is_room:
            return containers
        seen |= containers
        x = containers.bit_length() - 1
        containers = inside.row(x)
    return 0


_LOOKUPS: Mapping[str, LookupFunction] = {
    "room_of": _find_room_of_object,
    "lies_on": p.make_lookup_of_places_to_grab_object_from(0, find_first_related_object_as_mask),
    "lies_in": p.make_lookup_of_places_to_grab_object_from(1, find_first_related_object_as_mask),
    "lies_next_to": p.make_lookup_of_places_to_grab_object_from(2, find_first_related_object_as_mask),
}


def _order_lookup_results_like_python_set(derived: DerivedPredicate) -> DerivedPredicate:
    lookup = _LOOKUPS.get(derived.name)
    if lookup is None or not isinstance(derived, LookupPredicate):
        return derived
    return replace(derived, values=lookup, open_in_meaning="which of several objects is the first")


SET_ORDER_VOCABULARY = Vocabulary(
    p.VOCABULARY.predicates, tuple(map(_order_lookup_results_like_python_set, p.VOCABULARY.derived))
)
"""Vocabulary whose lookups return objects in the order of eai-eval: that of a Python set of their ids.

It has the same stored predicates as the vocabulary of `strict` (scoring by the paper's text), so both can use
the same states.
"""


def list_task_objects_in_published_order(task: VirtualHomeTask) -> tuple[int, ...]:
    """Return the relevant objects of a task, in eai-eval's order (``get_symbolic_goal_nl``)."""
    by_id = {p.get_object_id(task.initial, i): i for i in task.relevant}
    return tuple([by_id[i] for i in task.record.relevant_object_ids])


SEARCHED_CONDITIONS: Mapping[Formula, tuple[Formula, ...]] = {
    p.near(X): (p.next_to(AGENT, X),),
    p.near(Y): (p.next_to(AGENT, Y),),
    p.faced(X): (p.facing(AGENT, X),),
    p.hand_free(): (~Exists(Y, p.held(Y)),),
    p.upright(): (~p.sitting(AGENT), ~p.lying(AGENT)),
    ~p.shut_in(X): (p.open_(X),),
    p.lying(AGENT) | p.sitting(AGENT): (p.lying(AGENT),),
    ~p.seat_full(X): (FALSE,),
    ~p.bed_full(X): (FALSE,),
}
"""Maps a failed condition to the conditions that eai-eval looks for in earlier states to find a wrong order.

If a failed condition is not in the mapping, eai-eval looks for this condition itself.
"""


def _apply_to_all_checks(change: Callable[[Operator, Check], Check | None]) -> Callable[[Domain], Domain]:
    """Turn a function that changes a check into a function that changes a domain.

    If the given function returns None, the check is removed.
    """

    @wraps(change)
    def change_checks_of_domain(domain: Domain) -> Domain:
        operators = []
        for operator in domain.operators:
            checks = [change(operator, check) for check in operator.checks]
            operators.append(
                replace(operator, checks=tuple([check for check in checks if check is not None]))
            )
        return domain.replace_operators(*operators)

    return change_checks_of_domain


def order_related_objects_like_python_set(domain: Domain) -> Domain:
    """Order the containers, supports and neighbours of an object as a Python set of ids orders them.

    See ``environment.py``, ``EnvironmentGraph``.
    """
    return replace(domain, vocabulary=SET_ORDER_VOCABULARY)


def leave_held_objects_in_old_room(domain: Domain) -> Domain:
    """Leave held objects in the room that the character leaves, and remove their contents from them.

    See ``execution.py``, ``WalkExecutor``.
    """
    left_behind = (
        *o.make_effects_of_clearing_relations(o.H, p.inside, p.next_to, p.facing),
        *make_symmetric_effects(Add, p.next_to(AGENT, o.H)),
        Let(R, p.room_of(AGENT, R), (Add(p.inside(o.H, R)),)),
    )
    return domain.replace_operators(*o.make_movement_actions((ForEach(o.H, p.held(o.H), left_behind),)))


def make_grab_leave_contents_behind(domain: Domain) -> Domain:
    """Leave the contents of a grabbed object behind, in no container (``GrabExecutor``)."""
    return domain.replace_operators(o.make_grab_action(effects_on_contents=()))


@_apply_to_all_checks
def replace_condition_sought_in_earlier_states(operator: Operator, check: Check) -> Check:
    """Replace the condition that eai-eval looks for in earlier states to find a wrong order.

    Usually, this is the condition that failed: if it held in an earlier state, the action comes in the wrong
    order. For some failed conditions, eai-eval looks for another condition (`SEARCHED_CONDITIONS`). One
    example is ``next_to`` instead of nearness. If an object is in a closed container, eai-eval looks for a
    state in which the object, instead of the container, is open. If the other condition is never true, the
    failure never counts as wrong order. See ``execution.py``, ``update_missing_precond``.
    """
    (wanted,) = (check.condition,) if check.history_conditions is None else check.history_conditions
    sought = SEARCHED_CONDITIONS.get(wanted)
    if sought is None and operator.name == "CUT" and check.fault is FaultKind.MISSING_STEP:
        sought = (FALSE,)  # CUT checks that a hand holds a knife
    return check if sought is None else replace(check, history_conditions=sought)


@_apply_to_all_checks
def report_unplugged_device_as_additional_step(operator: Operator, check: Check) -> Check:
    """Make switching on an unplugged device an additional step, not a missing step (``SwitchExecutor``)."""
    unplugged = operator.name == "SWITCHON" and check.condition == ~p.plugged_out(X)
    return replace(check, fault=FaultKind.ADDITIONAL_STEP) if unplugged else check


@_apply_to_all_checks
def make_opening_running_device_additional_step(operator: Operator, check: Check) -> Check:
    """Make the opening of a running device, which fails, an additional step instead of a missing step.

    See ``execution.py``, ``OpenExecutor``.
    """
    return replace(check, fault=FaultKind.ADDITIONAL_STEP) if check == o.NOT_RUNNING else check


@_apply_to_all_checks
def remove_check_that_object_can_change_state(operator: Operator, check: Check) -> Check | None:
    """Remove the check that an object has a state that can change, such as open or closed.

    None removes a check; other checks are returned unchanged. For example, an object that is neither open nor
    closed cannot be opened. The declared domain checks that the object is open or closed, and reports an
    affordance error. Without this check, a later check fails: that the object is closed. It reports an
    additional step, as eai-eval does. See ``execution.py``, ``OpenExecutor``, ``SwitchExecutor``,
    ``PlugExecutor``.
    """
    return None if check in (o.OPEN_OR_CLOSED, o.ON_OR_OFF, o.PLUGGED_IN_OR_OUT) else check


@_apply_to_all_checks
def report_second_grab_as_additional_step(operator: Operator, check: Check) -> Check:
    """Report a second grab of an object as an additional step, even after its release (``GrabExecutor``)."""
    return additional_step(~p.taken(X), "{x} has been grabbed already") if check == o.NOT_HELD else check


@_apply_to_all_checks
def report_repeated_sitting_as_additional_step(operator: Operator, check: Check) -> Check | None:
    """Make sitting down an additional step if the character already sits anywhere; the same for lying down.

    The declared domain has two checks for sitting. `NOT_SEATED` fails if the character sits on the same seat,
    which is an additional step. `NOT_SEATED_ELSEWHERE` fails if it sits on another seat, which is a missing
    step. Here the first check fails in both cases, and the second is removed (None). `NOT_IN_BED` and
    `NOT_IN_BED_ELSEWHERE` change in the same way. See ``SitExecutor`` and ``LieExecutor``.
    """
    if check in (o.NOT_SEATED_ELSEWHERE, o.NOT_IN_BED_ELSEWHERE):
        return None
    if check == o.NOT_SEATED:
        return additional_step(~p.sitting(AGENT), "the character sits already")
    return additional_step(~p.lying(AGENT), "the character lies already") if check == o.NOT_IN_BED else check


@_apply_to_all_checks
def report_closed_container_as_affordance_error(operator: Operator, check: Check) -> Check:
    """Make putting an object into a closed container an affordance error.

    See ``execution.py``, ``_check_puttable``.
    """
    closed = operator.name == "PUTIN" and check.condition == (~p.can_open(Y) | p.open_(Y))
    return replace(check, fault=FaultKind.AFFORDANCE) if closed else check


def make_impossible_put_back_succeed(domain: Domain) -> Domain:
    """Let an impossible PUTOBJBACK succeed without an effect (``PutBackExecutor``)."""
    possible_at = {
        p.taken_from_inside: p.held(X) & p.near(Y) & (~p.can_open(Y) | p.open_(Y)),
        p.taken_from_top_of: p.held(X) & p.near(Y),
        p.taken_from_next_to: p.held(X) & p.near(Y),
    }
    has_record = replace(affordance(p.taken(X), "{x} was not grabbed"), fault=FaultKind.UNCATEGORISED)
    effects = tuple(
        Let(Y, memory(X, Y) & possible_at[memory], o.make_put_effects(relation))
        for memory, _, relation in o.ORIGINS
    )
    return domain.replace_operators(Operator("PUTOBJBACK", (X,), (has_record,), effects))


def add_failing_actions_lookat_short_and_long(domain: Domain) -> Domain:
    """Add the actions LOOKAT_SHORT and LOOKAT_LONG, which always fail.

    The package eai-eval accepts them in plans, but aborts when it executes them (``execution.py``,
    ``UnknownExecutor``).
    """
    undefined = Check(FALSE, FaultKind.UNCATEGORISED, "the reference cannot execute this action")
    return domain.replace_operators(
        *(Operator(name, (X,), (undefined,), ()) for name in ("LOOKAT_SHORT", "LOOKAT_LONG"))
    )


@_apply_to_all_checks
def report_walk_to_object_in_no_room_as_abort(operator: Operator, check: Check) -> Check:
    """Report an uncategorised error if the target of a walk is in no room, because eai-eval aborts there.

    See ``execution.py``, ``WalkExecutor``.
    """
    return replace(check, fault=FaultKind.UNCATEGORISED) if check.reason == o.SOMEWHERE.reason else check


QUIRKS: tuple[Callable[[Domain], Domain], ...] = (
    order_related_objects_like_python_set,
    leave_held_objects_in_old_room,
    make_grab_leave_contents_behind,
    replace_condition_sought_in_earlier_states,
    report_unplugged_device_as_additional_step,
    make_opening_running_device_additional_step,
    remove_check_that_object_can_change_state,
    report_second_grab_as_additional_step,
    report_repeated_sitting_as_additional_step,
    report_closed_container_as_affordance_error,
    make_impossible_put_back_succeed,
    add_failing_actions_lookat_short_and_long,
    report_walk_to_object_in_no_room_as_abort,
)
"""All quirks (functions that give the domain a defect of eai-eval), in the order of their application."""
