"""Merits: what an answer may be paid for, as its verdict says; `eai.scoring.reward` says by which of them.

Goals gained, or parts that are right: all lies between 0 and 1.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from eai.world.fault import FaultKind

if TYPE_CHECKING:
    from eai.abilities.verdict import ErrorReport


@dataclass(frozen=True, slots=True)
class Merit:
    """The merits in a verdict that an answer may be paid for.

    Attributes:
        gain: for plans and subgoals the goals gained, of all that there are to gain; for interpretations of
            goals and for operators F1. Between 0 and 1.
        success: whether the answer is right as a whole, which takes a gain of 1.
        ended: whether an error ended it: its last action, if it has any, could not be carried out.
        faults: how often each kind of fault was diagnosed; kinds that were not are left out.
        added: how many actions a search had to add to carry out subgoals. All that they earn is divided by
            one more, so that the goal copied as a subgoal is not paid for what the search did.
    """

    gain: float
    success: bool
    ended: bool
    faults: Mapping[FaultKind, int]
    added: int = 0


def gain(reached: Sequence[bool], at_start: Sequence[bool]) -> float | None:
    """How much of what there is to gain is gained, from 0 to 1; None where there is nothing.

    A goal that holds at the start earns nothing, and costs one that is reached if it is undone.

    Args:
        reached: for each goal, in order, whether it is reached at the end; none if nothing was carried out.
        at_start: whether it is reached where nothing is done.
    """
    held = sum(at_start)
    to_gain = len(at_start) - held
    return max(0, sum(reached) - held) / to_gain if to_gain else None


def merit_of_actions(
    reached: Sequence[bool], at_start: Sequence[bool], *, ended: bool, faults: Mapping[FaultKind, int]
) -> Merit | None:
    """The merit of actions, as a plan or one a turn; None where there is nothing to earn.

    Args:
        reached: for each goal, in order, whether it is reached now; none if nothing was carried out.
        at_start: whether it is reached where nothing is done.
        ended: whether the last action could not be carried out.
        faults: how often each kind of fault was made.
    """
    gained = gain(reached, at_start)
    return None if gained is None else Merit(gained, gained == 1 and not ended, ended, faults)


def merit_of_parts(
    counts: tuple[int, int, int],
    error: ErrorReport | None,
    faults: Mapping[FaultKind, int],
    strangers: int = 0,
) -> Merit | None:
    """The merit of what is compared part by part; None where nothing is asked for.

    Args:
        counts: how many parts are right, are wrong, and are missed.
        error: the error that ended the answer, if one did.
        faults: how often each other kind of fault was made.
        strangers: how many parts mean nothing; each is as wrong as one that is not so.
    """
    hit, extra, missed = counts
    if not hit + missed:
        return None
    if error is not None:
        faults = Counter(faults) + Counter((error.kind,))
    return Merit(
        gain=2 * hit / (2 * hit + extra + strangers + missed),
        success=not extra and not missed and not faults,
        ended=error is not None,
        faults=faults,
    )
