from __future__ import annotations

import pytest

from eai.abilities.subgoal_decomposition.declaration import compute_contributions_to_metrics
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory, SubgoalVerdict
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
        (SubgoalAnswerCategory.CORRECT, None, {"task_success", "execution_success"}),
        (SubgoalAnswerCategory.GOAL_UNREACHABLE, None, {"execution_success", "goal_unreachable"}),
        (SubgoalAnswerCategory.NOT_PARSEABLE, FaultKind.PARSING, {"parsing"}),
        (SubgoalAnswerCategory.HALLUCINATION, FaultKind.HALLUCINATION, {"hallucination"}),
        (SubgoalAnswerCategory.HALLUCINATION, FaultKind.ARGUMENT_NUMBER, {"argument_number"}),
        (SubgoalAnswerCategory.RUNTIME, FaultKind.MISSING_STEP, {"missing_step"}),
    ],
)
def test_an_answer_counts_by_its_category_and_its_error(
    category: SubgoalAnswerCategory, kind: FaultKind | None, counted: set[str]
) -> None:
    executable = category in {SubgoalAnswerCategory.CORRECT, SubgoalAnswerCategory.GOAL_UNREACHABLE}
    verdict = SubgoalVerdict(
        executable=executable,
        success=category is SubgoalAnswerCategory.CORRECT,
        error=None if kind is None else ErrorReport(kind, 0, "because"),
        category=category,
        errors=() if kind is not FaultKind.MISSING_STEP else (kind,),
    )
    shares = compute_contributions_to_metrics(verdict)
    assert {name for name in RATES if shares[name].numerator} == counted
    assert all(shares[name].denominator == 1 for name in RATES)
