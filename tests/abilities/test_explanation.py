from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

import pytest

from benchmarks.plan_scorers import virtualhome_scorer
from benchmarks.virtualhome.household import make_task
from eai.abilities.explanation import (
    AtomOrAction,
    GoalReport,
    StepReport,
    VerdictExplanation,
    find_predicate_names,
    map_missed_goals_to_similar_facts,
    parse_statement,
)
from eai.abilities.reports import report_goal_parts, report_steps
from eai.logic.formula import Atom, Constant, Occurs, Or, Then
from eai.logic.ltl import parse
from eai.logic.rewriting import standardize_variable_names
from eai.results.codec import dataclass_to_json
from eai.tasks.goal_text import write_goal
from eai.tasks.task import Task
from eai.world import Action, Episode, SlipSampler
from eai.world.execution import execute_plan
from logic.bddl_text import read_condition

Explain: TypeAlias = Callable[[str, Task], VerdictExplanation]


def explain(text: str, task: Task | None = None) -> VerdictExplanation:
    return virtualhome_scorer(task or make_task()).explain(text)


@pytest.fixture
def explained() -> Explain:
    """Explain an answer under `strict`. Tests of other protocols replace this fixture."""
    return explain


def test_a_step_report_lists_changes_of_the_tasks_objects(explained: Explain) -> None:
    task = make_task("NEXT_TO character.65 fridge.10", relevant=["fridge.10"])
    (step,) = explained('{"OPEN": ["fridge"]}', task).steps
    added, removed = ("OPEN(fridge.10)",), ("CLOSED(fridge.10)",)
    assert step == StepReport(
        "OPEN(fridge.10)", "executed", added=added, removed=removed, call=parse_statement("OPEN(fridge.10)")
    )


def test_changes_to_other_objects_are_only_counted() -> None:
    task = make_task(relevant=["fridge.10"])
    (step,) = explain('{"WALK": ["fridge"]}', task).steps
    assert "NEXT_TO(character.65, fridge.10)" in step.added
    assert not any("milk" in fact or "kitchen" in fact for fact in step.added)
    assert step.hidden_changes > 0


def test_explanations_leave_out_predicates_hidden_from_prompts() -> None:
    everything = [thing.name for thing in make_task().scene.objects]
    task = make_task("NEXT_TO character.65 cup.13", relevant=everything)
    (step,) = explain('{"GRAB": ["cup"]}', task).steps
    assert "HOLDS_RH(character.65, cup.13)" in step.added
    assert not any(fact.startswith("TAKEN_FROM") for fact in step.added)
    assert step.hidden_changes == 0, "the memory of where it was is no change that is hidden"


def test_lost_neighbours_are_only_counted_unless_a_goal_names_them() -> None:
    everything = [thing.name for thing in make_task().scene.objects]
    asked = make_task("ONTOP cup.13 fridge.10", relevant=everything)
    cup, fridge, milk = (asked.scene.index[name] for name in ("cup.13", "fridge.10", "milk.11"))
    near = [("NEXT_TO", pair) for pair in ((cup, fridge), (fridge, cup), (cup, milk), (milk, cup))]
    task = replace(asked, initial=asked.scene.state([*asked.initial.facts(), *near]))
    *_, step = explain('{"WALK": ["cup"], "GRAB": ["cup"]}', task).steps
    assert "NEXT_TO(cup.13, fridge.10)" in step.removed
    assert not any("milk" in fact for fact in step.removed)
    assert step.hidden_changes >= 2


def test_relations_of_the_agent_to_itself_are_not_reported() -> None:
    task = make_task("NEXT_TO cup.13 character.65", "NEXT_TO character.65 cup.13", relevant=["cup.13"])
    task = replace(task, relevant=(*task.relevant, task.scene.index["character.65"]))
    (step,) = explain('{"FIND": ["character"]}', task).steps
    assert not any("character.65, character.65" in fact for fact in step.added)


def test_a_failed_step_names_the_check_and_the_objects_and_is_the_last() -> None:
    steps = explain('{"WALK": ["table"], "PUTIN": ["cup", "fridge"], "OPEN": ["fridge"]}').steps
    assert [step.outcome for step in steps] == ["executed", "missing_step"]
    assert steps[-1] == StepReport(
        "PUTIN(cup.13, fridge.10)",
        "missing_step",
        "the character does not hold cup.13",
        call=parse_statement("PUTIN(cup.13, fridge.10)"),
    )


