from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from typing import Any, get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import eai
from agents.switches import SCENE, SWITCHES, WON, at, initial, lit, tasks
from eai import make_task
from eai.agents.game import Game
from eai.agents.gym import TextEnvironment, make
from eai.agents.play import EpisodeFactory, make_game_rules
from eai.agents.reference import find_setup, make_setup
from eai.agents.rules import STANDARD, GameRules, View
from eai.agents.setting import AgentSetting
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import Benchmark
from eai.results.reward import Shaping
from eai.tasks.short_lists import expand_shortened_lists
from eai.tasks.source import Source
from eai.world.state import Fact


def play(*commands: str, task_id: str = "both", **options: Any) -> list[tuple[str, float, bool, bool, Any]]:
    environment = make(SWITCHES, task_id, **options)
    environment.reset(seed=0)
    return [environment.step(command) for command in commands]


def told(*commands: str, **options: Any) -> str:
    return play(*commands, **options)[-1][0].partition("\n\nNow:")[0]


def rewards(*commands: str, **options: Any) -> list[float]:
    return [turn[1] for turn in play(*commands, **options)]


OPENING = """\
both
Switch both on.

Goals:
lit(lamp)
lit(torch)

You are robot.

Objects [kind]: properties
robot [robot]: -
hall, shed [room]: room
box [box]: -
lamp, torch [lamp]: -

Now:
at(*, hall): robot, lamp
at(*, shed): box, torch
inside(torch, box)
shut(box)"""

PARTIAL_OPENING = """\
both
Switch both on.

Goals:
lit(lamp)
lit(torch)

You are robot. You do not see everything: an action may name only what is listed below or seen later.

Objects [kind]: properties
robot [robot]: -
hall, shed [room]: room
lamp [lamp]: -

Now:
at(*, hall): robot, lamp"""


@pytest.mark.parametrize(("observe", "opening"), [("full", OPENING), ("partial", PARTIAL_OPENING)])
def test_the_first_observation_has_the_task_and_the_visible_facts(observe: str, opening: str) -> None:
    observation, info = make(SWITCHES, "both", observe=observe).reset(seed=0)
    assert observation == opening
    assert info == {
        "task_id": "both",
        "goals": [False, False],
        "won": False,
        "fault": None,
        "slipped": False,
        "repairs": [],
    }


def test_an_observation_has_changes_and_present_facts() -> None:
    observation = play("PRESS(lamp)")[-1][0]
    assert observation.startswith("PRESS(lamp): done.\n+ lit(lamp)\n\nNow:\nat(*, hall): robot, lamp\n")
    assert "\nlit(lamp)\n" in observation


@pytest.mark.parametrize(
    ("feedback", "told"),
    [("changes", "PRESS(lamp): done.\n+ lit(lamp)"), ("outcome", "PRESS(lamp): done.")],
)
def test_shorter_feedback_does_not_change_the_game(feedback: str, told: str) -> None:
    assert play("PRESS(lamp)", feedback=feedback)[0][0] == told
    failed = play("OPEN(box)", feedback=feedback)[0][0]
    assert failed == "OPEN(box): failed (missing step): the robot is not beside box."
    for some, all_told in zip(play(*WON, feedback=feedback), play(*WON), strict=True):
        assert some[1:] == all_told[1:]
    environment = make(SWITCHES, "both", feedback=feedback)
    assert environment.reset(seed=0)[0] == OPENING
    assert "what holds now" not in environment.manual


def test_a_newly_seen_object_is_introduced_once() -> None:
    assert told("GO(shed)", observe="partial") == (
        "GO(shed): done.\n+ at(robot, shed)\n- at(robot, hall)\n\nYou see for the first time:\nbox [box]: -"
    )
    assert "first time" not in told("GO(shed)", "GO(hall)", "GO(shed)", observe="partial")


def test_facts_that_come_into_or_go_out_of_sight_are_not_reported_as_changes() -> None:
    opened = told("GO(shed)", "OPEN(box)", observe="partial")
    assert opened == "OPEN(box): done.\n- shut(box)\n\nYou see for the first time:\ntorch [lamp]: -"
    assert "- at(lamp" not in told("GO(shed)", observe="partial")


