"""Tests of the server through its clients: HTTP, WebSockets, requests over the limits, lost connections."""

from __future__ import annotations

import asyncio
import json
import socket
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from queue import Queue

import anyio
import hanging
import httpx
import pytest
import uvicorn
from fastapi.testclient import TestClient
from openenv import GenericEnvClient
from typer.testing import CliRunner

import eai
from agents.switches import CASES_BY_SHAPING, reference
from eai.agents.rewards import PROMPT_NOT_FOUND
from eai.agents.rules import GameRules
from eai.base.errors import InputError
from eai.results.reward import METRICS, Shaping
from eai_openenv import Household, HouseholdAction, Limits, Tasks, TimeLimitedProtocol, create_app, scorers
from eai_openenv.__main__ import app

LAMPS = "lamps:lamps"
LIGHT = f"{LAMPS}/action_sequencing/light"
WON = ("GO(lamp_1)", "PRESS(lamp_1)", "GO(lamp_2)", "PRESS(lamp_2)")
STEPS = [command.rstrip(")").split("(") for command in WON]
PLAN = json.dumps([{"action": action, "object": thing} for action, thing in STEPS])
TASKS = Tasks({"all": LAMPS})
RULES = GameRules(reward=Shaping.PROGRESS, max_steps=50)
LIMITS = Limits(sessions=2, message_bytes=20_000, body_bytes=200_000, answers=300)


@pytest.fixture
def client() -> Iterator[TestClient]:
    with TestClient(create_app(TASKS, RULES, LIMITS)) as client:
        yield client


@pytest.fixture
def address() -> Iterator[str]:
    """Start a server on a free port, and yield its address."""
    app = create_app(TASKS, RULES, LIMITS)
    config = uvicorn.Config(
        app, port=0, http=TimeLimitedProtocol, log_level="error", ws_max_size=LIMITS.message_bytes
    )
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    yield f"127.0.0.1:{server.servers[0].sockets[0].getsockname()[1]}"
    server.should_exit = True
    thread.join()


def batch(*answers: str, label: str = LIGHT) -> dict[str, list[str]]:
    return {
        "query": [f"Light up.\n{answer}" for answer in answers],
        "prompts": ["Light up.\n"] * len(answers),
        "labels": [label] * len(answers),
    }


def sessions(client: TestClient | httpx.Client) -> float:
    return meter(client, "eai_sessions")


def meter(client: TestClient | httpx.Client, name: str) -> float:
    lines = client.get("/metrics").text.splitlines()
    return sum(float(line.rpartition(" ")[2]) for line in lines if line.startswith(name))


def test_openenvs_own_client_wins_an_episode(address: str) -> None:
    with GenericEnvClient(base_url=f"http://{address}").sync() as client:
        opening = client.reset(split="all", index=0, seed=1, episode_id="first")
        assert "Switch both lamps on." in opening.observation["text"]
        results = [client.step({"command": command}) for command in WON]
        assert [(result.reward, result.done) for result in results] == [(0, False)] * 3 + [(1, True)]
        assert tuple(results[-1].metadata["metrics"]) == METRICS
        assert client.state() == {"episode_id": "first", "step_count": 4, "task": LIGHT, "over": True}


def test_a_session_is_one_episode_after_the_other(client: TestClient) -> None:
    with client.websocket_connect("/ws") as session:

        def ask(kind: str, **data: object) -> dict:
            session.send_json({"type": kind, "data": data})
            return session.receive_json()

        assert "no episode has begun" in ask("step", command="GO(box)")["data"]["message"]
        ask("reset", task=LIGHT)
        failed = ask("step", command="PRESS(lamp_1)")["data"]
        assert (failed["reward"], failed["metadata"]["fault"]) == (0, "missing_step")
        assert ask("step", action="GO", object="lamp_1")["data"]["metadata"]["fault"] is None  # parsed JSON
        for command in WON[1:]:
            last = ask("step", command=command)
        assert last["data"]["reward"] == 1
        assert last["data"]["metadata"]["metrics"]["fault.missing_step"] == 1
        assert "the episode is over" in ask("step", command="GO(box)")["data"]["message"]
        assert ask("reset", task=LIGHT)["data"]["done"] is False
        assert sessions(client) == 1
    assert (meter(client, "eai_episodes_total"), meter(client, "eai_turns_total")) == (2, 5)


