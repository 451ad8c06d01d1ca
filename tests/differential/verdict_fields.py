"""Fields of our verdicts that are compared with the reference package's.

A summary of verdicts counts them, too.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.subgoal_decomposition.verdict import SubgoalVerdict
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.abilities.verdict import PlanVerdict, Verdict
from eai.world.fault import FaultKind


def fields(verdict: Verdict) -> dict[str, object]:
    """Return the fields of a verdict under the names that `compare_with_reference_child.py` uses."""
    match verdict:
        case SubgoalVerdict():
            return _of_subgoals(verdict)
        case PlanVerdict():
            return _of_plan(verdict)
        case GoalVerdict():
            return _of_goals(verdict)
        case OperatorVerdict():
            return _of_operators(verdict)
        case _:
            raise TypeError(f"cannot compare a {type(verdict).__name__}: add its fields here")


def _of_plan(verdict: PlanVerdict) -> dict[str, object]:
    if verdict.excluded is not None:
        return {"excluded": True}
    kinds = [] if verdict.error is None else [verdict.error.kind]
    kinds += [FaultKind.ADDITIONAL_STEP] if verdict.additional_steps else []
    counted = verdict.counted
    return {
        "excluded": False,
        "executable": verdict.executable,
        "success": verdict.success,
        "errors": _by_name(Counter(kinds) if counted is None else dict(counted.errors)),
        "goals": [share.numerator for share in verdict.goals or ()],
        "goals met": list(verdict.goals_satisfied),
    }


def _by_name(counts: dict[FaultKind, int]) -> dict[str, int]:
    return {kind.value: count for kind, count in counts.items()}


def _of_subgoals(verdict: SubgoalVerdict) -> dict[str, object]:
    rejected = () if verdict.error is None or verdict.search is not None else (verdict.error.kind,)
    return {
        "category": None if verdict.category is None else verdict.category.value,
        "errors": [kind.value for kind in (*rejected, *verdict.errors)],
        "goals": [share.numerator for share in verdict.goals or ()],
        "goals met": list(verdict.goals_satisfied),
    }


def _of_goals(verdict: GoalVerdict) -> dict[str, object]:
    if verdict.aborts:
        return {"ends the run": True}
    return {
        "ends the run": False,
        "unreadable": verdict.error is not None,
        **{kind: list(counts) for kind, counts in (verdict.counts or {}).items()},
        "ill-formed": verdict.ill_formed,
        "hallucinated": len(verdict.hallucinated),
        "unknown predicates": len(verdict.unknown_predicates),
    }


def _of_operators(verdict: OperatorVerdict) -> dict[str, object]:
    if verdict.excluded is not None:
        return {"excluded": True}
    sides = verdict.counts or {}
    return {
        "excluded": False,
        **{side: {c: list(n) for c, n in counts.items() if any(n)} for side, counts in sides.items()},
        "written": len(verdict.operators),
        "hallucinated": sum(operator.status.value == "hallucinated" for operator in verdict.operators),
    }


def examples(verdict: Verdict) -> Iterator[str]:
    """Yield the outcome and the kinds of error of a verdict, each once."""
    if verdict.excluded is not None:
        yield "excluded"
    kinds = [] if verdict.error is None else [verdict.error.kind]
    match verdict:
        case SubgoalVerdict():
            yield verdict.category.value if verdict.category else ""
            kinds += verdict.errors
        case PlanVerdict():
            yield "success" if verdict.success else "executable" if verdict.executable else "not executable"
            kinds += [FaultKind.ADDITIONAL_STEP] if verdict.additional_steps else []
        case GoalVerdict():
            said = {"ill-formed": verdict.ill_formed, "hallucinated": verdict.hallucinated}
            yield from (name for name, found in {**said, "ends the run": verdict.aborts}.items() if found)
        case OperatorVerdict():
            yield from {operator.status.value for operator in verdict.operators}
    yield from {kind.value for kind in kinds}
