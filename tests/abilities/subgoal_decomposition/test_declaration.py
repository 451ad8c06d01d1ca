from __future__ import annotations

import pytest

from eai.abilities.subgoal_decomposition.declaration import compute_share_by_metric
from eai.abilities.subgoal_decomposition.verdict import SubgoalCategory, SubgoalVerdict
from eai.abilities.verdict import ErrorReport
from eai.world.fault import FaultKind

RATES = (
    "task_success",
    "execution_success",
    "parsing",
    "hallucination",
    "argument_number",
    "missing_step",
    "goal_unreachable",
)


@pytest.mark.parametrize(
    ("category", "kind", "counted"),
    [
        (SubgoalCategory.CORRECT, None, {"task_success", "execution_success"}),
        (SubgoalCategory.GOAL_UNREACHABLE, None, {"execution_success", "goal_unreachable"}),
        (SubgoalCategory.NOT_PARSEABLE, FaultKind.PARSING, {"parsing"}),
        (SubgoalCategory.HALLUCINATION, FaultKind.HALLUCINATION, {"hallucination"}),
        (SubgoalCategory.HALLUCINATION, FaultKind.ARGUMENT_NUMBER, {"argument_number"}),
        (SubgoalCategory.RUNTIME, FaultKind.MISSING_STEP, {"missing_step"}),
    ],
)
def test_an_answer_counts_by_its_category_and_its_error(
    category: SubgoalCategory, kind: FaultKind | None, counted: set[str]
) -> None:
    executable = category in {SubgoalCategory.CORRECT, SubgoalCategory.GOAL_UNREACHABLE}
    verdict = SubgoalVerdict(
        executable=executable,
        success=category is SubgoalCategory.CORRECT,
        error=None if kind is None else ErrorReport(kind, 0, "because"),
        category=category,
        errors=() if kind is not FaultKind.MISSING_STEP else (kind,),
    )
    shares = compute_share_by_metric(verdict)
    assert {name for name in RATES if shares[name].numerator} == counted
    assert all(shares[name].denominator == 1 for name in RATES)