def test_the_closed_container_of_an_object_is_named() -> None:
    *_, step = explain('{"WALK": ["milk"], "GRAB": ["milk"]}').steps
    assert (step.outcome, step.reason) == (
        "missing_step",
        "milk.11 is inside something that is closed: fridge.10",
    )


def test_a_wrong_order_names_the_state_in_which_the_step_was_possible() -> None:
    steps = explain('{"WALK": ["cup"], "WALK": ["bed"], "GRAB": ["cup"]}').steps
    assert steps[-1].outcome == "wrong_order"
    assert steps[-1].earlier == "what it lacks held after step 1, WALK(cup.13)"


def test_skipped_steps_are_numbered() -> None:
    steps = explain('{"STANDUP": [], "WALK": ["cup"], "WALK": ["bed"], "GRAB": ["cup"]}').steps
    assert steps[-1].earlier == "what it lacks held after step 2, WALK(cup.13)"


def test_parts_of_a_temporal_goal_are_dated_by_step_numbers() -> None:
    task = make_task()
    domain = virtualhome_scorer(task).domain
    fridge = (task.scene.index["fridge.10"],)
    plan = [Action("STANDUP", ()), Action("WALK", fridge), Action("STANDUP", ()), Action("OPEN", fridge)]
    course = execute_plan(domain, task.initial, plan)
    assert [step.is_executed for step in course.steps] == [False, True, False, True]
    name = Constant("fridge.10")
    closed, opened = Atom("CLOSED", (name,)), Atom("OPEN", (name,))
    near = Atom("NEXT_TO", (Constant("character.65"), name))
    reports = report_goal_parts(Then((closed, near, opened)), course)
    assert [part.first_met_time_text for part in reports] == [
        "at the start",
        "after step 2",
        "after step 4",
    ]
    reports = report_goal_parts(Then((near, Occurs("OPEN", (name,)), opened)), course)
    assert [part.first_met_time_text for part in reports] == ["after step 2", "", ""], (
        "it is opened in the state of part 1"
    )
    reports = report_goal_parts(Then((closed, Occurs("OPEN", (name,)), Occurs("OPEN") | opened)), course)
    assert [part.first_met_time_text for part in reports] == ["at the start", "at step 4", "after step 4"]


def test_steps_after_a_slip_are_reported_with_their_changes() -> None:
    task = make_task("NEXT_TO character.65 fridge.10", relevant=["fridge.10"])
    domain = virtualhome_scorer(task).domain
    episode = Episode(domain, task.initial, SlipSampler(0.5, "1_1", seed=3))
    fridge = (task.scene.index["fridge.10"],)
    for _ in range(2):
        episode.act(Action("OPEN", fridge))
    slipped, opened = report_steps(task, domain, episode.trajectory)
    assert (slipped.outcome, slipped.reason) == ("slip", "it was possible, but it did not work")
    assert (opened.outcome, opened.added) == ("executed", ("OPEN(fridge.10)",))


def test_a_wrong_order_names_the_start_if_the_step_was_possible_then() -> None:
    task = make_task("NEXT_TO character.65 book.16", "NEXT_TO book.16 character.65")
    steps = explain('{"WALK": ["fridge"], "GRAB": ["book"]}', task).steps
    assert (steps[-1].outcome, steps[-1].earlier) == (
        "wrong_order",
        "what it lacks held at the start",
    )


def test_an_additional_step_is_reported_and_the_plan_continues() -> None:
    steps = explain('{"STANDUP": [], "WALK": ["fridge"]}').steps
    assert [step.outcome for step in steps] == ["additional_step", "executed"]
    assert steps[0].reason == "the character stands already"


def test_an_explanation_reports_every_goal(explained: Explain) -> None:
    goals = ("state CLOSED fridge.10", "relation ONTOP cup.13 bed.20", "action LOOKAT|WALK")
    explanation = explained('{"WALK": ["fridge"]}', make_task(goals=goals))
    assert explanation.goals == (
        GoalReport("state", "CLOSED(fridge.10)", satisfied=True),
        GoalReport("relation", "ONTOP(cup.13, bed.20)", satisfied=False),
        GoalReport("action", "LOOKAT or WALK", satisfied=True),
    )


