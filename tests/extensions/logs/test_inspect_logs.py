"""Hand-made logs of Inspect whose samples call the tools act, look and done, with labels.

A further log is an entry of `LABELLED`: a name, the calls with the replies of the tools, and for each action
whether it was carried out and its kind of error, as far as the reply proves them.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("inspect_ai")

from inspect_ai._util.error import EvalError
from inspect_ai.log import EvalConfig, EvalDataset, EvalLog, EvalSample, EvalSpec, write_eval_log
from inspect_ai.log._log import EvalSampleLimit
from inspect_ai.model import ChatMessage, ChatMessageAssistant, ChatMessageTool, ChatMessageUser
from inspect_ai.scorer import Score
from inspect_ai.tool import ToolCall, ToolCallError

from agents.switches import DOMAIN, initial
from eai import Benchmark, make_task, use_tasks
from eai.base.errors import InputError
from eai.extensions.logs.episode import EpisodeEndReason, EpisodeOutcome, LoggedEpisode
from eai.extensions.logs.readers import read_log
from eai.world.fault import FaultKind

Call = tuple[str, str]
OPENED = ("OPEN box", "OPEN(box): done.\n+ open(box)")
LABELLED: list[tuple[str, Sequence[Call], list[tuple[bool | None, FaultKind | None]]]] = [
    ("carried out", [OPENED], [(True, None)]),
    (
        "missing step",
        [("OPEN box", "OPEN(box): failed (missing step): you are not there.")],
        [(False, FaultKind.MISSING_STEP)],
    ),
    (
        "unknown name",
        [("OPEN safe", "Failed (hallucination): there is no safe.")],
        [(False, FaultKind.HALLUCINATION)],
    ),
    (
        "not needed",
        [("OPEN box", "OPEN(box): not needed: it is open.")],
        [(False, FaultKind.ADDITIONAL_STEP)],
    ),
    ("slipped", [("OPEN box", "OPEN(box): nothing happened.")], [(False, FaultKind.SLIP)]),
    ("looks between", [("look", "You see a box."), OPENED, ("done", "DONE.")], [(True, None)]),
    ("another task's words", [("OPEN box", "The lid resists.")], [(None, None)]),
    ("the tool fails", [("OPEN box", "!the server is down")], [(False, None)]),
    ("a kind that is none of ours", [("OPEN box", "OPEN(box): failed (too heavy): no.")], [(False, None)]),
]


def messages_of(calls: Sequence[Call]) -> list[ChatMessage]:
    messages: list[ChatMessage] = [ChatMessageUser(content="Open the box.")]
    for number, (call, reply) in enumerate(calls):
        name, *objects = call.split()
        is_act = name.isupper()
        arguments = {"action": name, "objects": objects} if is_act else {}
        tool_call = ToolCall(str(number), "act" if is_act else name, arguments)
        messages.append(ChatMessageAssistant(content="Next.", tool_calls=[tool_call]))
        error = ToolCallError("unknown", reply[1:]) if reply.startswith("!") else None
        messages.append(ChatMessageTool(content=reply, tool_call_id=str(number), error=error))
    return messages


def sample(calls: Sequence[Call], value: Any = 0, **changed: Any) -> EvalSample:
    scores = None if value is None else {"own": Score(value=value)}
    given_fields = {
        "id": "t",
        "epoch": 1,
        "input": "x",
        "target": "",
        "messages": messages_of(calls),
        "scores": scores,
    }
    return EvalSample(**{**given_fields, **changed})


def write(folder: Path, *samples: EvalSample, name: str = "log.eval") -> Path:
    spec = EvalSpec(
        created="2026-11-29T00:00:00+00:00",
        task="boxes",
        dataset=EvalDataset(),
        model="mockllm/model",
        config=EvalConfig(),
    )
    path = folder / name
    write_eval_log(EvalLog(eval=spec, status="success", samples=[*samples]), str(path))
    return path


@pytest.mark.parametrize("name", ["log.eval", "log.json"])
@pytest.mark.parametrize(
    ("calls", "expected"), [case[1:] for case in LABELLED], ids=[case[0] for case in LABELLED]
)
def test_the_reply_of_a_tool_proves_what_became_of_an_action(
    tmp_path: Path, name: str, calls: Sequence[Call], expected: list[tuple[bool | None, FaultKind | None]]
) -> None:
    (episode,) = read_log(write(tmp_path, sample(calls), name=name))
    assert [(step.accepted, step.kind) for step in episode.steps] == expected
    assert (episode.agent, episode.task, episode.setting, episode.format) == (
        "mockllm/model",
        "t",
        "boxes",
        "Inspect",
    )


@pytest.mark.parametrize(
    ("calls", "value", "changed", "outcome", "ending"),
    [
        ([OPENED, ("done", "DONE.")], "C", {}, "won", "by the agent"),
        ([OPENED], 1.0, {}, "won", "cannot tell"),
        ([OPENED, ("done", "DONE.")], {"success": 0, "goals": 0.5}, {}, "goal unmet", "by the agent"),
        ([OPENED], 0.5, {}, "cannot tell", "cannot tell"),
        ([OPENED], "I", {"limit": EvalSampleLimit(type="time", limit=9)}, "goal unmet", "out of time"),
        ([OPENED], False, {"limit": EvalSampleLimit(type="message", limit=9)}, "goal unmet", "out of steps"),
        (
            [OPENED],
            None,
            {"limit": EvalSampleLimit(type="operator", limit=1)},
            "not graded",
            "stopped from outside",
        ),
        (
            [OPENED],
            None,
            {"error": EvalError(message="m", traceback="t", traceback_ansi="t")},
            "not graded",
            "cannot tell",
        ),
    ],
)
def test_score_and_limit_of_a_sample_decide_its_outcome_and_its_ending(
    tmp_path: Path, calls: Sequence[Call], value: Any, changed: dict[str, Any], outcome: str, ending: str
) -> None:
    (episode,) = read_log(write(tmp_path, sample(calls, value, **changed)))
    assert (episode.outcome, episode.ending) == (EpisodeOutcome(outcome), EpisodeEndReason(ending))


def test_scores_that_disagree_tell_no_outcome_and_epochs_have_their_own_setting(tmp_path: Path) -> None:
    split = {"a": Score(value=1), "b": Score(value=0)}
    first, second = read_log(write(tmp_path, sample([OPENED], scores=split), sample([OPENED], 1, epoch=2)))
    assert (first.outcome, first.setting) == (EpisodeOutcome.CANNOT_TELL, "boxes")
    assert (second.outcome, second.setting) == (EpisodeOutcome.WON, "boxes, epoch 2")


def replay(folder: Path, calls: Sequence[Call]) -> LoggedEpisode:
    task = make_task("t", "Open the box.", initial(), "not shut(box)", domain=DOMAIN)
    benchmark = Benchmark("switches", DOMAIN, use_tasks(task))
    (episode,) = read_log(write(folder, sample(calls)), benchmark)
    return episode


def test_a_replay_tells_kinds_where_the_replies_of_a_task_tell_nothing(tmp_path: Path) -> None:
    episode = replay(tmp_path, [("OPEN box", "Hm."), ("GO shed", "Hm."), ("OPEN box", "Hm.")])
    assert [(step.accepted, step.kind) for step in episode.steps] == [
        (False, FaultKind.MISSING_STEP),
        (True, None),
        (True, None),
    ]
    assert (episode.best_goal_progress, episode.step_of_best_goal_progress, episode.outcome) == (
        1.0,
        2,
        EpisodeOutcome.GOAL_UNMET,
    )


def test_a_replay_keeps_the_kinds_that_replies_prove(tmp_path: Path) -> None:
    told = ("GO shed", "Failed (hallucination): you have not yet seen shed.")
    assert [step.kind for step in replay(tmp_path, [told, ("GO shed", "GO(shed): done.")]).steps] == [
        FaultKind.HALLUCINATION,
        None,
    ]


def test_nothing_is_proven_about_a_sample_without_calls(tmp_path: Path) -> None:
    tasks = [make_task(name, "Open the box.", initial(), "not shut(box)", domain=DOMAIN) for name in "tu"]
    benchmark = Benchmark("switches", DOMAIN, use_tasks(*tasks))
    _, idle = read_log(write(tmp_path, sample([OPENED]), sample([], id="u")), benchmark)
    assert (idle.steps, idle.progress, idle.unknown) == ((), None, ("progress", "actions"))


@pytest.mark.parametrize("cut", [30, 400])
def test_a_damaged_log_is_refused(tmp_path: Path, cut: int) -> None:
    path = write(tmp_path, sample([OPENED]))
    content = path.read_bytes()
    path.write_bytes(content[:40] + content[40 + cut :])
    with pytest.raises(InputError, match=r"log\.eval"):
        read_log(path)


def test_a_call_with_wrong_arguments_is_an_unreadable_action_of_the_agent(tmp_path: Path) -> None:
    changed = sample([OPENED, OPENED, OPENED])
    calls = [
        call
        for message in changed.messages
        if message.role == "assistant"
        for call in message.tool_calls or ()
    ]
    calls[0].arguments = {"action": "OPEN", "objects": "box"}
    calls[1].parse_error = "no JSON"
    (episode,) = read_log(write(tmp_path, changed))
    assert [(step.accepted, step.kind) for step in episode.steps] == [(False, FaultKind.PARSING)] * 2 + [
        (True, None)
    ]
    calls[2].arguments = {"command": "open the box"}
    with pytest.raises(InputError, match="expected calls of act with an action and objects"):
        read_log(write(tmp_path, changed))


def test_a_log_without_these_tools_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"log\.eval: expected calls of act"):
        read_log(write(tmp_path, sample([("look", "You see a box.")]), sample([], id="u")))
