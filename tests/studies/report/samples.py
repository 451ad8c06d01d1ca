"""Made-up runs of every ability, with markup in some answers."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from eai.abilities.explanation import GoalReport, StepReport, VerdictExplanation, parse_statement
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory, SubgoalVerdict
from eai.abilities.task_features import TaskFeatures
from eai.abilities.transition_modeling.verdict import (
    OperatorComparisonStatus,
    OperatorReport,
    OperatorVerdict,
    find_predicates_and_their_categories,
)
from eai.abilities.verdict import ConfusionCounts, ErrorReport, PlanVerdict, Verdict
from eai.pddl.check import PddlFinding, PddlViolationKind
from eai.pddl.matching import ClauseComparison
from eai.pddl.planning import PlannerOutcome
from eai.results.rate import Rate
from eai.results.record import AnswerOrigin, Record
from eai.studies.report.rankings import RankedModel, RankedScore
from eai.world.fault import FaultKind
from record_files import write_records
from results.verdicts import goals, record, whole

HOSTILE = (
    "</script><script>document.title='owned'</script>"
    "<img src=x onerror=\"document.title='owned'\"><style>*{display:none}</style>"
    "\u2028\u2029\ud800 ]]> <!-- & $x^2$ \\end{table} | `x` **b** {{program}} {{data}} "
)
"""An answer, and a name, that would do harm where text is not kept text."""

STEPS = (
    StepReport(
        "WALK(bed.1)",
        "executed",
        added=("NEXT_TO(me.65, bed.1)",),
        hidden_changes=2,
        call=parse_statement("WALK(bed.1)"),
    ),
    StepReport(
        "SWITCHON(light.2)",
        "additional_step",
        "light.2 is not off",
        call=parse_statement("SWITCHON(light.2)"),
    ),
    StepReport(
        "GRAB(cup.3)",
        "executed",
        added=("HOLDS(me.65, cup.3)",),
        removed=("ONTOP(cup.3, bed.1)",),
        call=parse_statement("GRAB(cup.3)"),
    ),
    StepReport(
        "OPEN(box.4)",
        "wrong_order",
        "box.4 is open",
        "it would have been possible after step 1",
        call=parse_statement("OPEN(box.4)"),
    ),
)


def actions(task: str, verdict: Verdict, response: str = '{"WALK": ["bed"]}', **names: str) -> Record:
    """An answer with a plan."""
    explanation = VerdictExplanation(
        notes=("read with repair: prose",),
        steps=STEPS,
        goals=(
            GoalReport("state", "ON(light.2)", True, predicates=("ON",)),
            GoalReport("relation", "INSIDE(cup.3, box.4)", False, predicates=("INSIDE",)),
        ),
    )
    return _record(task, verdict, explanation, Ability.ACTION_SEQUENCING, response, **names)


def _record(
    task: str,
    verdict: Verdict,
    explanation: VerdictExplanation,
    ability: Ability,
    response: str,
    model: str = "first",
    domain: str = "virtualhome",
    protocol: str = "strict",
    origin: AnswerOrigin | None = None,
) -> Record:
    found = record(
        task,
        verdict,
        ability=ability,
        model=model,
        domain=domain,
        protocol=Protocol(protocol),
        response=response,
    )
    number = int(task.partition("_")[0])
    features = TaskFeatures(f"name {number % 4}", 3 + 2 * number, 1 + number % 3)
    return replace(found, explanation=explanation, origin=origin, task=features)


RIGHT = PlanVerdict(executable=True, success=True, goals=goals((1, 1), (1, 1)), additional_steps=1)
WRONG = PlanVerdict(
    executable=False,
    success=False,
    error=ErrorReport(FaultKind.WRONG_ORDER, 3, "box.4 is open"),
    goals=goals((1, 1), (0, 2)),
    repairs=("prose",),
)
UNREADABLE = PlanVerdict(
    executable=False,
    success=False,
    error=ErrorReport(FaultKind.PARSING, None, "no JSON"),
    goals=goals((0, 2)),
)
EXCLUDED = PlanVerdict(excluded="the reference drops this task")


def action_run(model: str = "first", protocol: str = "strict") -> list[Record]:
    """Twelve answers with plans; another model fails where the first succeeds, and the other way round."""
    verdicts = [RIGHT, WRONG, UNREADABLE] if model == "first" else [WRONG, RIGHT, UNREADABLE]
    answers = [
        actions(f"{i}_1", verdicts[i % 3], f"answer {i}", model=model, protocol=protocol) for i in range(11)
    ]
    return [*answers, actions("11_1", EXCLUDED, HOSTILE, model=model, protocol=protocol)]


def goal_run() -> list[Record]:
    """Goals found, missed and invented."""
    verdict = GoalVerdict(
        counts={"state": ConfusionCounts(1, 1, 1), "relation": ConfusionCounts(0, 0, 0)},
        predicted=2,
        hallucinated=("sofaa",),
    )
    explanation = VerdictExplanation(
        notes=("wrong: OFF(bed)",),
        goals=(
            GoalReport("state", "ON(light.2)", True, predicates=("ON",)),
            GoalReport("state", "CLEAN(bed.1)", False, predicates=("CLEAN",)),
        ),
    )
    return [_record(f"{i}_1", verdict, explanation, Ability.GOAL_INTERPRETATION, "{}") for i in range(4)]


def subgoal_run() -> list[Record]:
    """Subgoals of every outcome."""
    verdicts = [
        SubgoalVerdict(category=category, executable=i < 2, success=i == 0, goals=goals((1, 1)))
        for i, category in enumerate(SubgoalAnswerCategory)
    ]
    explanation = VerdictExplanation(steps=STEPS[:2])
    return [
        _record(f"{i}_1", verdict, explanation, Ability.SUBGOAL_DECOMPOSITION, "{}")
        for i, verdict in enumerate(verdicts)
    ]


def operator_run() -> list[Record]:
    """Operators with missing and additional predicates."""
    side = ClauseComparison(("(closed ?o)",), ("(not (near ?o))",), ("(can_open ?o)",))
    offence = PddlFinding(PddlViolationKind.UNKNOWN_PREDICATE, "near", "precondition")
    verdict = OperatorVerdict(
        success=True,
        counts={
            "precondition": {"all": ConfusionCounts(1, 1, 1), "object_states": ConfusionCounts(1, 1, 1)},
            "effect": {},
        },
        literals={"precondition": ConfusionCounts(1, 1, 1), "effect": ConfusionCounts(0, 0, 0)},
        planner=PlannerOutcome.SOLVED,
        task_categories=("object_states", "spatial_relations"),
        operators=(OperatorReport("open", OperatorComparisonStatus.COMPARED, side, offences=(offence,)),),
        clauses={
            part: find_predicates_and_their_categories(part, {})
            for part in (*side.matched, *side.additional, *side.missing)
        },
    )
    operator = "(:action open :parameters (?o) :precondition (and (closed ?o) (near ?o)) :effect (and))"
    answer = json.dumps({"output": operator})
    return [
        _record(f"{i}_1", verdict, VerdictExplanation(), Ability.TRANSITION_MODELING, answer)
        for i in range(3)
    ]  # fmt: skip


def write_runs(folder: Path, runs: Sequence[Sequence[Record]]) -> Path:
    """Records in folders of their own below a folder."""
    for number, records in enumerate(runs):
        place = folder / f"run{number}"
        place.mkdir(parents=True)
        write_records(place / "records.jsonl", whole(records))
    return folder


def all_runs() -> list[list[Record]]:
    """Every ability, two models for plans, and one run under both protocols."""
    plans = [action_run("first"), action_run("second"), action_run("first", "eai-1.0.5")]
    return [*plans, goal_run(), subgoal_run(), operator_run()]


def cell_at(row: RankedModel, place: int) -> RankedScore:
    """Return the number of a row in a column."""
    return [*row.scores.values()][place]


def rate_at(row: RankedModel, place: int) -> Rate:
    """Return the rate of a row in a column."""
    score = cell_at(row, place)
    assert score.numerator is not None
    assert score.denominator is not None
    return Rate(score.numerator, score.denominator)
