from __future__ import annotations

import pytest

from eai.abilities.transition_modeling.rules import PaperOperatorScoringRules
from eai.abilities.transition_modeling.scorer import TransitionModelingScorer
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.logic.formula import Constant, Exists, Formula, Occurs, Variable
from eai.pddl.execute import PlanStep
from eai.pddl.planning import PlannerOutcome
from eai.pddl.search import BuiltInPlanner
from eai.tasks.operator_task import TransitionTask, make_transition_tasks
from eai.tasks.task import Goal, GoalKind, PredicateCategory, Task
from eai.world.action import Action
from eai.world.derived import DefinedPredicate, is_a
from eai.world.domain import Domain
from eai.world.effect import ANYTHING, Add, Delete, ForEach
from eai.world.execution import execute_plan
from eai.world.frame import AGENT
from eai.world.operator import Operator, additional_step, affordance, missing_step
from eai.world.state import Scene, WorldObject
from eai.world.vocabulary import Predicate, Vocabulary
from operator_rules import gold_answer

X, Y = Variable("x"), Variable("y")
BRIGHT = Predicate("bright", 1)
HEAVY = Predicate("heavy", 1, static=True)
AT = Predicate("at", 2)
TIRED = Predicate("tired", 0)
SEEN = Predicate("seen", 1, visible=False)
DARK = DefinedPredicate("dark", (), ~Exists(Y, BRIGHT(Y)))
VOCABULARY = Vocabulary((BRIGHT, HEAVY, AT, TIRED, SEEN), (DARK,))
GO = Operator(
    "GO",
    (X,),
    (additional_step(~AT(AGENT, X), "there"),),
    (Delete(AT(AGENT, ANYTHING)), Add(AT(AGENT, X)), Add(SEEN(X))),
)
LIGHT = Operator(
    "LIGHT",
    (X,),
    (
        affordance(is_a(X, "lamp") & ~HEAVY(X), "no lamp"),
        missing_step(AT(AGENT, X), "away"),
        missing_step(DARK(), "bright"),
    ),
    (Add(BRIGHT(X)), ForEach(Y, HEAVY(Y), (Delete(BRIGHT(Y)),))),
)
REST = Operator("REST", (), (), (Delete(TIRED()),))
ROOMS = Domain("rooms", VOCABULARY, (GO, LIGHT, REST))
SCENE = Scene(
    VOCABULARY, [WorldObject("me", "robot"), WorldObject("Lamp", "lamp"), WorldObject("box", "box")], agent=0
)
INITIAL = SCENE.state([("at", (0, 2)), ("heavy", (2,)), ("tired", ())])


def task(name: str, *goals: Formula, script: tuple[Action, ...] = ()) -> Task:
    kinds = [GoalKind.ACTION if isinstance(goal, Occurs) else GoalKind.STATE for goal in goals]
    found = tuple(Goal(kind, goal) for kind, goal in zip(kinds, goals, strict=True))
    return Task(name, name, name, INITIAL, found, (0, 1, 2), script)


SCRIPT = (Action("REST", ()), Action("GO", (1,)), Action("LIGHT", (1,)))
LIT = task("lit", BRIGHT(Constant("Lamp")))
TASKS = {
    each.id: each
    for each in (
        LIT,
        task("there", AT(AGENT, Constant("Lamp"))),
        task(
            "scripted",
            BRIGHT(Constant("Lamp")),
            script=(Action("REST", ()), Action("GO", (1,)), Action("LIGHT", (1,))),
        ),
        task("act", Occurs("REST")),
        task("never", HEAVY(Constant("Lamp"))),
    )
}


@pytest.fixture(scope="module")
def tasks() -> dict[str, TransitionTask]:
    return make_transition_tasks(ROOMS, TASKS)


def test_a_task_asks_for_the_operators_of_a_plan(tasks: dict[str, TransitionTask]) -> None:
    assert {name: found.operators for name, found in tasks.items()} == {
        "lit": ("go", "light"),
        "there": ("go",),
        "scripted": ("go", "light", "rest"),
        "never": ("go", "light", "rest"),
    }


def test_predicates_and_tasks_have_categories(tasks: dict[str, TransitionTask]) -> None:
    assert tasks["lit"].domain.categories == {
        "bright": PredicateCategory.OBJECT_STATES,
        "heavy": PredicateCategory.OBJECT_AFFORDANCE,
        "at": PredicateCategory.SPATIAL_RELATIONS,
        "tired": PredicateCategory.NON_SPATIAL_RELATIONS,
        "dark": PredicateCategory.NON_SPATIAL_RELATIONS,
        "is-lamp": PredicateCategory.OBJECT_AFFORDANCE,
    }
    assert tasks["there"].categories == (PredicateCategory.SPATIAL_RELATIONS,)
    own = make_transition_tasks(ROOMS, {"lit": LIT}, {"bright": PredicateCategory.OBJECT_ORIENTATION})
    assert own["lit"].categories == (PredicateCategory.OBJECT_ORIENTATION,)


def test_what_no_text_may_mention_is_left_out(tasks: dict[str, TransitionTask]) -> None:
    assert "seen" not in gold_answer(tasks["lit"]) + tasks["lit"].problem_text


@pytest.mark.parametrize("name", ["lit", "there", "scripted"])
def test_the_gold_answer_is_right_in_every_respect(tasks: dict[str, TransitionTask], name: str) -> None:
    verdict = TransitionModelingScorer(tasks[name], PaperOperatorScoringRules(BuiltInPlanner())).score(
        gold_answer(tasks[name])
    )
    assert isinstance(verdict, OperatorVerdict)
    assert verdict.planner is PlannerOutcome.SOLVED
    sides = [side for report in verdict.operators for side in (report.precondition, report.effect)]
    assert any(side.matched for side in sides)
    assert not any(side.missing or side.additional for side in sides)


def test_a_wrong_operator_cannot_reach_the_goal(tasks: dict[str, TransitionTask]) -> None:
    text = gold_answer(tasks["lit"]).replace("(bright ?x)", "(at ?x ?x)")
    verdict = TransitionModelingScorer(tasks["lit"], PaperOperatorScoringRules(BuiltInPlanner())).score(text)
    assert verdict.planner is PlannerOutcome.UNSOLVABLE


def test_steps_of_exported_operators_are_the_actions_of_their_domain(
    tasks: dict[str, TransitionTask],
) -> None:
    verdict = TransitionModelingScorer(tasks["lit"], PaperOperatorScoringRules(BuiltInPlanner())).score(
        gold_answer(tasks["lit"])
    )
    assert isinstance(verdict, OperatorVerdict)
    steps = [PlanStep(name, tuple(objects)) for name, *objects in map(str.split, verdict.plan)]
    actions = tasks["lit"].actions_of(LIT, steps)
    assert [*actions] == [Action("GO", (1,)), Action("LIGHT", (1,))]
    assert ROOMS.holds(LIT.goals[0].formula, execute_plan(ROOMS, INITIAL, actions).final_state)


@pytest.mark.parametrize("step", [PlanStep("fly", ("lamp",)), PlanStep("go", ("moon",))])
def test_actions_end_before_a_step_that_was_not_exported(
    tasks: dict[str, TransitionTask], step: PlanStep
) -> None:
    go = PlanStep("go", ("lamp",))
    assert [*tasks["lit"].actions_of(LIT, [go, step, go])] == [Action("GO", (1,))]


def test_no_tasks_with_conditions_are_no_tasks() -> None:
    assert make_transition_tasks(ROOMS, {"act": TASKS["act"]}) == {}
