"""The scorer of subgoals on a small domain with the default notation and search."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from eai.abilities.notation.subgoals import SubgoalNotation
from eai.abilities.subgoal_decomposition.declaration import compute_contributions_to_metrics
from eai.abilities.subgoal_decomposition.program_builder import SubgoalProgramCompiler
from eai.abilities.subgoal_decomposition.refinement import SubgoalRefiner
from eai.abilities.subgoal_decomposition.scorer import SubgoalDecompositionScorer
from eai.abilities.subgoal_decomposition.search import ExplorationLimits
from eai.abilities.subgoal_decomposition.verdict import SubgoalVerdict
from eai.logic.formula import Atom, Constant, Formula, Not, Occurs, Or
from eai.logic.ltl import read_formula
from eai.planning.planner import Planner
from eai.tasks.goal_text import make_task as task_of
from eai.tasks.planning import find_plan
from eai.tasks.share import Share
from eai.tasks.task import NO_GOALS, Goal, GoalKind, Task
from eai.world.effect import Add, Delete
from eai.world.fault import FaultKind
from eai.world.operator import Operator, additional_step
from eai.world.state import Scene, WorldObject
from world import toy

START = toy.initial()
SCENE = START.scene


def atom(predicate: str, *names: str) -> Atom:
    return Atom(predicate, tuple(Constant(name) for name in names))


def make_task(*goals: Formula, temporal_goal: str | None = None) -> Task:
    kinds = {0: GoalKind.STATE, 1: GoalKind.STATE, 2: GoalKind.RELATION}

    def kind(formula: Formula) -> GoalKind:
        match formula:
            case Not(operand):
                return kind(operand)
            case Atom(_, arguments):
                return kinds[len(arguments)]
            case _:
                return GoalKind.ACTION

    made = tuple(Goal(kind(formula), formula) for formula in goals)
    everything = tuple(range(len(SCENE.objects)))
    return Task("1", "Toy", "Tidy up.", START, made, everything, temporal_goal=temporal_goal)


TASK = make_task(atom("lit", "lamp"), atom("at", "red", "shed"))
SCORER = SubgoalDecompositionScorer(TASK, toy.DOMAIN)


def answer(*subgoals: object) -> str:
    return json.dumps({"output": subgoals})


def summary(verdict: SubgoalVerdict) -> str:
    """Return the category of an answer, and its error."""
    assert verdict.category is not None
    error = "" if verdict.error is None else f" {verdict.error.kind.value} {verdict.error.step}"
    return f"{verdict.category.value}{error}"


@pytest.mark.parametrize(
    ("subgoals", "expected"),
    [
        (["at(red, shed)", "lit(lamp)"], "correct"),
        (["holding(red)", "lit(lamp) and at(red, shed)"], "correct"),
        (["holding(red) then at(red, shed)", "lit(lamp)"], "correct"),
        (["lit(lamp)"], "goal_unreachable"),
        # A subgoal gets at most two actions, so the goal of the task is too far.
        (["lit(lamp) and at(red, shed)"], "runtime missing_step 0"),
        (["at(red, shed) then lit(lamp)"], "runtime missing_step 0"),
        (["GO(shed) then GO(hall)", "at(red, shed)", "lit(lamp)"], "correct"),
        (["GO(shed) then GO(hall) then at(red, shed)", "lit(lamp)"], "runtime missing_step 0"),
        (["LIFT(blue) and holding(blue)", "at(blue, hall)", "lit(blue)"], "runtime affordance 2"),
        # If one alternative holds already, nothing is done and the others are not tried.
        (["at(red, hall) or at(red, shed)", "lit(lamp)"], "goal_unreachable"),
        (["exists x. (at(x, shed))", "holding(red)", "at(robot, shed)"], "goal_unreachable"),
        (["(not lit(lamp)) or lit(red)", "at(red, shed)", "lit(lamp)"], "correct"),
        ([], "goal_unreachable"),
        # Alternatives, variables, classes, negations.
        (["at(red, shed)", "lit(red) or lit(lamp)"], "correct"),
        (["exists x. (lit(x))", "holding(red)", "at(red, shed)"], "correct"),
        (["at(box, shed) and not at(box, hall)", "lit(lamp)"], "goal_unreachable"),
        (["at(blue, place)", "holding(box)"], "goal_unreachable"),
        (["at(red, place)", "exists x:place. (at(red, x) and at(lamp, x))", "lit(lamp)"], "correct"),
        (["not at(red, hall)", "not not lit(lamp)"], "correct"),
        (["holding(red)", "not (at(red, hall) or not lit(lamp))"], "correct"),
        # Actions.
        (["LIFT(red)", "GO(shed)", "PRESS(lamp)"], "correct"),
        (["at(red, shed)", "PRESS(lamp)", "not lit(lamp)"], "goal_unreachable"),
        (["PRESS(red)"], "runtime affordance 0"),
        (["DROP(red)"], "runtime missing_step 0"),
        # Conditions are tested together after they were achieved.
        (["at(red, shed)", "lit(lamp) and not lit(lamp)"], "runtime missing_step 1"),
        (["holding(red) and holding(blue)"], "runtime missing_step 0"),
        (["lit(lamp) implies lit(red)"], "goal_unreachable"),
        (["lit(red)"], "runtime affordance 0"),
        (["forall x. (not lit(x))", "at(red, shed)", "lit(lamp)"], "correct"),
        (
            ["holding(red)", "at(red, shed) and exists x. (lit(x))", "forall x. (lit(x))"],
            "runtime affordance 2",
        ),
        # Derived predicates.
        (["beside(lamp)", "LIFT(red)", "at(red, shed)", "lit(lamp)"], "correct"),
        # Names and syntax.
        (["flies(lamp)"], "hallucination hallucination 0"),
        (["lit(lamp)", "lit(torch)"], "hallucination hallucination 1"),
        (["lit(lamp, red)"], "hallucination argument_number 0"),
        (["lit(lamp)", "lit(lamp"], "not_parseable parsing 1"),
        (["not PRESS(lamp)"], "not_parseable parsing None"),
        (["eventually lit(lamp)"], "not_parseable parsing None"),
        ([f"{'forall x. (exists y. (' * 6}at(x, y){'))' * 6}"], "not_parseable parsing None"),
        ([3], "not_parseable parsing None"),
    ],
)
def test_answers_get_their_category_and_error(subgoals: list[object], expected: str) -> None:
    assert summary(SCORER.score(answer(*subgoals))) == expected


LIGHT = Operator("LIGHT", (toy.X,), (additional_step(~toy.lit(toy.X), "it is lit"),), (Add(toy.lit(toy.X)),))
DIM = Operator("DIM", (toy.X,), (additional_step(toy.lit(toy.X), "it is dark"),), (Delete(toy.lit(toy.X)),))


@pytest.mark.parametrize(
    ("subgoals", "steps", "additional_steps"),
    [
        # A needless step counts if it is the complete subgoal, as an action or as a state.
        (["GO(hall)"], "GO(hall)", 1),
        (["at(robot, hall)"], "GO(hall)", 1),
        (["at(robot, hall)", "at(robot, hall)"], "GO(hall), GO(hall)", 2),
        (["at(robot, hall) and not lit(lamp)"], "GO(hall), DIM(lamp)", 2),
        # Next to a condition to achieve, a condition that holds already must only hold.
        (["holding(red) and at(robot, hall)"], "LIFT(red)", 0),
        (["LIFT(red) and at(robot, hall)"], "LIFT(red)", 0),
        (["LIFT(blue) and not lit(lamp)"], "GO(shed), LIFT(blue)", 0),
        # The condition must hold at the end; it is achieved before or after the action.
        (["at(robot, shed)", "PRESS(lamp) and not lit(lamp)"], "GO(shed), PRESS(lamp), PRESS(lamp)", 0),
        (["lit(lamp) or at(robot, hall)"], "GO(hall)", 1),
        (["at(robot, hall) or not holding(red)"], "", 0),
        (["PRESS(lamp) and lit(lamp)"], "GO(shed), PRESS(lamp)", 0),
        (["lit(lamp)", "not lit(lamp)"], "GO(shed), PRESS(lamp), PRESS(lamp)", 0),
        (["LIFT(red) then at(robot, shed)"], "LIFT(red), GO(shed)", 0),
    ],
)
def test_subgoals_are_executed_by_these_actions(
    subgoals: list[str], steps: str, additional_steps: int
) -> None:
    scorer = SubgoalDecompositionScorer(TASK, toy.DOMAIN.replace_operators(DIM))
    assert scorer.score(answer(*subgoals)).additional_steps == additional_steps
    assert ", ".join([step.action for step in scorer.explain(answer(*subgoals)).steps]) == steps


def test_a_condition_made_true_by_an_action_is_not_achieved_again() -> None:
    """If the condition were achieved before, PRESS would undo it. Only the other order is executed."""
    scorer = SubgoalDecompositionScorer(TASK, toy.DOMAIN.replace_operators(LIGHT))
    text = answer("PRESS(lamp) and lit(lamp)")
    assert [step.action for step in scorer.explain(text).steps] == ["GO(shed)", "PRESS(lamp)"]
    assert scorer.score(text).additional_steps == 0


def test_a_verdict_reports_goals_errors_and_effort() -> None:
    verdict = SCORER.score(answer("lit(lamp)", "DROP(blue)"))
    assert (verdict.executable, verdict.success, verdict.goals_satisfied) == (False, False, (True, False))
    assert verdict.goals == (Share(1, 1), Share(0, 1), Share(0, 0))
    assert [kind.value for kind in verdict.errors] == ["missing_step"]
    assert (verdict.search, verdict.tried_actions, verdict.counted) == ("complete", 3, None)


def test_an_answer_that_is_not_executed_meets_no_goal() -> None:
    scorer = SubgoalDecompositionScorer(make_task(Not(atom("lit", "lamp"))), toy.DOMAIN)
    assert scorer.score(answer()).goals_satisfied == (True,)
    rejected = scorer.score(answer("lit(torch)"))
    assert (rejected.goals_satisfied, rejected.offences) == ((False,), ("unknown_object",))
    assert (rejected.executable, rejected.success, rejected.additional_steps) == (False, False, 0)


def test_an_explanation_names_the_subgoal_of_a_wrong_name() -> None:
    text = answer("lit(lamp)", "lit(torch)", "lit(lamp) and shines(lamp)", "at(red)")
    explanation = SCORER.explain(text)
    assert explanation.notes == (
        "hallucination",
        "subgoal 2, lit: there is no object torch",
        "subgoal 3, shines: shines is no predicate and no action",
        "subgoal 4, at: at takes 2 arguments, not 1",
    )
    assert [goal.satisfied for goal in explanation.goals] == [False, False]
    assert SCORER.explain(answer("lit(lamp)", "lit(lamp")).notes == (
        "not_parseable",
        "subgoal 2: line 1, column 9: expected ')' or ','",
    )


@pytest.mark.parametrize(
    ("subgoals", "check", "objects"),
    [
        (["flies(lamp)"], "unknown_predicate", ()),
        (["lit(torch)"], "unknown_object", ("torch",)),
        (["lit(lamp, red)"], "wrong_arity", ()),
        (["DROP(red)"], "is_not_held", ("red",)),
        (["holding(red) and holding(blue)"], "parts_exclude_each_other", ("red", "blue")),
        (["lit(lamp) and not lit(lamp)"], "parts_exclude_each_other", ("lamp",)),
        (["lit(lamp", "lit(lamp)"], None, ()),
    ],
)
def test_an_error_names_the_failed_check_and_its_objects(
    subgoals: list[object], check: str | None, objects: tuple[str, ...]
) -> None:
    error = SCORER.score(answer(*subgoals)).error
    assert error is not None
    assert (error.check, error.objects) == (check, objects)


def test_an_explanation_says_which_objects_were_tried_for_an_open_subgoal() -> None:
    note = "subgoal 1 leaves open which object: only the task's were tried"
    assert note in SCORER.explain(answer("lit(box)")).notes
    assert note not in SCORER.explain(answer("lit(red)")).notes


LAMPS = [f"lamp_{i}" for i in range(17)]
ANY_LAMP = ["exists x. (lit(x))", "lit(lamp)", "exists x. (PRESS(x))"]


def among_lamps(goal: str) -> SubgoalDecompositionScorer:
    """Return a task of a robot in a hall of lamps, with the goal to light one."""
    things = {"robot": "robot", "hall": "place", "shed": "place", **dict.fromkeys(LAMPS, "lamp")}
    scene = Scene(toy.VOCABULARY, (WorldObject(*thing) for thing in things.items()), agent=0)
    initial = scene.state(("at", (scene.index[x], scene.index["hall"])) for x in ("robot", *LAMPS))
    return SubgoalDecompositionScorer(task_of("1", "", initial, atom("lit", goal)), toy.DOMAIN)


@pytest.mark.parametrize("goal", [LAMPS[0], LAMPS[15], LAMPS[16]])
@pytest.mark.parametrize("subgoal", [*ANY_LAMP, " or ".join([f"lit({name})" for name in LAMPS])])
def test_every_branch_of_the_last_subgoal_is_tested(goal: str, subgoal: str) -> None:
    assert among_lamps(goal).score(answer(subgoal)).success


@pytest.mark.parametrize("subgoal", ANY_LAMP)
def test_the_first_branches_continue_if_there_are_too_many(subgoal: str) -> None:
    for goal, success in ((LAMPS[0], True), (LAMPS[15], True), (LAMPS[16], False)):
        verdict = among_lamps(goal).score(answer(subgoal, "at(robot, shed)"))
        assert (verdict.success, verdict.search) == (success, "complete" if success else "branches")


def test_granularity_counts_the_added_actions_of_each_subgoal() -> None:
    """A movement is added once, but not if it is a subgoal. A subgoal that holds already does not count."""
    for subgoals, refined, added in (
        (["lit(lamp)"], 1, 1),
        (["at(robot, shed)", "lit(lamp)"], 2, 0),
        (["lit(lamp)", "at(robot, shed)", "holding(blue)", "at(red, hall)"], 2, 1),
        (["lit(lamp)", "lit(red)"], 2, 1),
        (["flies(lamp)"], None, None),
    ):
        verdict = SCORER.score(answer(*subgoals))
        assert (verdict.refined, verdict.added_actions) == (refined, added)
        assert compute_contributions_to_metrics(verdict)["granularity"] == (added or 0, refined or 0)


def test_a_subgoal_that_takes_too_long_earns_nothing() -> None:
    verdict = SCORER.score(answer("lit(lamp) and at(red, shed)"))
    assert verdict.error is not None
    assert (verdict.goals_satisfied, verdict.error.check) == ((False, False), "too_many_actions")
    assert verdict.error.detail.endswith("2 actions: the states in between must be subgoals, too")


def test_action_goals_are_met_in_order_without_a_temporal_goal() -> None:
    task = make_task(Or((Occurs("DROP"), Occurs("PRESS"))), Occurs("LIFT"), atom("lit", "lamp"))
    scorer = SubgoalDecompositionScorer(task, toy.DOMAIN)
    assert summary(scorer.score(answer("PRESS(lamp)", "LIFT(blue)"))) == "correct"
    assert summary(scorer.score(answer("LIFT(red)", "lit(lamp)"))) == "goal_unreachable"


def test_a_temporal_goal_is_met_in_order_and_goals_hold_at_the_end() -> None:
    goal = "holding(red) then exists x. (PRESS(x)) then at(robot, hall)"
    scorer = SubgoalDecompositionScorer(replace(TASK, temporal_goal=goal), toy.DOMAIN)
    there = ("holding(red)", "at(red, shed)", "lit(lamp)")
    assert summary(scorer.score(answer(*there))) == "goal_unreachable"
    assert summary(scorer.score(answer(*there, "at(robot, hall) and holding(red)"))) == "goal_unreachable"
    assert summary(scorer.score(answer(*there, "not holding(red)", "at(robot, hall)"))) == "correct"


def test_an_explanation_dates_each_part_of_the_temporal_goal() -> None:
    goal = "holding(red) then (lit(lamp) and at(robot, hall)) then at(robot, shed)"
    scorer = SubgoalDecompositionScorer(replace(TASK, temporal_goal=goal), toy.DOMAIN)
    explanation = scorer.explain(answer("holding(red)", "lit(lamp)"))
    assert [step.action for step in explanation.steps] == ["LIFT(red)", "GO(shed)", "PRESS(lamp)"]
    first, second, third = explanation.parts
    assert (first.part, first.met_after, first.missing) == ("holding(red)", 1, ())
    assert (second.part, second.met_after) == ("lit(lamp) and at(robot, hall)", None)
    assert second.missing == ("at(robot, hall)",), "after the first part it is in the shed"
    assert (third.met_after, third.missing) == (None, ())


def test_a_task_without_goals_is_excluded_and_explained() -> None:
    scorer = SubgoalDecompositionScorer(make_task(), toy.DOMAIN)
    assert scorer.score(answer("lit(lamp)")) == SubgoalVerdict(excluded=NO_GOALS)
    assert scorer.explain(answer("lit(lamp)")).notes == ("correct", "subgoal 1: lit(lamp)")


def test_an_explanation_reports_why_the_search_ended() -> None:
    scorer = SubgoalDecompositionScorer(TASK, toy.DOMAIN, limits=ExplorationLimits(attempts=1))
    verdict = scorer.score(answer("at(red, shed)", "lit(lamp)"))
    assert verdict.search == "attempts"


def test_plans_of_the_planner_succeed_as_subgoals() -> None:
    notation = SubgoalNotation(toy.DOMAIN)
    task = make_task(atom("lit", "lamp"), atom("at", "red", "shed"), atom("at", "blue", "hall"))
    plan = find_plan(task, Planner(toy.DOMAIN)).plan
    subgoals = notation.write(task, plan)
    assert len(subgoals) == len(plan) > 4
    assert summary(SubgoalDecompositionScorer(task, toy.DOMAIN).score(notation.join(subgoals))) == "correct"


@pytest.mark.parametrize(
    ("alternatives", "lit", "elsewhere"),
    [
        # The reported branch is the longer one. It meets no goal.
        (["(LIFT(red) then DROP(red)) or lit(lamp)"], 1, True),
        # A failed branch counts up to its failure; the reported branch runs to its end.
        (["at(robot, shed) or (lit(lamp) then DROP(red))"], 1, True),
        # No branch reaches more than the reported one.
        (["at(robot, shed) or holding(blue)"], 0, False),
        (["lit(lamp) or PRESS(red)"], 1, False),
    ],
)
def test_goals_count_in_the_branch_that_reaches_most(
    alternatives: list[str], lit: int, elsewhere: bool
) -> None:
    verdict = SCORER.score(answer(*alternatives))
    assert isinstance(verdict, SubgoalVerdict)
    assert summary(verdict) == "goal_unreachable"
    assert verdict.goals is not None
    assert (verdict.goals.state, verdict.goals_elsewhere) == (Share(lit, 1), elsewhere)
    explanation = SCORER.explain(answer(*alternatives))
    assert [goal.satisfied for goal in explanation.goals] == [*verdict.goals_satisfied]
    assert any("another way" in note for note in explanation.notes) is elsewhere


@pytest.mark.parametrize(
    ("alternatives", "paid"),
    [
        # The paid branch fails after two actions for one subgoal. The reported branch has no error.
        ("at(robot, shed) or (lit(lamp) then DROP(red))", (1 / 2, True, {FaultKind.MISSING_STEP: 1}, 1)),
        # The paid branch has no error either.
        ("(LIFT(red) then DROP(red)) or lit(lamp)", (1 / 2, False, {}, 1)),
        ("at(robot, shed) or holding(blue)", (0, False, {}, 1)),
    ],
)
def test_rewards_depend_on_the_errors_of_the_branch_whose_goals_they_pay(
    alternatives: str, paid: tuple[float, bool, dict[FaultKind, int], int]
) -> None:
    earned = SCORER.score(answer(alternatives)).compute_reward_inputs((False, False))
    assert earned is not None
    assert (earned.gain, earned.ended, earned.faults, earned.added_actions) == paid


def test_a_condition_shared_by_alternatives_is_hashed_once() -> None:
    """Hashing visits each node of a formula. For thousands of alternatives this would be quadratic."""
    programs = SubgoalProgramCompiler(TASK, SCORER.lexicon, SubgoalRefiner(toy.DOMAIN), ())
    places = [f"at({thing.name}, {place.name})" for thing in SCENE.objects for place in SCENE.objects]
    programs.make_subgoal_program([read_formula(" or ".join(places), SCORER.lexicon.signature)[0]])
    found = programs.required.cache_info()
    assert (found.hits, found.misses) == (0, 1)


def test_a_subgoal_with_too_many_alternatives_is_rejected_with_the_limit() -> None:
    places = [f"at({thing.name}, {place.name})" for thing in SCENE.objects for place in SCENE.objects]
    each = " or ".join(places)
    verdict = SCORER.score(answer(*[each] * (20_000 // len(places) + 1)))
    assert summary(verdict).startswith("not_parseable parsing")
    assert verdict.error is not None
    assert (
        verdict.error.detail == "the subgoals need more than 20,000 instructions: use fewer `or` and `exists`"
    )