@pytest.mark.parametrize(
    ("text", "notes"),
    [
        ("I cannot.", ("parsing: there is no object or list of actions with their objects",)),
        ('{"FLY": ["fridge"]}', ("hallucination: step 1: FLY is not an action",)),
        (
            '```{"WALK": []}```',
            ("read with repair: code_fence", "argument_number: step 1: WALK takes 1 object, not 0"),
        ),
        ('{"WALK": [[1]]}', ("hallucination: step 1: WALK: there is no [1]",)),
    ],
)
def test_an_answer_that_never_runs_is_explained_in_a_note(text: str, notes: tuple[str, ...]) -> None:
    unmet = (GoalReport("state", "OPEN(fridge.10)", satisfied=False),)
    assert explain(text) == VerdictExplanation(notes=notes, goals=unmet)


def test_plans_for_excluded_tasks_are_explained() -> None:
    explanation = explain('{"WALK": ["fridge"]}', make_task(goals=()))
    assert explanation.notes == ("excluded: the task has no goals",)
    assert [step.outcome for step in explanation.steps] == ["executed"]


def test_an_explanation_can_be_written_as_json() -> None:
    explanation = explain('```{"WALK": ["fridge"], "OPEN": ["fridge"]}```')
    wire = json.loads(json.dumps(dataclass_to_json(explanation)))
    assert wire["notes"] == ["read with repair: code_fence"]
    assert wire["steps"][1]["added"] == ["OPEN(fridge.10)"]
    assert wire["steps"][1]["call"] == {"name": "OPEN", "arguments": ["fridge.10"], "positive": True}
    of_goal = {"kind": "state", "goal": "OPEN(fridge.10)", "satisfied": True, "why": ""}
    assert wire["goals"] == [{**of_goal, "predicates": ["OPEN"]}]


@pytest.mark.parametrize(
    ("formula", "text"),
    [
        (Atom("ON", (Constant("tv.1"),)), "ON(tv.1)"),
        (Occurs("GRAB"), "GRAB"),
        (Or((Occurs("WASH"), Occurs("RINSE"))), "WASH or RINSE"),
    ],
)
def test_the_names_in_a_goal_are_read_from_its_text(formula: Atom | Occurs | Or, text: str) -> None:
    assert write_goal(formula) == text


@pytest.mark.parametrize(
    ("condition", "text"),
    [
        ("(forall (?bowl.n.01 - bowl.n.01) (open ?bowl.n.01))", "forall x: bowl.n.01. (open(x))"),
        (
            "(forpairs (?jar.n.01 - jar.n.01) (?rag.n.01 - rag.n.01) (inside ?rag.n.01 ?jar.n.01))",
            "forpairs x: jar.n.01, y: rag.n.01. (inside(y, x))",
        ),
        (
            "(forall (?jar.n.01 - jar.n.01) (exists (?jar.n.01 - jar.n.01) (under ?jar.n.01 x)))",
            "forall y: jar.n.01. (exists z: jar.n.01. (under(z, x)))",
        ),
        ("(or (open ?a) (and (open ?b) (not (open ?c))))", "open(a) or open(b) and not open(c)"),
    ],
)
def test_a_quantified_goal_is_a_text_that_can_be_read(condition: str, text: str) -> None:
    formula = read_condition(condition)
    assert write_goal(formula) == text
    assert parse(text) == standardize_variable_names(formula)