@pytest.mark.parametrize(
    ("text", "fault", "words"),
    [
        ("I would press the lamp.", "parsing", "Failed (parsing): no action was found."),
        ("", "parsing", "Failed (parsing): "),
        ("x" * 10_001, "parsing", "Failed (parsing): it is longer than 10,000 characters."),
        (
            '[{"action": "PRESS", "object": "lamp"}, {"action": "PRESS", "object": "lamp"}]',
            "parsing",
            "Failed (parsing): one action at a time, not 2.",
        ),
        ("FLY(lamp)", "hallucination", "Failed (hallucination): FLY is not an action."),
        ("PRESS(sun)", "hallucination", "Failed (hallucination): PRESS: there is no sun."),
        ("PRESS(lamp, torch)", "argument_number", "Failed (argument number): PRESS takes 1 object, not 2."),
        ("PRESS()", "argument_number", "Failed (argument number): PRESS takes 1 object, not 0."),
        ("GO(hall)", "additional_step", "GO(hall): not needed: the robot is in hall already."),
        ("PRESS(box)", "affordance", "PRESS(box): failed (affordance): box is no lamp."),
        (
            "PRESS(torch)",
            "missing_step",
            "PRESS(torch): failed (missing step): the robot is not beside torch.",
        ),
        ("DONE", "hallucination", "Failed (hallucination): DONE is not an action."),
    ],
)
def test_a_failed_action_costs_a_step_and_changes_nothing(text: str, fault: str, words: str) -> None:
    environment = make(SWITCHES, "both", max_steps=2)
    first, _ = environment.reset(seed=0)
    observation, reward, terminated, truncated, info = environment.step(text)
    assert (info["fault"], reward, terminated, truncated) == (fault, 0.0, False, False)
    assert observation.startswith(words)
    assert observation.partition("Now:")[2] == first.partition("Now:")[2]
    assert environment.step(text)[3], "it was a step"


def test_a_command_has_at_most_ten_thousand_characters() -> None:
    assert told("PRESS(lamp)".ljust(10_000)).startswith("PRESS(lamp): done.")
    assert "it is longer than 10,000 characters" in told("PRESS(lamp)".ljust(10_001))


def test_a_parsing_error_says_how_an_action_is_written() -> None:
    assert told("let me think").endswith("Write one action, such as GO(x).")


@pytest.mark.parametrize(
    ("text", "repairs"),
    [
        ("PRESS(lamp)", []),
        ("  PRESS ( lamp ) \n", []),
        ('{"action": "PRESS", "object": "lamp"}', []),
        ('[{"action": "PRESS", "object": "lamp"}]', []),
        ('```json\n[{"action": "PRESS", "object": "lamp"}]\n```', ["code_fence"]),
    ],
)
def test_a_line_and_a_step_of_an_answer_are_the_same_action(text: str, repairs: list[str]) -> None:
    turn = play(text)[-1]
    assert turn[0].startswith("PRESS(lamp): done.")
    assert turn[4]["repairs"] == repairs


WORDS = st.sampled_from(
    ["GO", "PRESS", "press", "lamp", "torch", "(", ")", ",", "[", "{", '"', ":", "\n", "DONE"]
)


@pytest.mark.parametrize("name", ["switches", "virtualhome", "behavior"])
@given(text=st.text() | st.lists(WORDS).map("".join) | st.lists(WORDS).map(" ".join))
@settings(deadline=None)
def test_no_text_is_refused(text: str, name: str, data_store: DataPackStore) -> None:
    environment = environment_of(name, data_store)
    environment.reset(seed=0)
    observation, reward, _, _, info = environment.step(text)
    assert observation in environment.observation_space
    assert reward == 0 or info["fault"] is None


@cache
def environment_of(name: str, store: DataPackStore) -> TextEnvironment:
    task_id = {"switches": "both"}.get(name)
    return make(SWITCHES if name == "switches" else name, task_id, source=Source(store))


def test_an_action_without_objects_is_a_word_or_has_empty_brackets() -> None:
    assert told("WAVE") == told("WAVE()") == "WAVE(): done.\nNo fact that you see has changed."


def test_the_goal_ends_the_episode() -> None:
    turns = play(*WON)
    assert [turn[2] for turn in turns] == [False, False, False, True]
    assert turns[-1][4]["won"]
    assert turns[-1][4]["goals"] == [True, True]
    assert "\nAll goals are reached.\n" in turns[-1][0]


