"""Goals over time: they are tested on all states of a trajectory, and a report names the violated part."""

from __future__ import annotations

import json

import pytest

from by_path import ROOT
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.goal_interpretation.scorer import GoalInterpretationScorer
from eai.abilities.notation.goal_lexicon import write_goals
from eai.abilities.replanning_options import ReplanningOptions
from eai.abilities.subgoal_decomposition.scorer import SubgoalDecompositionScorer
from eai.abilities.trial import MultiAttemptTrial
from eai.abilities.verdict import PlanVerdict
from eai.agents.game import Game
from eai.agents.reference import make_setup
from eai.agents.rules import GameRules
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark
from eai.tasks.planning import to_planning_goal
from eai.tasks.task import GoalKind, Task
from eai.tasks.task_lines import _TaskLine, make_task_from_line, write_task_line
from eai.world.action import Action

ORDERED = "not inside(ball, box) until lit(lamp_1)"
NEVER = "always not (is_open(box) and lit(lamp_1))"
LATER = "lit(lamp_2) then lit(lamp_1)"
TAKEN = "not lit(lamp_1) until TAKE(ball)"
BOTH = f"({ORDERED}) and eventually lit(lamp_2)"

LIGHT = "GO lamp_1, PRESS lamp_1"
OTHER = "GO lamp_2, PRESS lamp_2"
PACK = "GO ball, TAKE ball, GO box, PUT ball box"
OPEN = "GO box, OPEN box"


@pytest.fixture
def lamps(monkeypatch: pytest.MonkeyPatch) -> Benchmark:
    monkeypatch.syspath_prepend(ROOT / "examples" / "lamps")
    return find_benchmark("lamps:lamps")


def task(lamps: Benchmark, *goals: str) -> Task:
    line = _TaskLine(
        id="t",
        base="lamps:lamps",
        instruction="DataPack the ball and light the lamp.",
        objects={"robot": "robot", "lamp_1": "lamp", "lamp_2": "lamp", "ball": "ball", "box": "box"},
        agent="robot",
        facts={},
        goals=list(goals),
    )
    return make_task_from_line(line, lamps.domain)


def plan(lamps: Benchmark, asked: Task, text: str) -> str:
    steps = [step.split() for step in text.split(", ")]
    index = asked.scene.index
    return lamps.notation.plans.join(
        lamps.notation.plans.write(
            [Action(o, tuple(index[n] for n in names)) for o, *names in steps], asked.scene
        )
    )


CASES = [
    (ORDERED, f"{OPEN}, {LIGHT}, {PACK}", True, ""),
    (ORDERED, f"{OPEN}, {PACK}, {LIGHT}", False, "violated after PUT(ball, box): not inside(ball, box)"),
    (ORDERED, "GO ball", False, "never: lit(lamp_1)"),
    (NEVER, f"{LIGHT}, GO lamp_2", True, ""),
    (NEVER, f"{LIGHT}, {OPEN}", False, "violated after OPEN(box): not (is_open(box) and lit(lamp_1))"),
    (LATER, f"{OTHER}, {LIGHT}", True, ""),
    (LATER, f"{LIGHT}, {OTHER}", False, "never after what comes first: lit(lamp_1)"),
    (LATER, f"{LIGHT}, {OTHER}, GO box", True, ""),  # lit until the end, also after the other
    (LATER, f"{LIGHT}", False, "never: lit(lamp_2)"),
    (TAKEN, f"GO ball, TAKE ball, {LIGHT}", True, ""),
    (TAKEN, f"{LIGHT}, GO ball, TAKE ball", False, "violated after PRESS(lamp_1): not lit(lamp_1)"),
    (TAKEN, LIGHT, False, "violated after PRESS(lamp_1): not lit(lamp_1)"),
    (BOTH, f"{LIGHT}", False, "never: eventually lit(lamp_2)"),
    (BOTH, f"{LIGHT}, {OTHER}", True, ""),
]


@pytest.mark.parametrize(("goal", "steps", "met", "why"), CASES)
def test_goals_over_time_are_tested_on_the_trajectory(
    lamps: Benchmark, goal: str, steps: str, met: bool, why: str
) -> None:
    asked = task(lamps, goal)
    scorer = ActionSequencingScorer(asked, lamps.domain, lamps.notation.plans)
    assessment = scorer.assess(plan(lamps, asked, steps))
    verdict = assessment.verdict
    assert isinstance(verdict, PlanVerdict)
    assert (verdict.executable, verdict.success, verdict.goals_satisfied) == (True, met, (met,))
    (report,) = assessment.explain().goals
    assert (report.satisfied, report.why) == (met, why)


