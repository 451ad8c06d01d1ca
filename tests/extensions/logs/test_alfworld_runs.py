"""Hand-made logs of agents in ALFWorld, in the forms of ReAct, Reflexion and AgentBench, with labels.

The games are those of the tests of `alfworld:`. A further log is an entry of `REPLAYED`: a name, the actions
with the game's replies, and the expected kind of each action (None for an accepted one). `NO` is the game's
reply to every impossible command, so that without the game no kind is proven.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import pytest

from command_line import Command
from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark
from eai.extensions.logs.episode import EpisodeEndReason, EpisodeOutcome, LoggedEpisode
from eai.extensions.logs.readers import read_log
from eai.world.fault import FaultKind

games = pytest.importorskip("extensions.alfworld.test_alfworld", reason="needs the extension alfworld")
opened, write = games.opened, games.write

ROOM = (
    "You are in the middle of a room. Looking around you, you see a fridge 1, a sinkbasin 1, and a table 1."
)
TASK = "Your task is to: put a cool apple in table."
NAME = "cool-Apple-None-Table-7/trial_1"
NO = "Nothing happens."
AT_FRIDGE = ("go to fridge 1", "The fridge 1 is closed.")
OPEN = ("open fridge 1", "You open the fridge 1. The fridge 1 is open. In it, you see a apple 2.")
TAKE = ("take apple 2 from fridge 1", "You pick up the apple 2 from the fridge 1.")
COOL = ("cool apple 2 with fridge 1", "You cool the apple 2 using the fridge 1.")
AT_TABLE = ("go to table 1", "On the table 1, you see a apple 1.")
PUT = ("put apple 2 in/on table 1", "You put the apple 2 in/on the table 1.")
MOVE = ("move apple 2 to table 1", "You move the apple 2 to the table 1.")
THINK = ("think: I need an apple.", "OK.")
PLAN = (AT_FRIDGE, OPEN, TAKE, COOL, AT_TABLE)
Turns = Sequence[tuple[str, str]]


def as_react(turns: Turns, end: str = "", name: str = NAME) -> str:
    lines = [line for n, (act, obs) in enumerate(turns, 1) for line in (f"Act {n}: {act}", f"Obs {n}: {obs}")]
    return "\n".join([name, ROOM, TASK, *lines, end, "------------", ""])


def as_reflexion(turns: Turns, status: str, number: int = 0) -> str:
    example = (
        f"{ROOM}\nYour task is to: put some mug in table.\n> go to table 1\nOn the table 1, you see a mug 1."
    )
    head = f"Interact with a household to solve a task. Here are two examples.\n{example}\n> look\n{NO}"
    memory = "\n\nYour memory for the task below:\nTrial 0:\nI should cool it." if number else ""
    history = "\n".join(f"> {act}\n{obs}" for act, obs in turns)
    body = f"{head}{memory}\nHere is the task:\n{ROOM}\n{TASK}\n{history}"
    return f"\n#####\n\nEnvironment #{number}:\n{body}\n\nSTATUS: {status}\n\n#####\n"


def as_agentbench(turns: Turns, status: str, result: int, index: int = 0) -> str:
    log = [
        {
            "round": n,
            "output": f"THOUGHT: so.\nACTION: {act}",
            "action": act,
            "observation": obs,
            "admissible_commands": ["look"],
            "done": False,
        }
        for n, (act, obs) in enumerate(turns, 1)
    ]
    given = {
        "log": log,
        "init_prompt": f"Here is your task. {ROOM}\n{TASK} AVAILABLE ACTIONS: look\n",
        "result": result,
    }
    output = {"index": index, "status": status, "result": given, "history": []}
    return json.dumps({"index": index, "error": None, "info": None, "output": output, "time": {}}) + "\n"


def read(folder: Path, text: str, games: Benchmark | None = None) -> tuple[LoggedEpisode, ...]:
    path = folder / "run.log"
    path.write_text(text)
    return read_log(path, games)


@pytest.mark.parametrize(
    ("text", "outcome", "ending", "actions"),
    [
        (
            as_react([*PLAN, PUT], "1 r 1 rs [1, 0] cnts [1, 0] sum(rs)/sum(cnts) 1.0"),
            "won",
            "goal reached",
            6,
        ),
        (
            as_react([THINK, AT_FRIDGE], "1 r 0 rs [0, 0] cnts [1, 0] sum(rs)/sum(cnts) 0.0"),
            "goal unmet",
            "cannot tell",
            1,
        ),
        (as_react([THINK, AT_FRIDGE]), "cannot tell", "cannot tell", 1),
        (as_react([("look", "ok")] * 49, "2 r False rs [0]"), "goal unmet", "out of steps", 49),
        (as_react([*PLAN, PUT], "Result: Task Success!"), "won", "goal reached", 6),
        (as_reflexion([*PLAN, PUT], "OK"), "won", "goal reached", 6),
        (
            as_reflexion([AT_FRIDGE, ("look", "ok"), ("look", "ok")], "FAIL", 3),
            "goal unmet",
            "stopped from outside",
            3,
        ),
        (as_agentbench([*PLAN, MOVE], "completed", 1), "won", "goal reached", 6),
        (as_agentbench([AT_FRIDGE], "task limit reached", 0), "goal unmet", "out of steps", 1),
        (as_agentbench([AT_FRIDGE], "agent invalid action", 0), "goal unmet", "too many errors", 2),
        (as_agentbench([], "agent context limit", 0), "nothing submitted", "stopped from outside", 0),
        (as_agentbench([AT_FRIDGE], "unknown", 0), "not graded", "cannot tell", 1),
    ],
)
def test_each_form_of_log_is_read(tmp_path: Path, text: str, outcome: str, ending: str, actions: int) -> None:
    (episode,) = read(tmp_path, text)
    assert (episode.outcome, episode.ending) == (EpisodeOutcome(outcome), EpisodeEndReason(ending))
    assert len(episode.steps) == actions
    assert (episode.opening.count("Your task is to"), "put some mug" in episode.opening) == (1, False)


def test_a_log_has_many_episodes_with_the_names_that_it_states(tmp_path: Path) -> None:
    assert [
        e.task for e in read(tmp_path, as_react([AT_FRIDGE]) + as_react([OPEN], name="pick-Mug/trial_2"))
    ] == [
        NAME,
        "pick-Mug/trial_2",
    ]
    solved = "\n#####\n\nEnvironment #1: Success\n\n#####\n"
    text = as_reflexion([AT_FRIDGE], "FAIL") + solved + as_reflexion([OPEN], "OK", 2)
    assert [e.task for e in read(tmp_path, text)] == ["Environment #0", "Environment #2"]
    text = as_agentbench([AT_FRIDGE], "completed", 0, 4) + as_agentbench([OPEN], "completed", 1, 7)
    assert [e.task for e in read(tmp_path, text)] == ["4", "7"]


def test_an_episode_without_a_name_is_named_after_its_instruction(tmp_path: Path) -> None:
    named, unnamed = read(tmp_path, as_react([AT_FRIDGE]) + as_react([OPEN], name=""))
    assert (named.task, unnamed.task) == (NAME, "put a cool apple in table")


def test_without_the_game_no_kind_and_no_progress_is_told(tmp_path: Path) -> None:
    (episode,) = read(tmp_path, as_react([AT_FRIDGE, ("take apple 2 from fridge 1", NO), OPEN]))
    assert [(step.accepted, step.kind) for step in episode.steps] == [
        (True, None),
        (False, None),
        (True, None),
    ]
    assert (episode.index_of_first_error, episode.best_goal_progress) == (1, None)
    assert episode.unknown == ("kinds of errors", "progress", "verdict")


def test_a_reply_that_rejects_an_action_may_list_the_possible_commands(tmp_path: Path) -> None:
    listed = f"{NO}, admissible commands: ['look', 'inventory']"
    (episode,) = read(tmp_path, as_react([AT_FRIDGE, ("> open fridge 1", listed), (OPEN[0], NO)]))
    assert [step.accepted for step in episode.steps] == [True, False, False]


def test_a_line_about_success_is_a_verdict_and_no_reply(tmp_path: Path) -> None:
    (episode,) = read(tmp_path, as_react([*PLAN, PUT], "Result: Task Success!"))
    assert (episode.outcome, episode.words) == (EpisodeOutcome.WON, PUT[1])


REPLAYED: list[tuple[str, Turns, list[FaultKind | None]]] = [
    ("the fridge is closed", [AT_FRIDGE, (TAKE[0], NO), OPEN], [None, FaultKind.MISSING_STEP, None]),
    (
        "no such apple",
        [AT_FRIDGE, OPEN, ("take apple 9 from fridge 1", NO)],
        [None, None, FaultKind.HALLUCINATION],
    ),
    ("no command", [AT_FRIDGE, ("I open the door", NO), OPEN], [None, FaultKind.PARSING, None]),
    ("a prompt's sign", [("> go to fridge 1", NO), ("> think: go", NO)], [FaultKind.PARSING] * 2),
    ("open again", [AT_FRIDGE, OPEN, (OPEN[0], NO)], [None, None, FaultKind.WRONG_ORDER]),
    ("too far away", [(OPEN[0], NO), AT_FRIDGE], [FaultKind.MISSING_STEP, None]),
    (
        "left too early",
        [AT_FRIDGE, OPEN, TAKE, AT_TABLE, (COOL[0], NO)],
        [None] * 4 + [FaultKind.WRONG_ORDER],
    ),
    ("old form of put", [*PLAN, PUT], [None] * 6),
    ("new form of put", [*PLAN, MOVE], [None] * 6),
    ("what it carries", [("inventory", "You are not carrying anything."), AT_FRIDGE], [None, None]),
    ("put in an unknown form", [AT_TABLE, (PUT[0], NO), ("look", "ok")], [None, None, None]),
]


@pytest.mark.parametrize(
    ("turns", "kinds"), [case[1:] for case in REPLAYED], ids=[case[0] for case in REPLAYED]
)
@pytest.mark.parametrize("form", [as_react, lambda turns: as_agentbench(turns, "completed", 0)])
def test_a_replay_in_the_users_game_proves_the_kind_of_an_error(
    tmp_path: Path, form: object, turns: Turns, kinds: list[FaultKind | None]
) -> None:
    write(tmp_path / "games")
    assert callable(form)
    (episode,) = read(tmp_path, form(turns), opened(tmp_path / "games"))
    assert [step.kind for step in episode.steps] == kinds
    assert all(step.progress is not None for step in episode.steps)
    assert episode.unknown == ()


def test_a_replay_shows_the_best_moment_and_decides_an_unstated_outcome(tmp_path: Path) -> None:
    write(tmp_path / "games")
    games = opened(tmp_path / "games")
    (won,) = read(tmp_path, as_react([*PLAN, PUT]), games)
    assert (won.outcome, won.best_goal_progress, won.step_of_best_goal_progress, won.unseen) == (
        EpisodeOutcome.WON,
        1.0,
        5,
        (),
    )
    (lost,) = read(tmp_path, as_react([AT_FRIDGE, (TAKE[0], NO)]), games)
    assert (lost.outcome, lost.best_goal_progress, lost.unseen) == (
        EpisodeOutcome.GOAL_UNMET,
        0.75,
        ("apple",),
    )


def test_a_replay_that_contradicts_the_log_proves_nothing_from_there_on(tmp_path: Path) -> None:
    write(tmp_path / "games")
    turns = [(TAKE[0], NO), AT_FRIDGE, (TAKE[0], TAKE[1]), ("take apple 9 from fridge 1", NO)]
    (episode,) = read(tmp_path, as_react(turns), opened(tmp_path / "games"))
    assert [step.kind for step in episode.steps] == [FaultKind.MISSING_STEP, None, None, None]
    assert [step.progress is None for step in episode.steps] == [False, False, True, True]
    assert (episode.outcome, episode.progress) == (EpisodeOutcome.CANNOT_TELL, None)
    assert episode.unknown == ("a world that agrees with action 3", "progress", "verdict")


def test_a_game_that_is_not_there_or_fits_twice_is_not_guessed(tmp_path: Path) -> None:
    write(tmp_path / "games")
    write(tmp_path / "games", "trial_2")
    games = opened(tmp_path / "games")
    (named,) = read(tmp_path, as_react([AT_FRIDGE]), games)
    assert named.steps[0].progress is not None
    for text in (
        as_reflexion([AT_FRIDGE], "FAIL"),
        as_react([AT_FRIDGE]).replace("cool apple", "clean mug").replace(NAME, ""),
    ):
        (episode,) = read(tmp_path, text, games)
        assert episode.steps[0].progress is None
        assert "the game" in episode.unknown


@pytest.mark.parametrize(
    ("text", "place"),
    [
        (as_react([AT_FRIDGE, OPEN]).replace("Obs 1:", "Observation:"), "line 5: expected Obs 1"),
        (as_react([AT_FRIDGE, OPEN]).replace("Act 2:", "Act 3:"), "line 6: expected Act 2"),
        (
            as_react([AT_FRIDGE, OPEN]).partition("Obs 2")[0],
            "line 6: expected the game's reply after this action",
        ),
        (
            as_react([AT_FRIDGE]).replace(TASK + "\n", ""),
            "line 2: expected 'Your task is to:' before the first action",
        ),
        (
            as_reflexion([AT_FRIDGE], "FAIL").replace("Here is the task:", "Go:"),
            "line 5: expected a line 'Here is the task' after this prompt",
        ),
        (
            as_reflexion([AT_FRIDGE], "FAIL").replace("STATUS: FAIL", "STATUS: ?"),
            "after line 16: expected STATUS: OK or FAIL",
        ),
        (
            as_agentbench([AT_FRIDGE], "completed", 0) + as_agentbench([OPEN], "completed", 0)[:-40],
            "line 2, column",
        ),
        (
            as_agentbench([AT_FRIDGE], "completed", 0).replace('"action":', '"deed":'),
            "line 1: output.result.log.0.action",
        ),
        (as_agentbench([AT_FRIDGE], "asleep", 0), "line 1: output.status"),
        (as_agentbench([], "completed", 1), "line 1: output.result.log: expected turns"),
        (
            as_agentbench([AT_FRIDGE], "completed", 0).replace('"round": 1', '"round": 2'),
            "line 1: expected round 1",
        ),
    ],
)
def test_a_damaged_log_is_refused_with_the_place(tmp_path: Path, text: str, place: str) -> None:
    with pytest.raises(InputError) as caught:
        read(tmp_path, text)
    assert place in str(caught.value)


def test_the_command_replays_logs_in_the_benchmark_that_the_user_names(eai: Command, tmp_path: Path) -> None:
    write(tmp_path / "games")
    read(tmp_path, as_react([AT_FRIDGE, (TAKE[0], NO)]))
    games = f"tasks=alfworld:{tmp_path / 'games'}"
    printed = eai(
        "analyze", "logs", tmp_path / "run.log", "--with", games, "--out", tmp_path / "out", "--no-plots"
    )
    assert printed.status == 0, printed.err
    assert "missing_step" in printed.out


def test_a_sample_that_broke_off_without_turns_is_not_graded(tmp_path: Path) -> None:
    broken = {
        "index": 3,
        "output": {"status": "unknown", "result": {"result": False, "error": "x"}, "history": []},
    }
    sound, other = read(tmp_path, as_agentbench([AT_FRIDGE], "completed", 0) + json.dumps(broken) + "\n")
    assert (sound.outcome, other.outcome) == (EpisodeOutcome.GOAL_UNMET, EpisodeOutcome.NOT_GRADED)
    assert other.steps == ()


def test_json_of_another_kind_that_quotes_a_room_is_not_taken(tmp_path: Path) -> None:
    text = json.dumps({"version": 2, "status": "success", "log": [], "output": f"{ROOM} {TASK}"})
    with pytest.raises(InputError, match="unknown log format"):
        read(tmp_path, text)
