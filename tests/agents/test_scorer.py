"""Episodes are replayed by strict rules; their measures, and verdicts that agree with those of plans."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest

from agents.switches import DOMAIN, SWITCHES, WON, initial
from eai import Benchmark, InputError, Reward, make_task, use_tasks
from eai.abilities.plan_repairer import PlanRepairer
from eai.abilities.protocol import Ability
from eai.agents.declaration import compute_contributions_to_metrics
from eai.agents.game import Game
from eai.agents.game_setup import GameSetup, ReferenceSolution
from eai.agents.play import EpisodeFactory, RecordedGame
from eai.agents.reference import find_reference_solution, make_setup
from eai.agents.rules import STANDARD, GameRules
from eai.agents.scorer import NO_REFERENCE
from eai.agents.setting import ACTING, AgentSetting
from eai.agents.verdict import EpisodeTurn, EpisodeVerdict
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite, open_suite
from eai.logic.formula import Atom, Constant, Not
from eai.results.batch import Scoring
from eai.results.codec import record_from_json, record_to_json
from eai.results.record import Record
from eai.results.responses import Response
from eai.results.reward import Shaping
from eai.tasks.goal_test import GoalTest
from eai.world.fault import FaultKind


@pytest.fixture
def suite() -> Suite:
    return open_suite(SWITCHES, ACTING)


def episode(
    benchmark: Benchmark, task_id: str, commands: list[str], setting: AgentSetting | None = None
) -> str:
    arena = EpisodeFactory(benchmark, setting or AgentSetting())
    play = arena.begin_episode(open_suite(benchmark, ACTING).tasks[task_id])
    for command in commands:
        play.play_command(command)
    return play.write_as_json_text("stopped")


def verdict_of(suite: Suite, text: str) -> EpisodeVerdict:
    verdict = suite.score(suite.task_ids[0], text)
    assert isinstance(verdict, EpisodeVerdict)
    return verdict


def record_of(suite: Suite, text: str) -> Record:
    """Return the record of an episode, written and read again."""
    (record,) = Scoring().score_records(suite, "model", [Response(suite.task_ids[0], text)])
    return record_from_json(json.loads(json.dumps(record_to_json(record))))


def reference(suite: Suite) -> list[str]:
    setup = EpisodeFactory(suite.benchmark).make_setup(suite.tasks[suite.task_ids[0]])
    return [*(setup.reference.commands or ())]


def test_an_episode_is_won_only_if_the_agent_says_so(suite: Suite) -> None:
    commands = reference(suite)
    said = verdict_of(suite, episode(SWITCHES, suite.task_ids[0], [*commands, "DONE"]))
    assert (said.success, said.ended, said.declared, said.executable) == (True, "done", True, True)
    assert len(said.action_turns) == len(commands)
    unsaid = verdict_of(suite, episode(SWITCHES, suite.task_ids[0], commands))
    assert (unsaid.success, unsaid.ended, unsaid.reached) == (False, "stopped", True)
    assert compute_contributions_to_metrics(unsaid)["undeclared"].numerator == 1
    early = verdict_of(suite, "DONE")
    assert (early.success, early.ended) == (False, "done")
    assert compute_contributions_to_metrics(early)["declared_early"].numerator == 1


def test_an_episode_that_ends_at_the_goal_counts_its_last_action(suite: Suite) -> None:
    setup = make_setup(suite.tasks[suite.task_ids[0]], SWITCHES, GameRules(until="goal"))
    play = RecordedGame(setup, seed=0, epoch=1)
    for command in WON:
        play.play_command(command)
    verdict = verdict_of(suite, play.write_as_json_text("stopped"))
    assert (verdict.success, verdict.ended, verdict.declared) == (True, "goal", False)
    assert len(verdict.action_turns) == len(WON)
    shares = compute_contributions_to_metrics(verdict)
    assert (shares["spl"].numerator, shares["undeclared"].numerator) == (3 / 4, 0)


def test_an_action_after_the_last_allowed_one_is_not_counted(suite: Suite) -> None:
    commands = ["GO(hall)", "GO(shed)"] * 20
    verdict = verdict_of(suite, "\n".join(commands[: 1 + (verdict_of(suite, "").budget or 0)]))
    assert (verdict.ended, len(verdict.action_turns)) == ("steps", verdict.budget)
    assert not verdict.turns[-1].is_action


def test_lines_of_commands_are_an_episode_in_the_standard_setting(suite: Suite) -> None:
    commands = [*reference(suite), "DONE"]
    by_line = verdict_of(suite, "\n".join(commands))
    assert by_line == replace(verdict_of(suite, episode(SWITCHES, suite.task_ids[0], commands)), harness="")


def test_a_question_in_an_unambiguous_task_is_not_declining(suite: Suite) -> None:
    verdict = verdict_of(suite, "ASK(which one?)")
    assert (verdict.turns[0].fault, verdict.is_task_declined_by_answer) == (FaultKind.HALLUCINATION, False)


def test_look_lists_present_facts_with_any_feedback(suite: Suite) -> None:
    play = EpisodeFactory(SWITCHES, AgentSetting(observe="full", feedback="outcome")).begin_episode(
        suite.tasks[suite.task_ids[0]]
    )
    assert play.play_command("PRESS(lamp)").startswith("PRESS(lamp): done.\n")
    assert "\nlit(lamp)" in play.play_command("LOOK")


def test_the_text_of_an_episode_earns_no_reward(suite: Suite) -> None:
    with pytest.raises(InputError, match="answers to acting have no reward"):
        Reward(suite)


def test_no_text_of_a_model_makes_an_episode_unreadable(suite: Suite) -> None:
    play = EpisodeFactory(SWITCHES).begin_episode(suite.tasks[suite.task_ids[0]])
    play.play_command("GO(\ud800)", "\u2028 \udfff \x00")
    verdict = verdict_of(suite, play.write_as_json_text("stopped"))
    assert (verdict.error, verdict.turns[0].said) == (None, "GO(?)")


def test_an_episode_that_does_not_replay_fails_and_is_counted(suite: Suite) -> None:
    won = json.loads(episode(SWITCHES, suite.task_ids[0], [*reference(suite), "DONE"]))
    other, first, after = (json.loads(json.dumps(won)) for _ in range(3))
    other["turns"][1]["told"] = "0" * 64
    first["opening"] = "0" * 64
    after["turns"].append({"said": "DONE"})
    wanted = {
        "turn 2: the observation is another one": other,
        "the first observation: the observation is another one": first,
        f"turn {len(won['turns']) + 1}: the episode is over": after,
    }
    for place, changed in wanted.items():
        verdict = verdict_of(suite, json.dumps(changed))
        assert verdict.error is not None
        assert verdict.error.detail.startswith(f"unreplayable: {place}")
        assert len(verdict.error.detail.splitlines()) == 1
        assert (verdict.excluded, verdict.success, verdict.executable, verdict.declared) == (
            None,
            *[False] * 3,
        )
        shares = compute_contributions_to_metrics(verdict)
        assert (shares["unreplayable"], shares["partial_success"]) == ((1, 1), (0, 1))
        lost = ("success", "spl", "undeclared", "declared_early", *(f"within_{k}" for k in ("1x", "2x")))
        assert {name: shares[name] for name in lost} == dict.fromkeys(lost, (0, 1))
        assert shares["total_goal"] == (
            0,
            compute_contributions_to_metrics(verdict_of(suite, "DONE"))["total_goal"][1],
        )
        assert record_of(suite, json.dumps(changed)).verdict == verdict
    assert compute_contributions_to_metrics(verdict_of(suite, json.dumps(won)))["unreplayable"] == (0, 1)


def test_an_episode_has_the_partial_success_of_its_end(suite: Suite) -> None:
    task_id, commands = suite.task_ids[0], reference(suite)
    won = verdict_of(suite, episode(SWITCHES, task_id, [*commands, "DONE"]))
    assert won.partial is not None
    assert won.partial.numerator == won.partial.denominator
    assert compute_contributions_to_metrics(won)["partial_success"] == (1, 1)
    idle = verdict_of(suite, episode(SWITCHES, task_id, ["DONE"]))
    at_start = GoalTest(suite.tasks[task_id])
    initial = suite.tasks[task_id].initial
    assert idle.partial == at_start.find_partial_success(
        initial, (), at_start.evaluate_each_goal(initial, ())
    )
    never = verdict_of(suite, episode(SWITCHES, task_id, []))
    assert never.partial == at_start.partial_success_of_unexecuted_answer


def test_turns_before_the_first_difference_are_counted(suite: Suite) -> None:
    text = json.loads(episode(SWITCHES, suite.task_ids[0], ["FLY(box)", "FLY(box)", "DONE"]))
    text["turns"][1]["told"] = "0" * 64
    verdict = verdict_of(suite, json.dumps(text))
    assert (len(verdict.turns), compute_contributions_to_metrics(verdict)["impossible"]) == (2, (2, 2))
    outlook = suite.scorer(suite.task_ids[0]).assess(json.dumps(text)).analyze_failure
    assert outlook is not None
    assert compute_contributions_to_metrics(outlook(100))["outlook_unknown"] == (1, 1)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "changed",
    [
        *({"rules": {"budget": number}} for number in (1e308, -1, 101, "1e400", "nan")),
        *({"rules": {"max_steps": number}} for number in (0, 10**9, 10**400, 1.5)),
        *({"rules": {name: number}} for name in ("slip", "gamma") for number in (-0.1, 2, "inf", "nan")),
        *({name: number} for name in ("seed", "epoch", "begun") for number in (2**64, 10**4000, 0.5, "x")),
        *({name: -1} for name in ("epoch", "begun")),
        *({"harness": name} for name in ("...", "x" * 101, 3)),
        {"turns": [{"said": "DONE"}] * 100_001},
        {"rules": {"observe": "partial", "feedback": "outcome"}},
        {"oppening": "0" * 64},
        {"turns": [{"said": "DONE", "tolled": "0" * 64}]},
    ],
    ids=lambda changed: str(changed)[:40],
)
def test_an_episode_with_a_value_out_of_bounds_is_a_parsing_error(
    suite: Suite, changed: dict[str, Any]
) -> None:
    verdict = verdict_of(suite, json.dumps({"turns": [{"said": "DONE"}], **changed}))
    assert verdict.error is not None
    assert (verdict.excluded, verdict.error.kind, verdict.success) == (None, FaultKind.PARSING, False)
    assert verdict.error.detail.startswith(f"{next(iter(changed))}")
    assert compute_contributions_to_metrics(verdict)["success"] == (0, 1)


def test_constants_that_are_not_json_make_an_episode_a_parsing_error(suite: Suite) -> None:
    for number in ("NaN", "Infinity", "-Infinity", "1e999"):
        text = f'{{"turns": [{{"said": "DONE"}}], "rules": {{"budget": {number}}}}}'
        assert getattr(verdict_of(suite, text).error, "kind", None) is FaultKind.PARSING
    broken = verdict_of(suite, '{"turns": 3}')
    assert getattr(broken.error, "kind", None) is FaultKind.PARSING
    many = verdict_of(suite, "LOOK\n" * 100_001)
    assert "at most 100,000 turns" in getattr(many.error, "detail", "")


def test_a_replay_pays_nothing_and_lists_no_possible_actions(
    suite: Suite, monkeypatch: pytest.MonkeyPatch
) -> None:
    rules = GameRules(reward=Shaping.REPAIR, gamma=0.5, admissible=True, until="done")
    play = RecordedGame(make_setup(suite.tasks[suite.task_ids[0]], SWITCHES, rules), seed=0, epoch=1)
    for command in [*reference(suite), "DONE"]:
        play.play_command(command)

    def refuse(self: object, *_: object) -> None:
        raise AssertionError("only the player needs this")

    monkeypatch.setattr(PlanRepairer, "compute_closeness_to_success", refuse)
    monkeypatch.setattr(Game, "list_admissible_commands", refuse)
    verdict = verdict_of(suite, play.write_as_json_text("stopped"))
    assert (verdict.error, verdict.success, len(verdict.turns)) == (None, True, len(play.turns))


def test_faults_are_counted_by_kind_and_turn(suite: Suite) -> None:
    commands = ["FLY(box)", *reference(suite), "DONE"]
    verdict = verdict_of(suite, episode(SWITCHES, suite.task_ids[0], commands))
    assert verdict.turns[0].fault is FaultKind.HALLUCINATION
    assert verdict.turns[0].same_as == 0
    shares = compute_contributions_to_metrics(verdict)
    tried = len(commands) - 1
    assert shares["hallucination"] == shares["impossible"] == shares["loops"] == (1, tried)
    assert shares["recovered"] == shares["won_after_fault"] == (1, 1)


def test_measures_of_length_follow_their_definitions() -> None:
    turn = EpisodeTurn("", "", is_action=True, fault=None, slipped=False, goals="", same_as=None)
    verdict = EpisodeVerdict(success=True, turns=(turn,) * 6, shortest=4)
    shares = {name: share.numerator for name, share in compute_contributions_to_metrics(verdict).items()}
    assert shares["spl"] == pytest.approx(4 / 6)
    within = [shares[name] for name in ("within_1x", "within_1.5x", "within_2x", "within_4x")]
    assert within == [0, 1, 1, 1]
    unknown = compute_contributions_to_metrics(replace(verdict, shortest=None))
    assert unknown["spl"] == unknown["within_2x"] == (0, 0)


def test_a_record_keeps_the_turns(suite: Suite) -> None:
    text = episode(SWITCHES, suite.task_ids[0], [*reference(suite), "DONE"])
    answers = [Response(suite.task_ids[0], text)]
    (record,) = Scoring().score_records(suite, "model", answers, explanations=True)
    assert record_from_json(json.loads(json.dumps(record_to_json(record)))) == record
    assert record.explanation is not None
    assert [step.action for step in record.explanation.steps] == [*reference(suite), "DONE"]


@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_a_played_plan_has_the_verdict_of_the_plan(name: str) -> None:
    benchmark = find_benchmark(name)
    suite, plans = open_suite(benchmark, ACTING), open_suite(benchmark, Ability.ACTION_SEQUENCING)
    arena = EpisodeFactory(benchmark, AgentSetting(view="task", observe="full", feedback="facts"))
    for task_id in suite.task_ids[1::40]:
        task = suite.tasks[task_id]
        write = arena.make_setup(task).commands.write_command
        for plan in (task.script, task.script[:-1], task.script[1:]):
            text = benchmark.notation.plans.join(benchmark.notation.plans.write(plan, task.scene))
            as_plan = plans.score(task_id, text)
            play = arena.begin_episode(task)
            for command in [*map(write, plan), "DONE"]:
                play.play_command(command)
            played = suite.score(task_id, play.write_as_json_text("stopped"))
            assert isinstance(played, EpisodeVerdict)
            if as_plan.error is None:
                assert (played.success, played.goals) == (as_plan.success, as_plan.goals)  # type: ignore[attr-defined]
            else:
                faults = [turn.fault for turn in played.turns if turn.fault is not None]
                assert as_plan.error.kind in faults


def test_the_rules_that_an_episode_names_do_not_exclude_its_task(
    suite: Suite, monkeypatch: pytest.MonkeyPatch
) -> None:
    def without_commands(setup: GameSetup) -> ReferenceSolution:
        known = find_reference_solution(setup)
        return known if setup.rules == STANDARD else known._replace(commands=None)

    monkeypatch.setattr("eai.agents.reference.find_reference_solution", without_commands)
    make_setup.cache_clear()
    text = '{"turns": [{"said": "DONE"}], "rules": {"view": "task", "observe": "full"}}'
    verdict = verdict_of(suite, text)
    make_setup.cache_clear()
    assert (verdict.excluded, verdict.success) == (None, False)


def test_a_task_without_a_playable_reference_is_excluded() -> None:
    shut, lit = (Atom(name, (Constant(thing),)) for name, thing in (("shut", "box"), ("lit", "lamp")))
    both = make_task("both", "Have it both ways.", initial(), shut, Not(shut), lit)
    suite = open_suite(Benchmark("both", DOMAIN, use_tasks(both)), ACTING)
    easy = '{"turns": [{"said": "DONE"}], "rules": {"view": "task", "until": "goal", "budget": null}}'
    for text in ("PRESS(lamp)\nDONE", "{", easy, '{"turns": [{"said": "DONE"}], "opening": "0"}'):
        assert suite.score("both", text).excluded == NO_REFERENCE
