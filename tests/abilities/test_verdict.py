from __future__ import annotations

import ast
import pickle
from dataclasses import replace
from pathlib import Path

import pytest

import eai
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.protocol import find_protocol_entry_points
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory, SubgoalVerdict
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.abilities.verdict import ConfusionCounts, ErrorReport, PlanVerdict, SummaryCounts, Verdict
from eai.pddl.planning import PlannerOutcome
from eai.tasks.share import Share, TalliesByGoalKind
from eai.world.fault import FaultKind

TALLIES = TalliesByGoalKind(Share(1, 2), Share(0.5, 1.5), Share(0, 0))
ERROR = ErrorReport(FaultKind.MISSING_STEP, 3, "the jar is shut", "OPEN.1", ("jar_0",))


@pytest.mark.parametrize(
    "verdict",
    [
        Verdict("left out", ERROR, ("prose",)),
        PlanVerdict(None, ERROR, (), False, True, 2, TALLIES, (True, False)),
        PlanVerdict(goals=TALLIES, counted=SummaryCounts(True, TALLIES, {FaultKind.PARSING: 2})),
        SubgoalVerdict(
            category=SubgoalAnswerCategory.CORRECT, errors=(FaultKind.AFFORDANCE,), tried_actions=7
        ),
        GoalVerdict(counts={"state": ConfusionCounts(1, 2, 3)}, missing=("on(a, b)",)),
        OperatorVerdict(success=True, planner=PlannerOutcome.SOLVED, plan=("open a",)),
    ],
)
def test_verdicts_of_every_class_survive_pickling(verdict: Verdict) -> None:
    back = pickle.loads(pickle.dumps(verdict))  # noqa: S301 - our own
    assert (type(back), back) == (type(verdict), verdict)
    assert repr(back) == repr(verdict)  # numbers and enums are of the same types


EXCLUDING = {
    "tasks/task.py": "a task that is left out, whatever is answered",
    "results/record.py": "a task without an answer, if the user asks for it; the run is not ranked",
}
"""The modules that make a reason for excluding a task."""


def test_only_tasks_and_the_rules_of_other_protocols_exclude() -> None:
    source = Path(eai.__file__).parent
    of_protocols = tuple(point.module.rpartition(".")[0] for point in find_protocol_entry_points().values())
    made = [
        path.relative_to(source).as_posix()
        for path in sorted(source.rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and ast.unparse(node.func).rpartition(".")[2] == "TaskExclusion"
    ]
    ours = [path for path in made if not f"eai.{path.replace('/', '.')}".startswith(of_protocols or "none")]
    assert sorted(ours) == sorted(EXCLUDING)


def test_a_missing_answer_reaches_no_goal_and_has_no_error() -> None:
    empty = PlanVerdict(
        error=ERROR,
        repairs=("prose",),
        executable=False,
        success=True,
        additional_steps=2,
        goals=TALLIES,
        goals_satisfied=(True, False),
        counted=SummaryCounts(True, TALLIES, {}),
    )
    nothing = empty.to_verdict_on_missing_answer()
    assert nothing == PlanVerdict(
        repairs=("prose",),
        executable=False,
        success=False,
        additional_steps=2,
        goals=TalliesByGoalKind(Share(0, 2), Share(0, 1.5), Share(0, 0)),
        goals_satisfied=(False, False),
    )
    assert PlanVerdict(success=True).to_verdict_on_missing_answer() == PlanVerdict(
        executable=False, success=False
    )
    assert Verdict(None, ERROR).to_verdict_on_missing_answer() == Verdict()
    left_out = PlanVerdict("left out", ERROR, (), None, None, None, TALLIES, (True, False))
    assert left_out.to_verdict_on_missing_answer() == replace(left_out, error=None)
