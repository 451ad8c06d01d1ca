"""From demonstrations to goals, in a world written by hand."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from eai.base.errors import InputError
from eai.benchmarks.check import check_annotations
from eai.extensions.annotation.decisions import (
    GoalPatternsOfDemonstrations,
    GoalTemplate,
    UserGoalDecisionsForTaskTitle,
    _ObjectKindByClassOrProperties,
    apply_user_command_to_decisions,
    check_goals,
    count_patterns,
    derive_goals_from_demonstrations,
    find_changes_made_by_demonstration,
    find_index_of_first_met_template,
    format_user_decisions_as_toml,
    group_by_title,
    parse_pattern,
    read_ignored_predicates_and_user_decisions,
    write_user_goal_decisions_by_task_title,
)
from eai.logic.ltl_printer import format_ltl
from eai.pddl.planning import PlannerChoice
from eai.tasks.source import Source, use_tasks
from eai.tasks.task import Task
from extensions.annotation.demonstrated import CUP, DOMAIN, JAR, LAMP, shelves, shown

SHARED = [find_changes_made_by_demonstration(task, DOMAIN) for task in (CUP, JAR, LAMP)]


def told(facts: object, task: Task) -> list[str]:
    assert isinstance(facts, tuple)
    names = [thing.name for thing in task.scene.objects]
    return [f"{fact.predicate} {' '.join(names[i] for i in fact.arguments)}" for fact in facts]


@pytest.mark.parametrize(
    "text",
    [
        "ON(lamp)",
        "ONTOP({GRABBABLE, MOVABLE}, table)",
        "HOLDS(robot, {})",
        "do TOUCH",
        "inside(a.n.01, b.n.02)",
        "BETWEEN(a, {B, C}, {}, d)",
    ],
)
def test_patterns_are_read_as_they_are_written(text: str) -> None:
    assert str(parse_pattern(text)) == text


@pytest.mark.parametrize(
    "text", ["", "ON", "ON()", "ON(a b)", "ON(a,, b)", "ON({a)", "do ", "ON(a) or ON(b)"]
)
def test_a_malformed_pattern_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="expected a pattern such as"):
        parse_pattern(text)


def test_kinds_are_the_same_whatever_the_order_of_their_properties() -> None:
    assert _ObjectKindByClassOrProperties(properties=("A", "B")) == _ObjectKindByClassOrProperties(
        properties=("B", "A")
    )
    assert (
        len(
            {
                _ObjectKindByClassOrProperties(properties=("A", "B")),
                _ObjectKindByClassOrProperties(properties=("B", "A")),
                _ObjectKindByClassOrProperties("A"),
            }
        )
        == 2
    )


@pytest.mark.parametrize(
    ("task", "facts"),
    [
        (CUP, ["near robot shelf", "on cup shelf"]),
        (JAR, ["lit lamp_1", "near robot shelf", "on jar shelf"]),
        (shown("there and back", "GO lamp_1; GO shelf; GO lamp_1"), ["near robot lamp_1"]),
    ],
)
def test_a_difference_has_facts_of_changed_objects_and_new_relations(task: Task, facts: list[str]) -> None:
    assert told(find_changes_made_by_demonstration(task, DOMAIN).facts, task) == facts


def test_the_annotated_final_state_takes_precedence() -> None:
    said = replace(CUP, annotated_final=CUP.initial)
    assert find_changes_made_by_demonstration(said, DOMAIN).facts == ()


@pytest.mark.parametrize(
    ("task", "why"),
    [
        (replace(CUP, script=()), "cup: the task has no plan, so it is no demonstration"),
        (
            shown("bad", "GO shelf; LIGHT shelf"),
            "bad: step 2 of the plan cannot be executed; goals are derived from executed plans",
        ),
    ],
)
def test_a_task_without_an_executable_plan_is_no_demonstration(task: Task, why: str) -> None:
    with pytest.raises(InputError, match=re.escape(why)):
        find_changes_made_by_demonstration(task, DOMAIN)


def test_patterns_are_counted_by_class_and_by_the_properties_of_one_object() -> None:
    found = {str(pattern): times for pattern, times in count_patterns(SHARED, ["near"]).items()}
    assert found == {
        "lit(lamp)": 3,
        "on(cup, shelf)": 1,
        "on(jar, shelf)": 1,
        "on({small}, shelf)": 2,
        "on(cup, {})": 1,
        "on(jar, {})": 1,
    }


def candidate(*entries: str) -> GoalTemplate:
    """Return a candidate from entries with alternatives, such as ``lit(lamp) or on(cup, shelf)``."""
    return tuple(tuple(map(parse_pattern, entry.split(" or "))) for entry in entries)


@pytest.mark.parametrize(
    ("candidates", "numbers"),
    [
        ([("on({small}, shelf)",)], [0, 0, None]),
        ([("lit(lamp)",), ("on(cup, shelf)",)], [1, 0, 0]),
        ([("lit(lamp)", "on({small}, shelf)")], [None, 0, None]),
        ([("lit(lamp) or on(cup, shelf)",)], [0, 0, 0]),
        ([("on({bright}, shelf)",)], [None, None, None]),
        ([("do LIGHT", "do PUT")], [None, 0, None]),
        ([("do PUT", "do LIGHT")], [None, None, None]),
        ([("do LIGHT", "do LIGHT")], [None, None, 0]),
        ([("do GO or do PUT", "do PUT")], [0, 0, None]),
        ([], [None, None, None]),
    ],
)
def test_the_first_completely_met_candidate_is_assigned(
    candidates: list[tuple[str, ...]], numbers: list[int | None]
) -> None:
    meanings = [candidate(*entries) for entries in candidates]
    assert [find_index_of_first_met_template(meanings, found) for found in SHARED] == numbers


def test_goals_follow_from_all_facts_that_meet_an_entry() -> None:
    known = {"Tidy up": UserGoalDecisionsForTaskTitle((candidate("lit(lamp)", "do LIGHT"),))}
    made = list(derive_goals_from_demonstrations(group_by_title(shelves().tasks(Source())), DOMAIN, known))
    goals = [[format_ltl(goal.formula) for goal in of_task] for _, _, of_task in made]
    assert goals == [[], ["lit(lamp_1)", "LIGHT()"], ["lit(lamp_1)", "lit(lamp_2)", "LIGHT()"]]
    assert [each.problem for each in check_goals(made)] == [
        "cup: has goals, but its plan meets no candidate",
        "jar: lacks lit(lamp_1), lacks LIGHT(), has the further goal on(jar, shelf)",
        "lamp: lacks lit(lamp_2), lacks LIGHT()",
    ]


def test_an_empty_candidate_is_met_by_no_demonstration() -> None:
    (changes, *_) = SHARED
    met = candidate("on({small}, shelf)")
    assert find_index_of_first_met_template(((), met), changes) == 1
    assert find_index_of_first_met_template(((),), changes) is None


COMMANDS = ("keep 1", "drop 3 4", "or 2 5", "new", "add do LIGHT or do PUT", "add lit({bright})")


def decided(*commands: str) -> UserGoalDecisionsForTaskTitle:
    listing, chosen = GoalPatternsOfDemonstrations(SHARED, DOMAIN, ["near"]), UserGoalDecisionsForTaskTitle()
    for command in commands:
        chosen = apply_user_command_to_decisions(command, chosen, listing)
    return chosen


def test_commands_make_candidates() -> None:
    listing = GoalPatternsOfDemonstrations(SHARED, DOMAIN, ["near"])
    assert [str(pattern) for pattern in listing.patterns_in_order_shown_to_user[:3]] == [
        "lit(lamp)",
        "on({small}, shelf)",
        "on(cup, shelf)",
    ]
    assert list(listing.demonstration_counts.values())[:3] == [2, 2, 1]
    chosen = decided(*COMMANDS)
    assert chosen.candidates == (
        candidate("lit(lamp)", "on({small}, shelf) or on(cup, {})"),
        candidate("do LIGHT or do PUT", "lit({bright})"),
    )
    assert list(map(str, chosen.dropped)) == ["on(cup, shelf)", "on(jar, shelf)"]
    assert listing.find_numbers_of_undecided_patterns(chosen) == [6]


@pytest.mark.parametrize(
    ("command", "why"),
    [
        ("kep 1", "'kep' is no command: keep, or, drop, add, new, undo, done; did you mean keep?"),
        ("keep", "expected numbers of listed patterns"),
        ("keep 7", "'7': expected a number from 1 to 6"),
        ("keep x", "'x': expected a number from 1 to 6"),
        ("add lit", "expected a pattern such as"),
        ("add lot(lamp)", "'lot' is no changing predicate of 1; did you mean lit?"),
        ("add lit(lam)", "'lam' is no class; did you mean lamp?"),
        ("add lit({brigt})", "'brigt' is no property; did you mean bright?"),
        ("add do LIHT", "'LIHT' is no action; did you mean LIGHT?"),
        ("add bright(lamp)", "'bright' is no changing predicate of 1"),
        (
            "add do LIGHT or lit(lamp)",
            "an action cannot be an alternative to a state or relation; list it alone",
        ),
    ],
)
def test_a_wrong_command_is_reported_and_changes_nothing(command: str, why: str) -> None:
    with pytest.raises(InputError, match=re.escape(why)):
        decided(command)


def test_decisions_are_read_as_they_are_written(tmp_path: Path) -> None:
    path = tmp_path / "decisions.toml"
    assert read_ignored_predicates_and_user_decisions(path) == ((), {})
    made = (
        ("near",),
        {'Say "hi" \\ ok': decided(*COMMANDS), "Tidy up \U0001f9f9": UserGoalDecisionsForTaskTitle()},
    )
    write_user_goal_decisions_by_task_title(path, *made)
    assert read_ignored_predicates_and_user_decisions(path) == made
    assert path.read_text(encoding="utf-8") == format_user_decisions_as_toml(*made)
    assert [each.name for each in tmp_path.iterdir()] == ["decisions.toml"]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("without = [", "Invalid value"),
        ("witout = []", "witout: unknown; did you mean without?"),
        ('[title."T"]\ncandidates = [[["lit(lamp"]]]', "title 'T': 'lit(lamp': expected a pattern"),
        ('[title."T"]\ncandidates = [[[]]]', "title 'T': candidates: a list of patterns is empty"),
        (
            '[title."T"]\ncandidates = [["lit(lamp)"]]',
            "candidates.0.0: expected a list, found 'lit(lamp)'",
        ),
        ('[title."T"]\nkept = []', "title.T.kept: unknown"),
    ],
)
def test_a_malformed_decision_file_is_refused(tmp_path: Path, text: str, why: str) -> None:
    path = tmp_path / "decisions.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=re.escape(why)):
        read_ignored_predicates_and_user_decisions(path)


def test_an_unknown_title_is_reported() -> None:
    with pytest.raises(InputError, match="no demonstration is called 'Tidy'; did you mean Tidy up"):
        group_by_title(shelves().tasks(Source()), "Tidy")


def test_a_check_reports_wrong_goals_plans_and_operators() -> None:
    found = check_annotations(shelves(), Source(planner=PlannerChoice.BUILT_IN))
    assert [each.problem for each in found] == []
    wrong = replace(CUP, goals=LAMP.goals, annotated_final=CUP.initial)
    bad = replace(shelves(), open_tasks=use_tasks(wrong))
    found = check_annotations(bad, Source(planner=PlannerChoice.BUILT_IN))
    assert [each.problem for each in found] == [
        "cup: 1 of 1 goals do not hold in the annotated final state",
        "cup: the plan fails: a goal is missed",
        "cup: the gold operators do not solve their problem: unsolvable",
    ]
