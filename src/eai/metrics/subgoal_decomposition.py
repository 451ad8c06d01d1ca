"""The paper's metrics of subgoal decomposition (tables "trajectory evaluation" and "goal satisfaction")."""

from __future__ import annotations

from eai.abilities.protocol import Protocol
from eai.abilities.verdict import SubgoalCategory, Verdict
from eai.metrics.goals import GOAL_COLUMNS, goal_rates, tallies_of
from eai.metrics.rate import Rate, share
from eai.world.fault import FaultKind

TABLE_COLUMNS = (
    "task_success",
    "execution_success",
    "parsing",
    "hallucination",
    "argument_number",
    "wrong_order",
    "missing_step",
    "affordance",
    "additional_step",
    *GOAL_COLUMNS,
)
"""What a terminal shows: the paper's columns."""

_RUNTIME_FAULTS = (FaultKind.WRONG_ORDER, FaultKind.MISSING_STEP, FaultKind.AFFORDANCE)
_EXECUTED = (SubgoalCategory.CORRECT, SubgoalCategory.GOAL_UNREACHABLE)


def contribution(verdict: Verdict, protocol: Protocol) -> dict[str, Rate]:
    """What one answer contributes to each rate.

    Under `eai-1.0.5` the three runtime errors are counted by entry in the reported branch (``errors`` in the
    details), not by task, and answers that run but miss the goal count none of their errors (reference:
    ``subgoal_eval_utils.py``).
    """
    category = verdict.category
    kind = None if verdict.error is None else verdict.error.kind
    wrong_arity = kind is FaultKind.ARGUMENT_NUMBER
    unknown = category is SubgoalCategory.HALLUCINATION and not wrong_arity
    return {
        "task_success": share(category is SubgoalCategory.CORRECT),
        "execution_success": share(category in _EXECUTED),
        "parsing": share(category is SubgoalCategory.NOT_PARSEABLE),
        "hallucination": share(unknown),
        "argument_number": share(wrong_arity),
        **{fault.value: share(_times(verdict, fault, protocol)) for fault in _RUNTIME_FAULTS},
        "additional_step": share(
            bool(verdict.additional_steps) and not _errors_do_not_count(verdict, protocol)
        ),
        "goal_unreachable": share(category is SubgoalCategory.GOAL_UNREACHABLE),
        **goal_rates(tallies_of(verdict)),
    }


def _errors_do_not_count(verdict: Verdict, protocol: Protocol) -> bool:
    return protocol is Protocol.EAI_1_0_5 and verdict.category is SubgoalCategory.GOAL_UNREACHABLE


def _times(verdict: Verdict, fault: FaultKind, protocol: Protocol) -> int:
    """How often a runtime error counts."""
    if protocol is Protocol.EAI_1_0_5:
        if _errors_do_not_count(verdict, protocol):
            return 0
        entries = (verdict.details or {}).get("errors")
        if isinstance(entries, list | tuple):
            return list(entries).count(fault.value)
    return int(verdict.error is not None and verdict.error.kind is fault)