def test_a_game_is_cut_off() -> None:
    turns = play("WAVE", "WAVE", max_steps=2)
    assert [(turn[2], turn[3]) for turn in turns] == [(False, False), (False, True)]
    assert not turns[-1][4]["won"]
    assert "\nThe episode is over.\n" in turns[-1][0]


def test_by_default_a_game_has_a_hundred_steps_and_rewards_success() -> None:
    assert make(SWITCHES, "both").rules == GameRules()
    assert GameRules() == GameRules(
        slip=0.0,
        view="task",
        observe="full",
        reward=Shaping.SUCCESS,
        gamma=1.0,
        until="goal",
        max_steps=100,
        budget=None,
        admissible=False,
        feedback="facts",
    )


def test_the_last_allowed_step_may_win() -> None:
    assert [turn[2:4] for turn in play(*WON, max_steps=len(WON))][-1] == (True, False)


@pytest.mark.parametrize(
    ("commands", "won"),
    [((*WON, "DONE"), True), ((*WON, "PRESS(torch)", "DONE"), False), (("DONE()",), False)],
)
def test_an_agent_that_ends_the_episode_is_judged_by_the_last_state(
    commands: tuple[str, ...], won: bool
) -> None:
    turns = play(*commands, until="done")
    assert [turn[2] for turn in turns] == [False] * (len(commands) - 1) + [True]
    assert turns[-1][4]["won"] is won
    assert sum(turn[1] for turn in turns) == won


NEITHER = ("GO(shed)", "OPEN(box)", "DONE")
"""Actions that undo the initially true goal of ``half`` and ``done``, and reach no other goal."""


@pytest.mark.parametrize(
    ("task_id", "commands", "success", "goals", "progress", "diagnosis"),
    [
        # two goals, both false at the start
        ("both", ("DONE",), *[[0]] * 4),
        ("both", ("PRESS(lamp)", "PRESS(lamp)", "DONE"), [0] * 3, *[[0.5, -0.5, 0]] * 3),
        ("both", ("PRESS(lamp)", "DONE"), [0, 0], *[[0.5, 0]] * 3),
        (
            "both",
            ("PRESS(lamp)", "PRESS(torch)", "WAVE", "DONE"),
            [0] * 4,
            [0.5, -0.5, 0.5, 0],
            [0.5, 0, 0, 0],
            [0.5, -0.25, 0, 0],
        ),
        ("both", (*WON, "DONE"), [0, 0, 0, 1, 0], *[[0.5, 0, 0, 0.5, 0]] * 3),
        (
            "both",
            (*WON, "?", "DONE"),
            [0, 0, 0, 1, -1, 0],
            [0.5, 0, 0, 0.5, -1, 0],
            [0.5, 0, 0, 0.5, 0, 0],
            [0.5, 0, 0, 0.5, -0.5, 0],
        ),
        # two goals, one true at the start: only the other can be gained
        ("half", ("DONE",), *[[0]] * 4),
        ("half", ("PRESS(lamp)", "DONE"), *[[1, 0]] * 4),
        ("half", ("PRESS(lamp)", *NEITHER), *[[1, 0, -1, 0]] * 4),
        ("half", NEITHER, *[[0] * 3] * 4),
        # one goal, true at the start: nothing can be gained
        ("done", ("DONE",), *[[0]] * 4),
        ("done", ("WAVE", "DONE"), *[[0, 0]] * 4),
        ("done", NEITHER, *[[0] * 3] * 4),
    ],
)
def test_each_reward_is_as_defined(
    task_id: str,
    commands: tuple[str, ...],
    success: list[float],
    goals: list[float],
    progress: list[float],
    diagnosis: list[float],
) -> None:
    """An opened box cannot be shut."""
    for reward, paid in zip([*Shaping][:4], (success, goals, progress, diagnosis), strict=True):
        assert rewards(*commands, task_id=task_id, reward=reward, until="done") == paid, reward


@pytest.mark.parametrize(
    ("reward", "kept"), [("success", 0), ("goals", 0), ("progress", 1), ("diagnosis", 1)]
)
def test_goals_reached_without_done_are_no_success(reward: str, kept: float) -> None:
    """This holds for an agent that is cut off or stops early; `progress` depends only on the state."""
    paid = rewards(*WON, "WAVE", reward=reward, until="done", max_steps=4)
    assert sum(paid) == kept
    game = Game(make_setup(tasks()[0], SWITCHES, GameRules(reward=Shaping(reward), until="done")))
    for command in WON:
        game.act(command)
    assert (game.is_over, game.reward_if_ended_now) == (False, kept)
    game.act("DONE")
    assert game.reward_if_ended_now == 1


