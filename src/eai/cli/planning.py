"""What commands that judge operators share: the terms of planners, and what is said of the authority."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import typer

from eai.abilities.record import Record
from eai.abilities.transition_modeling.declaration import OperatorVerdict
from eai.cli.console import counted, note
from eai.pddl.planning import PlannerOutcome, PlannerTerms

_AT_A_LIMIT = (PlannerOutcome.TIME, PlannerOutcome.MEMORY)


@contextmanager
def _planning_together(seconds: int | None, memory_mib: int | None) -> Iterator[PlannerTerms]:
    with tempfile.TemporaryDirectory(prefix="eai-planning-") as folder:
        yield PlannerTerms(seconds, memory_mib, Path(folder))


def planner_terms(command: typer.Context, seconds: int | None, memory_mib: int | None) -> PlannerTerms:
    """The terms of planners in a command, whose processes share what they find until it ends."""
    return command.with_resource(_planning_together(seconds, memory_mib))


def tell_authority(name: str, records: Sequence[Record]) -> None:
    """Say on standard error how many problems the built-in search left to Fast Downward."""
    judged = [r.verdict for r in records if isinstance(r.verdict, OperatorVerdict) and r.verdict.planner_name]
    left = [verdict for verdict in judged if _was_left(verdict)]
    if not left:
        return
    ended = sum(verdict.planner in _AT_A_LIMIT for verdict in left)
    limits = f", {ended} of them to the end of its time or memory" if ended else ""
    note(f"{name}: {len(left)} of {counted(len(judged), 'problem')} went to Fast Downward{limits}")


def _was_left(verdict: OperatorVerdict) -> bool:
    """Whether the first of two planners did not decide."""
    _, then, authority = (verdict.planner_name or "").partition(", then ")
    return bool(then) and verdict.planner_detail.startswith(authority)
