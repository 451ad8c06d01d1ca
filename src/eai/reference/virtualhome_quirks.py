"""The VirtualHome domain as eai-eval 1.0.5 has it: where its simulator deviates from what it is meant to do.

Each quirk replaces checks or effects of the declaration; together they turn the domain of protocol `strict`
into that of `eai-1.0.5`. The engine knows nothing of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, reduce

from eai.households.virtualhome import operators as o
from eai.households.virtualhome import predicates as p
from eai.households.virtualhome.domain import as_declared
from eai.households.virtualhome.predicates import R, X, Y
from eai.logic.formula import FALSE, Exists, Formula
from eai.reference.quirk import Quirk
from eai.reference.virtualhome_order import IN_SLOT_ORDER
from eai.world.domain import Domain
from eai.world.effect import Add, ForEach, Let, both_ways
from eai.world.fault import FaultKind
from eai.world.frame import AGENT
from eai.world.operator import Check, Operator, additional, affordance


@cache
def as_in_reference() -> Domain:
    """The reference's order of checks and all of its quirks."""
    return reduce(lambda domain, quirk: quirk.apply(domain), QUIRKS, as_declared())


SOUGHT: Mapping[Formula, tuple[Formula, ...]] = {
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
"""What the reference looks for in the past when a condition fails, where it is not the condition."""


def _change_checks(change: Callable[[Operator, Check], Check]) -> Callable[[Domain], Domain]:
    """A change of the domain that is a change of each single check."""

    def apply(domain: Domain) -> Domain:
        return domain.with_operators(
            *(replace(op, checks=tuple(change(op, check) for check in op.checks)) for op in domain.operators)
        )

    return apply


def _seek_what_the_reference_seeks(operator: Operator, check: Check) -> Check:
    (wanted,) = (check.condition,) if check.sought is None else check.sought
    sought = SOUGHT.get(wanted)
    if sought is None and operator.name == "CUT" and check.fault is FaultKind.MISSING_STEP:
        sought = (FALSE,)  # the knife that is not in the hand
    return check if sought is None else replace(check, sought=sought)


def _unplugged_is_additional(operator: Operator, check: Check) -> Check:
    unplugged = operator.name == "SWITCHON" and check.condition == ~p.plugged_out(X)
    return replace(check, fault=FaultKind.ADDITIONAL_STEP) if unplugged else check


def _instead(checks: Mapping[Check, Check | None]) -> Callable[[Domain], Domain]:
    """A change of the domain that puts other checks in the place of some, or none (None)."""

    def changed(operator: Operator) -> Operator:
        kept = (checks.get(check, check) for check in operator.checks)
        return replace(operator, checks=tuple(check for check in kept if check is not None))

    return lambda domain: domain.with_operators(*map(changed, domain.operators))


def _closed_is_affordance(operator: Operator, check: Check) -> Check:
    closed = operator.name == "PUTIN" and check.condition == (~p.can_open(Y) | p.open_(Y))
    return replace(check, fault=FaultKind.AFFORDANCE) if closed else check


def _no_room_is_undefined(operator: Operator, check: Check) -> Check:
    return replace(check, fault=FaultKind.UNCATEGORISED) if check.reason == o.SOMEWHERE.reason else check


def _held_objects_stay_behind(domain: Domain) -> Domain:
    left_behind = (
        *o.cut_loose(o.H, p.inside, p.next_to, p.facing),
        *both_ways(Add, p.next_to(AGENT, o.H)),
        Let(R, p.room_of(AGENT, R), (Add(p.inside(o.H, R)),)),
    )
    return domain.with_operators(*o.moving((ForEach(o.H, p.held(o.H), left_behind),)))


def _put_back_does_nothing_instead_of_failing(domain: Domain) -> Domain:
    possible_at = {
        p.taken_from_inside: p.held(X) & p.near(Y) & (~p.can_open(Y) | p.open_(Y)),
        p.taken_from_top_of: p.held(X) & p.near(Y),
        p.taken_from_next_to: p.held(X) & p.near(Y),
    }
    has_record = replace(affordance(p.taken(X), "{x} was not grabbed"), fault=FaultKind.UNCATEGORISED)
    effects = tuple(
        Let(Y, memory(X, Y) & possible_at[memory], o.put(relation)) for memory, _, relation in o.ORIGINS
    )
    return domain.with_operators(Operator("PUTOBJBACK", (X,), (has_record,), effects))


def _some_looks_are_not_implemented(domain: Domain) -> Domain:
    undefined = Check(FALSE, FaultKind.UNCATEGORISED, "the reference cannot execute this action")
    return domain.with_operators(
        *(Operator(name, (X,), (undefined,), ()) for name in ("LOOKAT_SHORT", "LOOKAT_LONG"))
    )


QUIRKS: tuple[Quirk, ...] = (
    Quirk(
        "first_of_a_hash_table",
        "environment.py EnvironmentGraph",
        "of several things that an object is in, on or next to, the first is that of a Python set of ids",
        lambda domain: replace(domain, vocabulary=IN_SLOT_ORDER),
    ),
    Quirk(
        "held_objects_stay_behind",
        "execution.py WalkExecutor",
        "what the character holds is put into the room that it comes from, and nothing is in it any more",
        _held_objects_stay_behind,
    ),
    Quirk(
        "grabbing_empties",
        "execution.py GrabExecutor",
        "what is in an object, or on it, is left behind when it is grabbed, and in nothing",
        lambda domain: domain.with_operators(o.grab(kept=())),
    ),
    Quirk(
        "sought_is_not_the_condition",
        "execution.py update_missing_precond",
        "the order test looks for direct edges, or OPEN of the object instead of its container, or nothing",
        _change_checks(_seek_what_the_reference_seeks),
    ),
    Quirk(
        "unplugged_is_additional",
        "execution.py SwitchExecutor",
        "switching on an unplugged device is an additional step, not a missing one",
        _change_checks(_unplugged_is_additional),
    ),
    Quirk(
        "running_is_additional",
        "execution.py OpenExecutor",
        "opening a device that is switched on is an additional step, not a missing one",
        _instead({o.NOT_RUNNING: replace(o.NOT_RUNNING, fault=FaultKind.ADDITIONAL_STEP)}),
    ),
    Quirk(
        "no_state_is_additional",
        "execution.py OpenExecutor, SwitchExecutor, PlugExecutor",
        "changing a state that the object does not have is an additional step, not an affordance error",
        _instead(dict.fromkeys((o.OPEN_OR_CLOSED, o.ON_OR_OFF, o.PLUGGED_IN_OR_OUT))),
    ),
    Quirk(
        "grabbed_once_is_additional",
        "execution.py GrabExecutor",
        "grabbing what has been grabbed and is in no hand any more is an additional step",
        _instead({o.NOT_HELD: additional(~p.taken(X), "{x} has been grabbed already")}),
    ),
    Quirk(
        "seated_elsewhere_is_additional",
        "execution.py SitExecutor, LieExecutor",
        "sitting or lying down somewhere else is an additional step",
        _instead(
            {
                o.NOT_SEATED: additional(~p.sitting(AGENT), "the character sits already"),
                o.NOT_SEATED_ELSEWHERE: None,
                o.NOT_IN_BED: additional(~p.lying(AGENT), "the character lies already"),
                o.NOT_IN_BED_ELSEWHERE: None,
            }
        ),
    ),
    Quirk(
        "closed_container_is_affordance",
        "execution.py _check_puttable",
        "putting something into a closed container is an affordance error, not a missing step",
        _change_checks(_closed_is_affordance),
    ),
    Quirk(
        "put_back_never_fails",
        "execution.py PutBackExecutor",
        "PUTOBJBACK succeeds without doing anything where it is not possible",
        _put_back_does_nothing_instead_of_failing,
    ),
    Quirk(
        "looks_not_implemented",
        "execution.py UnknownExecutor",
        "LOOKAT_SHORT and LOOKAT_LONG abort the run",
        _some_looks_are_not_implemented,
    ),
    Quirk(
        "no_room_aborts",
        "execution.py WalkExecutor",
        "walking to an object that is in no room aborts the run",
        _change_checks(_no_room_is_undefined),
    ),
)