def test_the_setup_of_a_task_is_made_once(data_store: DataPackStore) -> None:
    task_id = eai.open("behavior", "action_sequencing").task_ids[0]
    task, brief = f"behavior/action_sequencing/{task_id}", GameRules(feedback="changes")
    assert find_setup(task) is find_setup(task)
    assert find_setup(task, brief) is not find_setup(task)
    with pytest.raises(InputError, match="has no task"):
        find_setup("behavior/action_sequencing/none")
    with pytest.raises(
        InputError, match="expected a task of action_sequencing, because only these are played"
    ):
        find_setup(f"behavior/goal_interpretation/{task_id}")


def test_action_goals_are_met_in_order_and_stay_met() -> None:
    turns = play("PRESS(lamp)", "WAVE", "GO(shed)", "OPEN(box)", "PRESS(torch)", task_id="greet")
    assert [turn[4]["goals"] for turn in turns] == [
        [False, True, False],
        [False, True, False],
        [False, True, False],
        [False, True, False],
        [True, True, True],
    ]


def test_slips_change_nothing_and_are_reported() -> None:
    observation, _, _, _, info = play("PRESS(lamp)", slip=1.0)[-1]
    assert observation.startswith("PRESS(lamp): nothing happened.\n\nNow:\nat(*, hall): robot, lamp")
    assert info["slipped"]
    assert info["fault"] is None


def test_equal_seeds_give_equal_bytes() -> None:
    def transcript(environment: TextEnvironment, seed: int) -> list[object]:
        games: list[object] = [environment.reset(seed=seed)]
        for _ in range(3):
            games += [environment.step(command) for command in WON[:3]]
            games.append(environment.reset())
        return games

    options = {"slip": 0.5, "observe": "partial", "admissible": True}
    environment = make(SWITCHES, ["both", "greet"], **options)
    first = transcript(environment, 1)
    assert transcript(environment, 1) == first
    assert transcript(make(SWITCHES, ["both", "greet"], **options), 1) == first
    assert transcript(environment, 2) != first


def test_admissible_commands_are_possible_actions_about_seen_objects() -> None:
    environment = make(SWITCHES, "both", admissible=True, observe="partial")
    assert environment.reset(seed=0)[1]["admissible_commands"] == [
        "GO(shed)", "OPEN(robot)", "OPEN(lamp)", "PRESS(lamp)", "WAVE()",
    ]  # fmt: skip
    info = environment.step("GO(shed)")[4]
    assert info["admissible_commands"] == ["GO(hall)", "OPEN(robot)", "OPEN(box)", "WAVE()"]
    for command in info["admissible_commands"]:
        environment.reset(seed=0)
        environment.step("GO(shed)")
        assert environment.step(command)[4]["fault"] is None


def test_a_hidden_object_cannot_be_told_from_one_that_does_not_exist() -> None:
    words = "Failed (hallucination): PRESS: you have not yet seen {}."
    for name in ("torch", "sun"):
        assert told(f"PRESS({name})", observe="partial") == words.format(name)
    answer = json.dumps({"action": "PRESS", "object": "torch"})
    assert told(answer, observe="partial") == words.format("torch")


def test_a_seen_object_may_be_named_when_it_is_out_of_sight() -> None:
    left = told("GO(shed)", "PRESS(lamp)", observe="partial")
    assert left == "PRESS(lamp): failed (wrong order): the robot is not beside lamp."