@pytest.mark.parametrize(
    ("data", "told"),
    [
        ({"task": "os:path/action_sequencing/x"}, "this server has no such benchmark"),
        ({"task": "nonsense"}, "is not a task: expected BENCHMARK/ABILITY/TASK"),
        ({"task": f"{LAMPS}/action_sequencing/dark"}, "lamps has no task 'dark'"),
        (
            {"task": f"{LAMPS}/goal_interpretation/light"},
            "expected a task of action_sequencing, because only these are played",
        ),
        ({"split": "test"}, "unknown split 'test': expected one of all"),
        ({"split": "all", "index": 2}, "no task 2 in split all: expected 0 to 1"),
        ({"index": -1}, "no task -1 in split all: expected 0 to 1"),
        ({"task": 5}, "reset: task: expected a string, found 5"),
        ({"index": "0"}, "reset: index: expected a whole number"),
        ({"split": ["all"]}, "reset: split: expected a string"),
        ({"difficulty": 3}, "not difficulty"),
    ],
)
def test_a_reset_with_wrong_arguments_is_refused_with_a_message(
    client: TestClient, data: dict, told: str
) -> None:
    assert told in client.post("/reset", json=data).json()["detail"]
    with client.websocket_connect("/ws") as session:
        session.send_json({"type": "reset", "data": data})
        assert told in session.receive_json()["data"]["message"]


def test_tasks_can_be_listed(client: TestClient) -> None:
    assert client.get("/eai/splits").json() == [{"name": "all", "type": "validation"}]
    assert client.post("/eai/num_tasks", json={"split": "all"}).json() == {"num_tasks": 2}
    first = {"index": 0, "task": LIGHT, "instruction": "Switch both lamps on."}
    assert client.post("/eai/task", json={"split": "all", "index": 0}).json() == {"task": first}
    assert client.post("/eai/task_range", json={"split": "all", "stop": 1}).json() == {"tasks": [first]}
    assert client.post("/eai/task", json={"split": "all", "index": 2}).status_code == 400
    assert client.post("/eai/num_tasks", json={"split": "none"}).status_code == 400


def test_it_is_well_and_says_so(client: TestClient) -> None:
    assert client.get("/health").json() == {"status": "healthy"}
    assert client.get("/schema").json()["action"]["required"] == ["command"]


def test_the_reward_is_the_librarys_for_every_ability(client: TestClient) -> None:
    for ability in ("action_sequencing", "goal_interpretation", "subgoal_decomposition"):
        task = f"{LAMPS}/{ability}/light"
        for answer in (PLAN, '{"output": ["lit(lamp_1)"]}', '{"node goals": [["lit", "lamp_1"]]}', ""):
            reply = client.post("/reward", json=batch(answer, answer, label=task)).json()
            assert reply["rewards"] == reply["scores"] == [eai.reward(task, answer, "progress")] * 2
            assert tuple(reply["extra_logs"]) == (*METRICS, PROMPT_NOT_FOUND)


@pytest.mark.filterwarnings("ignore:1 of 1 queries")
def test_an_example_in_a_prompt_that_is_not_found_is_paid_nothing_and_counted(client: TestClient) -> None:
    asked = {"query": [f"Such as: {PLAN}\n"], "prompts": [f"Such  as: {PLAN}\n"], "labels": [LIGHT]}
    reply = client.post("/reward", json=asked).json()
    assert (reply["rewards"], reply["extra_logs"][PROMPT_NOT_FOUND]) == ([0], [1])
    client.post("/reward", json=batch(PLAN))
    assert (meter(client, "eai_prompts_not_found_total"), meter(client, "eai_answers_total")) == (1, 2)


