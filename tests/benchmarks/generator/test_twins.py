"""Pairs of a possible and a provably impossible task, which lack similar facts."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path

import pytest

import eai
from benchmarks.generator.worlds import HOUSEHOLDS, PAIR_SEEDS, pairs
from eai import use_tasks
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.abilities.verdict import PlanVerdict
from eai.agents.game import Game
from eai.agents.game_setup import GameSetup
from eai.agents.play import RecordedGame, make_game_rules
from eai.agents.reference import make_setup
from eai.agents.setting import STANDARD
from eai.benchmarks.generator.spec import GeneratedTask
from eai.benchmarks.generator.twins import ImpossibleMinusPossibleTasks, make_possible_impossible_pair_chooser
from eai.benchmarks.registry import find_benchmark
from eai.planning.planner import Planner
from eai.planning.search import Limits
from eai.tasks.goal_test import solves_task
from eai.tasks.planning import find_plan, is_impossible
from eai.tasks.special import PossiblyImpossibleTaskMark
from eai.tasks.task_files import find_mistakes_in_task
from eai.tasks.task_lines import make_task_from_line, read_task_line, write_task_line

pytestmark = pytest.mark.usefixtures("data_store")


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_one_task_of_a_pair_has_a_plan_and_the_other_provably_has_no_plan(like: str) -> None:
    domain = find_benchmark(like).domain
    assert len(pairs(like)) == len(PAIR_SEEDS[like])
    for made in pairs(like):
        assert made.paired is not None
        solved, unsolved = made.task, made.paired.task
        assert solves_task(domain, solved, solved.script)
        assert not is_impossible(solved, domain)
        assert (solved.special, unsolved.script) == (PossiblyImpossibleTaskMark(()), ())


@pytest.mark.sweep
@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_a_planner_finds_no_plan_for_an_impossible_task(like: str) -> None:
    domain = find_benchmark(like).domain
    for made in pairs(like):
        assert made.paired is not None
        assert find_plan(made.paired.task, Planner(domain), Limits(500)).plan == ()


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_the_tasks_of_a_pair_differ_in_the_missing_property(like: str) -> None:
    for made in pairs(like):
        assert made.paired is not None
        solved, unsolved = made.task, made.paired.task
        assert (solved.instruction, solved.goals, solved.title) == (
            unsolved.instruction,
            unsolved.goals,
            unsolved.title,
        )
        (lost,) = set(solved.initial.facts()) - set(unsolved.initial.facts())
        (kept,) = set(unsolved.initial.facts()) - set(solved.initial.facts())
        assert lost.predicate == kept.predicate
        named = solved.find_objects_named_in_goals(solved.goals)
        assert (lost.arguments[0] in named) == (kept.arguments[0] in named)
        assert isinstance(unsolved.special, PossiblyImpossibleTaskMark)
        (missing,) = unsolved.special.missing
        assert missing == f"{lost.predicate}({solved.scene.objects[lost.arguments[0]].name})"
        assert {solved.id, unsolved.id} == {f"{solved.title}-a", f"{solved.title}-b"}


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_pairs_are_written_read_and_checked(like: str) -> None:
    domain = find_benchmark(like).domain
    made = pairs(like)[0]
    assert made.paired is not None
    for task in (made.task, made.paired.task):
        line = write_task_line(task, like, domain)
        read = make_task_from_line(read_task_line(line), domain)
        assert write_task_line(read, like, domain) == line
        assert list(find_mistakes_in_task(read, domain)) == []
    names = {made.task.id.replace(made.task.title, ""), made.paired.task.id.replace(made.task.title, "")}
    assert names == {"-a", "-b"}


def test_only_the_possible_task_has_questions_about_subgoals(
    tmp_path: Path,
) -> None:
    domain, made = find_benchmark("behavior").domain, pairs("behavior")[0]
    assert made.paired is not None
    lines = [write_task_line(task, "behavior", domain) for task in (made.task, made.paired.task)]
    (tmp_path / "tasks.jsonl").write_text("\n".join(lines), encoding="utf-8")
    suites = [eai.open(f"{tmp_path}/", ability) for ability in PAPER_ABILITIES[:3]]
    asked = {suite.ability: set(suite.task_ids) for suite in suites}
    both = {made.task.id, made.paired.task.id}
    assert asked[Ability.GOAL_INTERPRETATION] == asked[Ability.ACTION_SEQUENCING] == both
    assert asked[Ability.SUBGOAL_DECOMPOSITION] == {made.task.id}


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_the_category_does_not_reveal_the_impossible_task(like: str) -> None:
    """In many pairs, no category is much more often on one side."""
    (made,) = pairs(like)
    assert made.paired is not None
    facts = {*made.task.initial.facts(), *made.paired.task.initial.facts()}
    whole = replace(made.task, initial=made.task.scene.state(facts))
    assert solves_task(find_benchmark(like).domain, whole, whole.script)
    planner, leaning = Planner(find_benchmark(like).domain), ImpossibleMinusPossibleTasks()
    found = [
        make_possible_impossible_pair_chooser(GeneratedTask(whole, {}), planner, (), random.Random(seed))(
            leaning
        )
        for seed in range(4)
    ]
    assert any(found)
    assert all(abs(number) <= 1 for number in leaning.values())


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_an_acting_agent_may_refuse_and_its_budget_reveals_nothing(like: str) -> None:
    (made, *_), benchmark = pairs(like), find_benchmark(like)
    assert made.paired is not None
    setups = [
        make_setup(task, benchmark, make_game_rules(STANDARD)) for task in (made.task, made.paired.task)
    ]
    assert {setup.action_limit for setup in setups} == {50}
    for setup in setups:
        is_right = setup.task.has_no_plan
        assert "IMPOSSIBLE(predicate(object))" in setup.opening
        assert upper(setup) == (True, "refused" if is_right else "done")
        game = Game(setup)
        turn = game.act("IMPOSSIBLE(something is missing)")
        assert (game.ended, game.won, turn.terminated, turn.reward) == ("refused", is_right, True, is_right)
        assert (game.metrics["success"], game.metrics["progress"]) == (is_right, is_right)
        episode = RecordedGame(setup, 0, 1)
        episode.play_command("IMPOSSIBLE(something is missing)")
        suite = eai.open(replace(benchmark, open_tasks=use_tasks(setup.task)), "acting")
        verdict = suite.score(setup.task.id, episode.write_as_json_text("stopped"))
        assert isinstance(verdict, PlanVerdict)
        assert (verdict.success, verdict.refused, verdict.is_task_declined_by_answer) == (
            is_right,
            "something is missing",
            True,
        )


def upper(setup: GameSetup) -> tuple[bool, str | None]:
    """Return whether an agent with the reference commands wins, and the reason for the end."""
    game = Game(setup)
    for command in (*(setup.reference.commands or ()), "DONE"):
        if not game.is_over:
            game.act(command)
    return game.won, game.ended


def test_a_refusal_is_no_command_in_other_tasks() -> None:
    made = pairs("behavior")[0]
    setup = make_setup(
        replace(made.task, special=None), find_benchmark("behavior"), make_game_rules(STANDARD)
    )
    assert "IMPOSSIBLE" not in setup.opening
    assert Game(setup).act("IMPOSSIBLE(why)").info["fault"] == "hallucination"