def test_hidden_objects_never_occur_in_a_transcript() -> None:
    environment = make(SWITCHES, "greet", observe="partial", admissible=True)
    opening, info = environment.reset(seed=0)
    texts = [opening.partition("Objects")[2], *info["admissible_commands"]]
    for command in ("GO(shed)", "GO(hall)", "PRESS(lamp)", "GO(shed)"):
        observation, _, _, _, info = environment.step(command)
        texts += [observation, *info["admissible_commands"]]
    assert [text for text in texts if "torch" in text] == []


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"task_id": "some"}, "switches has no task 'some'"),
        ({"task_id": []}, "task_id: expected at least one task of switches, or None for all"),
        ({"slip": 2}, "make.slip: expected less than or equal to 1, found 2"),
        ({"gamma": -1}, "make.gamma: expected greater than or equal to 0, found -1"),
        ({"max_steps": 0}, "make.max_steps: expected greater than or equal to 1, found 0"),
        ({"observe": "all"}, "make.observe: expected 'full' or 'partial', found 'all'"),
        (
            {"reward": "much"},
            "make.reward: expected 'success', 'goals', 'progress', 'diagnosis', 'repair' or 'partial', "
            "found 'much'",
        ),
        (
            {"feedback": "none"},
            "make.feedback: expected 'facts', 'changes', 'outcome' or 'pictures', found 'none'",
        ),
        (
            {"observe": "partial", "feedback": "outcome"},
            "observe=partial needs feedback=facts or feedback=changes, because other feedback does not list "
            "what the agent sees",
        ),
        ({"until": "noon"}, "make.until: expected 'goal' or 'done', found 'noon'"),
    ],
)
def test_an_option_with_an_impossible_value_is_refused(options: dict[str, Any], told: str) -> None:
    with pytest.raises(InputError) as error:
        make(SWITCHES, **options)
    assert str(error.value) == told


def test_an_unknown_option_is_refused_and_the_known_ones_are_named() -> None:
    known = ", ".join(GameRules.model_fields)
    with pytest.raises(
        InputError, match=rf"make.step: unknown; did you mean max_steps\? \(make has {known}\)"
    ):
        make(SWITCHES, step=3)
    assert all(map(GameRules.describe_option, GameRules.model_fields))


def test_a_task_without_goals_is_never_drawn_and_is_refused_by_name() -> None:
    environment = make(SWITCHES)
    environment.reset(seed=0)
    assert {environment.reset()[1]["task_id"] for _ in range(40)} == {
        "both", "greet", "half", "done",
    }  # fmt: skip
    with pytest.raises(InputError, match="none cannot be played: the task has no goals"):
        environment.reset(options={"task_id": "none"})


def test_the_manual_names_every_action_and_predicate() -> None:
    manual = make(SWITCHES).manual
    for words in ("at(x, y)", "lit(x)", "GO(x)", "requires: is_a(x, lamp); beside(x)"):
        assert words in manual


STANDARD_OPENING = """\
You are robot. You do not see everything: an action may name only what is listed below or seen later.

You may try 14 actions. You win only if you say DONE while all goals hold. LOOK tells all that you see, and \
costs no action once between two actions.

Objects [kind]: properties
"""


def standard(*commands: str, benchmark: Benchmark = SWITCHES, **options: Any) -> list[Any]:
    environment = make(benchmark, "both", rules=STANDARD, **options)
    opening = environment.reset(seed=0)[0]
    assert STANDARD_OPENING in opening or options
    return [environment.step(command) for command in commands]


def observed(*commands: str, **options: Any) -> str:
    observation: str = standard(*commands, **options)[-1][0]
    return observation


def test_changes_in_a_partial_view_list_objects_that_come_into_or_go_out_of_sight() -> None:
    assert observed("GO(shed)") == (
        "GO(shed): done.\n+ at(robot, shed)\n- at(robot, hall)\nGone out of sight: all but robot.\n\n"
        "You see for the first time:\nshed [room]: room\nbox [box]: -\n\n"
        "Of these:\nat(box, shed)\nshut(box)\n13 of 14 actions left."
    )
    back = observed("GO(shed)", "GO(hall)")
    assert "\nGone out of sight: all but robot.\nIn sight again: hall, lamp.\n12 of 14" in back
    assert "lit(torch)" not in observed("GO(shed)", "GO(hall)", "PRESS(lamp)")


def test_objects_out_of_sight_are_named_unless_more_go_than_stay() -> None:
    lamp, hall, shed = [SCENE.index[name] for name in ("lamp", "hall", "shed")]
    elsewhere = [fact for fact in initial().facts() if fact != ("at", (lamp, hall))]
    state = SCENE.state([*elsewhere, ("at", (lamp, shed))])
    game = Game(make_setup(make_task("bare", "Switch it on.", state, lit("lamp")), SWITCHES, STANDARD))
    assert "\nGone out of sight: hall.\n" in game.act("GO(shed)").observation