def test_an_answer_that_takes_for_ever_delays_nobody_else(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The deadline ends its process, and the error says so. Meanwhile and afterwards others are served."""
    begun: Queue[Callable[[], object]] = Queue()

    @contextmanager
    def fail_after(seconds: float) -> Iterator[None]:  # without a clock
        loop = asyncio.get_running_loop()
        with anyio.CancelScope() as scope:
            begun.put(lambda: loop.call_soon_threadsafe(scope.cancel))
            yield
        if scope.cancelled_caught:
            raise TimeoutError

    monkeypatch.setattr(scorers, "fail_after", fail_after)
    monkeypatch.setattr(scorers, "reward_func", hanging.reward_func)
    with httpx.Client(base_url=f"http://{address}", timeout=300) as client, ThreadPoolExecutor() as threads:
        stuck = threads.submit(httpx.post, f"http://{address}/reward", json=batch("hang"), timeout=300)
        end = begun.get(timeout=300)
        assert client.get("/health").json() == {"status": "healthy"}
        assert client.post("/reward", json=batch(PLAN)).json()["rewards"] == [1]
        with GenericEnvClient(base_url=f"http://{address}").sync() as player:
            player.reset(task=LIGHT)
            assert player.step({"command": WON[0]}).done is False
        assert not stuck.done()
        end()
        told = {"detail": "scoring takes longer than 60 s: ended at answers 1 to 1"}
        assert (stuck.result().status_code, stuck.result().json()) == (503, told)
        died = client.post("/reward", json=batch("die"))
        told = {"detail": "a scoring process has died: ended at answers 1 to 1"}
        assert (died.status_code, died.json()) == (503, told)
        assert client.post("/reward", json=batch(PLAN)).json()["rewards"] == [1]


def test_a_request_that_does_not_become_whole_is_ended(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(TimeLimitedProtocol, "seconds", 0.5)
    host, _, port = address.partition(":")
    head = f"POST /reward HTTP/1.1\r\nHost: {address}\r\n"
    for part in ("", "POST /rew", head, f"{head}Content-Length: 100\r\n\r\n[1"):
        with socket.create_connection((host, int(port)), timeout=60) as connection:
            connection.sendall(part.encode())
            assert is_closed(connection)
    assert httpx.get(f"http://{address}/health").status_code == 200


def is_closed(connection: socket.socket) -> bool:
    """Return whether the server closes a connection within the time of a connection to it."""
    try:
        return connection.recv(1000) == b""
    except ConnectionResetError:
        return True


def test_another_shaping_can_be_asked_for(client: TestClient) -> None:
    longer = json.dumps([*json.loads(PLAN)[:1], *json.loads(PLAN)])
    asked = {"shaping": "diagnosis", **batch(longer)}
    assert client.post("/reward", json=asked).json()["rewards"] == [0.5]
    assert client.post("/reward", json={**asked, "shaping": "much"}).status_code == 422


@pytest.mark.parametrize(
    ("asked", "status"),
    [
        ({"query": ["x"], "prompts": [], "labels": [LIGHT]}, 422),
        ({"query": [], "prompts": [], "labels": []}, 422),
        ({"query": ["x"], "prompts": ["x"], "labels": ["os:path/action_sequencing/x"]}, 422),
        ({"query": ["x"], "prompts": ["x"], "labels": [f"{LAMPS}/action_sequencing/dark"]}, 422),
        (batch(*["x"] * 301), 413),
        (batch("x" * 200_001), 413),
    ],
)
def test_what_cannot_be_rewarded_is_refused(client: TestClient, asked: dict, status: int) -> None:
    assert client.post("/reward", json=asked).status_code == status


@pytest.mark.parametrize(
    "value", ["NaN", "[Infinity]", '["x", -Infinity]', '{"x": NaN}', "null", '["\\ud800", 1]']
)
def test_a_malformed_request_is_refused_without_its_values(client: TestClient, value: str) -> None:
    reply = client.post("/reward", content=f'{{"query": {value}, "prompts": ["x"], "labels": ["x"]}}')
    assert reply.status_code == 422
    assert all(set(error) == {"type", "loc", "msg"} for error in reply.json()["detail"])


def test_a_body_that_does_not_say_how_long_it_is_is_cut_off_too(client: TestClient) -> None:
    pieces = (b" " * 10_000 for _ in range(100))
    assert client.post("/reward", content=pieces).status_code == 413


def test_there_are_only_so_many_sessions(client: TestClient) -> None:
    with client.websocket_connect("/ws") as first, client.websocket_connect("/ws") as second:
        for session in (first, second):
            session.send_json({"type": "reset", "data": {}})
            assert session.receive_json()["type"] == "observation"
        with client.websocket_connect("/ws") as third:
            assert third.receive_json()["data"]["code"] == "CAPACITY_REACHED"


@pytest.mark.parametrize(("task_id", "commands", "shaping", "worth"), CASES_BY_SHAPING)
def test_an_episode_pays_what_the_library_pays(
    task_id: str, commands: tuple[str, ...], shaping: Shaping, worth: float
) -> None:
    household = Household(Tasks({"all": "agents.switches:SWITCHES"}), GameRules(reward=shaping))
    household.reset(task=reference(task_id))
    paid = [household.step(HouseholdAction(command=command)).reward for command in commands]
    assert sum(paid) == pytest.approx(worth)


def test_a_session_that_was_closed_for_idleness_plays_no_more() -> None:
    household = Household(TASKS)
    household.reset(task=LIGHT)
    household.close()
    with pytest.raises(InputError, match="idle for too long"):
        household.step(HouseholdAction(command="GO(box)"))


def test_a_message_that_is_too_long_ends_its_session_alone(address: str) -> None:
    with GenericEnvClient(base_url=f"http://{address}").sync() as other:
        other.reset(task=LIGHT)
        with GenericEnvClient(base_url=f"http://{address}").sync() as client:
            client.reset(task=LIGHT)
            with pytest.raises(Exception, match=r"1009|too big|closed"):
                client.step({"command": "x" * 30_000})
        assert other.step({"command": "GO(box)"}).done is False


def test_a_client_that_dies_in_the_middle_loses_and_doubles_nothing(address: str) -> None:
    """The repeated batch and episode get the replies that the first ones would have got."""
    asked = batch(PLAN, *["[]"] * 299)
    body = json.dumps(asked).encode()
    head = f"POST /reward HTTP/1.1\r\nHost: {address}\r\nContent-Type: application/json\r\n"
    host, _, port = address.partition(":")
    with httpx.Client(base_url=f"http://{address}", timeout=60) as client:
        whole = client.post("/reward", json=asked).json()
        for cut in (len(body) // 2, len(body)):
            with socket.create_connection((host, int(port))) as dying:
                dying.sendall(f"{head}Content-Length: {len(body)}\r\n\r\n".encode() + body[:cut])
        with GenericEnvClient(base_url=f"http://{address}").sync() as player:
            player.reset(task=LIGHT)
            player.step({"command": WON[0]})
        assert client.post("/reward", json=asked).json() == whole
        with GenericEnvClient(base_url=f"http://{address}").sync() as player:
            player.reset(task=LIGHT)
            assert [player.step({"command": command}).reward for command in WON] == [0, 0, 0, 1]
        deadline = time.monotonic() + 30
        while sessions(client) and time.monotonic() < deadline:
            time.sleep(0.01)
        assert sessions(client) == 0
        assert 600 <= meter(client, "eai_answers_total") <= 900


def test_no_split_and_no_task_are_refused() -> None:
    with pytest.raises(InputError, match="no benchmark: name at least one"):
        Tasks({})
    with pytest.raises(InputError, match="is not a benchmark"):
        Tasks({"train": "nowhere"})


def test_a_split_that_is_given_twice_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(uvicorn, "run", lambda *_, **__: None)
    outcome = CliRunner().invoke(app, ["--domain", f"test={LAMPS}", "--domain", "test=virtualhome"])
    assert (outcome.exit_code, outcome.exception is None) == (2, False)
    assert "the split test is given twice" in outcome.stderr


def test_training_and_testing_with_the_same_goals_is_refused() -> None:
    with pytest.raises(InputError, match="train and test have 2 goals in common"):
        Tasks({"train": LAMPS, "test": LAMPS})
    assert Tasks({"all": LAMPS, "test": LAMPS}).splits == ("all", "test")