@pytest.mark.parametrize(
    ("added", "removed", "goal", "near"),
    [
        (("INSIDE(a, b)",), (), "ONTOP(a, b)", ("INSIDE(a, b)",)),
        (("ONTOP(a, c)",), (), "ONTOP(a, b)", ("ONTOP(a, c)",)),
        (("ONTOP(a, c)", "INSIDE(a, b)"), (), "ONTOP(a, b)", ("INSIDE(a, b)", "ONTOP(a, c)")),
        (("OPEN(a)",), (), "ON(a)", ()),
        (("NEXT_TO(a, b)", "NEXT_TO(b, a)"), (), "ONTOP(a, b)", ()),
        (("INSIDE(b, a)",), (), "ONTOP(a, b)", ()),
        (("INSIDE(c, b)",), (), "ONTOP(a, b)", ()),
        (("INSIDE(a, b)",), ("INSIDE(a, b)",), "ONTOP(a, b)", ()),
        (("INSIDE(a, b)",), (), "exists x. (ONTOP(a, x))", ()),
        (("INSIDE(a, b)",), (), "GRAB or TAKE", ()),
        ((), (), "ONTOP(a, b)", ()),
    ],
)
def test_a_near_miss_is_another_fact_about_the_goals_objects(
    added: tuple[str, ...], removed: tuple[str, ...], goal: str, near: tuple[str, ...]
) -> None:
    steps = (
        StepReport("A()", "executed", added=added, call=parse_statement("A()")),
        StepReport("B()", "executed", removed=removed, call=parse_statement("B()")),
    )
    missed = VerdictExplanation(steps=steps, goals=(GoalReport("relation", goal, False),))
    assert map_missed_goals_to_similar_facts(missed) == ({goal: near} if near else {})


def test_a_state_that_ended_the_wanted_state_is_a_near_miss() -> None:
    """An opened object is no near miss of an object that must be switched on, nor is a held object."""
    steps = (
        StepReport(
            "SWITCHOFF(a)",
            "executed",
            added=("OFF(a)",),
            removed=("ON(a)",),
            call=parse_statement("SWITCHOFF(a)"),
        ),
        StepReport(
            "OPEN(a)", "executed", added=("OPEN(a)",), removed=("CLOSED(a)",), call=parse_statement("OPEN(a)")
        ),
        StepReport("GRASP(a)", "executed", added=("in_right_hand(a)",), call=parse_statement("GRASP(a)")),
    )
    missed = VerdictExplanation(steps=steps, goals=(GoalReport("state", "ON(a)", False),))
    assert map_missed_goals_to_similar_facts(missed) == {"ON(a)": ("OFF(a)",)}


def test_a_goal_that_is_reached_has_no_near_miss() -> None:
    steps = (
        StepReport("A()", "executed", added=("INSIDE(a, b)", "ONTOP(a, b)"), call=parse_statement("A()")),
    )
    assert (
        map_missed_goals_to_similar_facts(
            VerdictExplanation(steps=steps, goals=(GoalReport("relation", "ONTOP(a, b)", True),))
        )
        == {}
    )


def test_steps_and_goals_are_values_beside_their_texts() -> None:
    goals = ("state CLOSED fridge.10", "relation ONTOP cup.13 bed.20", "action LOOKAT|WALK")
    found = explain('{"WALK": ["table"], "PUTIN": ["cup", "fridge"]}', make_task(goals=goals))
    calls = [AtomOrAction("WALK", ("table.12",)), AtomOrAction("PUTIN", ("cup.13", "fridge.10"))]
    assert [(step.call.name, step.call.arguments) for step in found.steps if step.call] == [
        (call.name, call.arguments) for call in calls
    ]
    assert [goal.predicates for goal in found.goals] == [("CLOSED",), ("ONTOP",), ("LOOKAT", "WALK")]
    assert all(parse_statement(step.action) == step.call for step in found.steps)
    assert all(find_predicate_names(goal.goal) == goal.predicates for goal in found.goals)


@pytest.mark.parametrize(
    ("text", "call"),
    [
        ("open(jar_0)", AtomOrAction("open", ("jar_0",))),
        ("not open(jar_0)", AtomOrAction("open", ("jar_0",), positive=False)),
        ("PUTIN(soap.1, box.2)", AtomOrAction("PUTIN", ("soap.1", "box.2"))),
        ("STANDUP()", AtomOrAction("STANDUP", ())),
        ("TOUCH", AtomOrAction("TOUCH", None)),
        ("{'state': 'ON'}", AtomOrAction("{'state': 'ON'}", None)),
    ],
)
def test_atoms_and_steps_are_read_again(text: str, call: AtomOrAction) -> None:
    assert parse_statement(text) == call