def test_goals_at_the_end_must_hold_as_well(lamps: Benchmark) -> None:
    asked = task(lamps, "inside(ball, box)", "lit(lamp_1)", ORDERED, "GO()")
    scorer = ActionSequencingScorer(asked, lamps.domain, lamps.notation.plans)
    verdict = scorer.score(plan(lamps, asked, f"{OPEN}, {PACK}, {LIGHT}"))
    assert verdict.goals_satisfied == (True, True, False, True)  # type: ignore[attr-defined]
    assert not verdict.success  # type: ignore[attr-defined]
    assert scorer.score(plan(lamps, asked, f"{LIGHT}, {OPEN}, {PACK}")).success  # type: ignore[attr-defined]
    assert scorer.score("nothing").goals_satisfied == (False,) * 4  # type: ignore[attr-defined]


def test_a_goal_over_time_is_recognized(lamps: Benchmark) -> None:
    asked = task(lamps, "lit(lamp_1)", ORDERED, NEVER, TAKEN, "PRESS() or GO()")
    kinds = [goal.kind for goal in asked.goals]
    assert kinds == [*[GoalKind.STATE], GoalKind.RELATION, GoalKind.STATE, GoalKind.STATE, GoalKind.ACTION]
    assert [goal.is_temporal for goal in asked.goals] == [False, True, True, True, False]
    assert [goal.kind for goal in asked.without_goals_over_time.goals] == [GoalKind.STATE, GoalKind.ACTION]
    assert len(to_planning_goal(asked).conditions) == 1
    again = write_task_line(asked, "lamps:lamps", lamps.domain)
    assert all(text in again for text in (ORDERED, NEVER, TAKEN))


def test_goal_interpretation_ignores_goals_over_time(lamps: Benchmark) -> None:
    asked = task(lamps, "lit(lamp_1)", ORDERED)
    scorer = GoalInterpretationScorer(asked, lamps.domain, lamps.notation.goals)
    gold = lamps.notation.goals.join(write_goals(asked, lamps.domain, lamps.notation.goals))
    assert scorer.score(gold).counts["all"] == (1, 0, 0)  # type: ignore[attr-defined]


LAMPS = "not lit(lamp_2) until lit(lamp_1)"
EITHER = "lit(lamp_2) or lit(lamp_1)"
PLACE = "at(robot, box) or at(robot, ball)"
SUBGOALS = [
    (LAMPS, ["lit(lamp_1)", "lit(lamp_2)"], True),
    (LAMPS, ["lit(lamp_2)", "lit(lamp_1)"], False),
    # branches with equal states have different trajectories; one is right
    (LAMPS, [EITHER, "lit(lamp_1) and lit(lamp_2)", PLACE, PLACE, "at(robot, lamp_1)"], True),
    (LATER, ["lit(lamp_1)"], False),
]


@pytest.mark.parametrize(("goal", "subgoals", "met"), SUBGOALS)
def test_goals_over_time_are_tested_while_subgoals_are_executed(
    lamps: Benchmark, goal: str, subgoals: list[str], met: bool
) -> None:
    asked = task(lamps, goal)
    assessment = SubgoalDecompositionScorer(asked, lamps.domain).assess(json.dumps({"output": subgoals}))
    assert (assessment.verdict.executable, assessment.verdict.success) == (True, met)  # type: ignore[attr-defined]
    assert bool(assessment.explain().goals[0].why) != met


def test_a_continued_world_keeps_its_history(lamps: Benchmark) -> None:
    """The trajectory of a further attempt begins with the first attempt."""
    asked = task(lamps, "lit(lamp_1)", TAKEN)
    scorer = ActionSequencingScorer(asked, lamps.domain, lamps.notation.plans)
    trial = MultiAttemptTrial(scorer, ReplanningOptions(replans=2, world="continue"))
    assert not trial.try_answer(plan(lamps, asked, "GO ball, TAKE ball, GO lamp_1")).verdict.success
    done = trial.try_answer(plan(lamps, asked, "PRESS lamp_1"))
    assert (done.verdict.success, done.goal_held_at) == (True, 1)


def test_an_environment_continues_until_goals_over_time_hold(lamps: Benchmark) -> None:
    asked = task(lamps, "lit(lamp_1)", LATER)
    rules = GameRules(until="goal")
    game = Game(make_setup(asked, lamps, rules))
    assert '"always c" says' in game.write_first_observation()
    turns = [game.act(command) for command in ("GO(lamp_1)", "PRESS(lamp_1)", "GO(lamp_2)", "PRESS(lamp_2)")]
    assert [turn.info["goals"] for turn in turns] == [
        [False, False],
        [True, False],
        [True, False],
        [True, False],
    ]
    assert game.act("GO(ball)").info["goals"] == [True, True]
    assert game.is_over