def test_changes_out_of_sight_are_reported_when_the_object_is_seen_again() -> None:
    game = Game(make_setup(SWITCHES.tasks(Source())["both"], SWITCHES, STANDARD))
    observer, start = game.setup.observer, game.memory.observation
    game.act("PRESS(lamp)")
    index = game.task.scene.index
    assert observer.find_changes_about(start, game.memory.observation, {index["lamp"]}) == [
        ("+", Fact("lit", (index["lamp"],)))
    ]
    game.act("GO(shed)")
    by_agent = observer.find_changes_about(start, game.memory.observation, {index["robot"]})
    assert by_agent == [], "changes of the agent are told at once"


def test_look_lists_all_visible_facts_once_between_two_actions() -> None:
    turns = standard("LOOK", "LOOK()", "WAVE()", "LOOK")
    assert turns[0][0] == (
        "Objects [kind]: properties\nrobot [robot]: -\nhall [room]: room\nlamp [lamp]: -\n\n"
        "Now:\nat(*, hall): robot, lamp\n14 of 14 actions left."
    )
    assert turns[1][0] == "You have looked already: nothing has changed since.\n13 of 14 actions left."
    assert turns[3][0].endswith("\n12 of 14 actions left.")
    assert {turn[4]["fault"] for turn in turns} == {None}
    assert "LOOK is not an action" in told("LOOK"), "facts are told anyway"


def test_the_standard_setting_is_won_by_done_in_time() -> None:
    assert standard(*WON, "DONE")[-1][4]["won"]
    assert not standard("DONE")[-1][4]["won"]
    just = standard(*WON, "DONE", max_steps=len(WON))
    assert (just[-1][2:4], just[-1][4]["won"]) == ((True, False), True)
    late = standard(*WON, "WAVE()", max_steps=len(WON))[-1]
    assert (late[0], late[2:4], late[4]["won"]) == (
        "No actions are left.\nThe episode is over.",
        (False, True),
        False,
    )


def test_an_agent_that_is_cut_off_with_all_goals_reached_has_not_declared_the_end() -> None:
    rules = STANDARD.model_copy(update={"max_steps": len(WON)})
    game = Game(make_setup(SWITCHES.tasks(Source())["both"], SWITCHES, rules))
    for command in (*WON, "WAVE()"):
        game.act(command)
    assert (game.ended, game.won, all(game.reached)) == ("steps", False, True)


def test_admissible_commands_include_done_if_it_ends_the_episode() -> None:
    game = Game(make_setup(SWITCHES.tasks(Source())["both"], SWITCHES, STANDARD))
    assert game.list_admissible_commands() == [
        "GO(shed)",
        "OPEN(robot)",
        "OPEN(lamp)",
        "PRESS(lamp)",
        "WAVE()",
        "DONE",
    ]
    assert "admissible_commands" not in standard("WAVE()")[0][4]


def test_the_view_of_the_scene_shows_irrelevant_objects() -> None:
    task = replace(SWITCHES.tasks(Source())["both"], relevant=())
    shown = {
        view: Game(make_setup(task, SWITCHES, GameRules(view=view))).write_first_observation()
        for view in get_args(View)
    }
    assert "lamp, torch [lamp]" in shown["scene"]
    assert "[lamp]" not in shown["task"]


def test_egocentric_relations_are_shown_only_for_the_agent() -> None:
    own = replace(SWITCHES, domain=replace(SWITCHES.domain, egocentric=(at,)))
    task = own.tasks(Source())["both"]
    for view, lamp in (("task", True), ("scene", False)):
        setup = make_setup(task, own, GameRules(view=view))
        facts = expand_shortened_lists(Game(setup).write_first_observation()).partition("Now:")[2]
        assert "at(robot, hall)" in facts
        assert ("at(lamp, hall)" in facts) is lamp
        assert ("at: of yourself alone." in Game(setup).write_manual_and_first_observation()) is not lamp


def test_players_and_scorers_share_the_setup_of_a_task() -> None:
    task = SWITCHES.tasks(Source())["both"]
    assert make_setup(task, SWITCHES, GameRules()) is make_setup(task, SWITCHES, GameRules())
    assert make_setup(task, SWITCHES, GameRules()) is not make_setup(task, SWITCHES, STANDARD)
    assert EpisodeFactory(SWITCHES).make_setup(task) is make_setup(
        task, SWITCHES, make_game_rules(AgentSetting())
    )
