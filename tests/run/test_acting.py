"""Models that act through Inspect: by tool calls, by lines of text, and the built-in models."""

from __future__ import annotations

import json
import signal
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import inspect_ai
import pytest
from inspect_ai.log import EvalLog, write_eval_log
from inspect_ai.model import Model, ModelOutput, ModelUsage, get_model

from eai.agents.play import EpisodeFactory, make_episode_prompts_and_metadata
from eai.agents.setting import ACTING, AgentSetting
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.suite import open_suite
from eai.results.records import read_records
from eai.results.runs import read_runs
from eai.run.acting import find_command_in_reply
from eai.run.registry import TASKS
from eai.run.tasks import read_answers
from processes import Command, eai

pytestmark = pytest.mark.filterwarnings("ignore")  # warnings of Inspect
TASK = "27_2"


def scripted(outputs: Sequence[ModelOutput]) -> Model:
    for output in outputs:
        output.usage = ModelUsage(input_tokens=1, output_tokens=1, total_tokens=2)
    return get_model("mockllm/model", custom_outputs=list(outputs))


def call(command: str) -> ModelOutput:
    name, _, objects = command.removesuffix(")").partition("(")
    arguments = {"action": name, "objects": objects.split(", ") if objects else []}
    return ModelOutput.for_tool_call("mockllm/model", "act", arguments)


def tool(name: str) -> ModelOutput:
    return ModelOutput.for_tool_call("mockllm/model", name, {})


def gold() -> list[str]:
    suite = open_suite("virtualhome", ACTING)
    return [*(EpisodeFactory(suite.benchmark).make_setup(suite.tasks[TASK]).reference.commands or ())]


def play(model: Model | str, folder: Path, **arguments: object) -> EvalLog:
    task = TASKS["virtualhome_acting"](tasks=[TASK], **arguments)
    (log,) = inspect_ai.eval(task, model=model, log_dir=str(folder), display="none")
    assert log.status == "success", log.error
    return log


def outcome_of(log: EvalLog) -> dict[str, object]:
    (sample,) = log.samples or ()
    assert sample.error is None
    return dict((sample.scores or {})["acting"].metadata or {})


def test_a_model_acts_by_tool_calls(data_store: DataPackStore, tmp_path: Path) -> None:
    outputs = [tool("look"), call("FLY(moon)"), *map(call, gold()), tool("done"), tool("look")]
    log = play(scripted(outputs), tmp_path)
    about = outcome_of(log)
    assert (about["success"], about["ended"], about["harness"]) == (True, "done", "react")
    turns = about["turns"]
    assert isinstance(turns, list)
    assert [turn["said"] for turn in turns] == ["LOOK", "FLY(moon)", *gold(), "DONE"]
    assert [turn["fault"] for turn in turns][1] == "hallucination"
    (sample,) = log.samples or ()
    words = [turn.get("thought") for turn in json.loads(sample.output.completion)["turns"]]
    assert words[:3] == ["tool call for tool look", "tool call for tool act", None]  # words that are not new
    run = "virtualhome%2Facting%2Fstrict%2Fmockllm_model%2C+harness-react"
    assert about["explorer"] == f"explorer.html#run={run}&task={TASK}"


def test_a_run_whose_model_may_ask_the_verifier_is_a_setting_of_its_own(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    pytest.importorskip("eai.extensions.verifier")
    plan = json.dumps([{"action": "FLY"}])
    queries = [("plan", {}), ("check_plan", {"plan": plan}), ("predict", {"action": plan})]
    asked = [ModelOutput.for_tool_call("mockllm/model", name, given) for name, given in queries]
    log = play(scripted([*asked, *map(call, gold()), tool("done")]), tmp_path, verifier=True)
    about = outcome_of(log)
    assert (about["success"], about["harness"]) == (True, "react")
    (sample,) = log.samples or ()
    replies = [message for message in sample.messages if message.role == "tool"]
    assert json.loads(replies[0].text)["success"] is True
    assert json.loads(replies[1].text)["success"] is False
    assert replies[2].error is not None
    assert replies[2].error.message.startswith("action: ")
    assert json.loads(sample.output.completion)["rules"]["verifier"] is True
    assert "rules-verifier-true" in str(about["explorer"])  # so it is never ranked with others


def test_verifier_tools_are_offered_only_if_the_setting_says_so(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    log = play(scripted([ModelOutput.for_tool_call("mockllm/model", "plan", {}), tool("done")]), tmp_path)
    (sample,) = log.samples or ()
    reply, _ = [message for message in sample.messages if message.role == "tool"]
    assert reply.error is not None
    with pytest.raises(InputError, match="cannot call tools; choose react or auto"):
        AgentSetting(verifier=True, harness="text")


def test_an_episode_ends_if_the_model_calls_no_tool(data_store: DataPackStore, tmp_path: Path) -> None:
    outputs = [*map(call, gold()), ModelOutput.from_content("mockllm/model", "I am done.")]
    about = outcome_of(play(scripted(outputs), tmp_path))
    assert (about["success"], about["ended"], about["reached"]) == (False, "stopped", True)


def test_a_reply_without_a_call_is_kept_and_explained(data_store: DataPackStore, tmp_path: Path) -> None:
    refusal = "1. Walk to the soap.\n2. Grab it."
    log = play(scripted([ModelOutput.from_content("mockllm/model", refusal)]), tmp_path)
    about = outcome_of(log)
    assert (about["ended"], about["turns"], about["without_call"]) == ("stopped", [], refusal)
    (sample,) = log.samples or ()
    told = (sample.scores or {})["acting"].explanation
    assert told is not None
    assert "- a reply called no tool: 1. Walk to the soap. 2. Grab it." in told


def test_after_a_reply_without_a_call_the_harness_auto_takes_lines(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    first, *others = gold()
    texts = ["I would rather write.", *others, "DONE"]
    outputs = [call(first), *(ModelOutput.from_content("mockllm/model", text) for text in texts)]
    log = play(scripted(outputs), tmp_path, harness="auto")
    about = outcome_of(log)
    assert (about["success"], about["harness"], about["without_call"]) == (True, "auto", texts[0])
    (sample,) = log.samples or ()
    asked = [message.text for message in sample.messages if message.role == "user"]
    assert asked[1].startswith("You called no tool. Write one command a message")


def test_the_harness_auto_uses_tools_if_they_are_called(data_store: DataPackStore, tmp_path: Path) -> None:
    about = outcome_of(play(scripted([*map(call, gold()), tool("done")]), tmp_path, harness="auto"))
    assert (about["success"], about["harness"]) == (True, "auto")
    assert "without_call" not in about


def test_a_model_without_tools_writes_commands(data_store: DataPackStore, tmp_path: Path) -> None:
    said = ["LOOK", *gold(), "DONE"]
    outputs = [ModelOutput.from_content("mockllm/model", f"I think.\n{command}") for command in said]
    log = play(scripted(outputs), tmp_path, harness="text")
    about = outcome_of(log)
    assert (about["success"], about["harness"]) == (True, "text")
    (sample,) = log.samples or ()
    asked = next(each.text for each in sample.messages if each.role == "user")
    assert asked.splitlines()[-1] == "Write one command a message, on its last line: an action, LOOK or DONE."
    turns = json.loads(sample.output.completion)["turns"]
    assert [turn["said"] for turn in turns] == said
    assert turns[-1]["thought"] == "I think.\nDONE"
    assert sample.store  # the log shows the commands


def test_a_users_own_agent_gets_the_tools(
    data_store: DataPackStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "my_agent.py").write_text(
        "from inspect_ai.agent import react\n\n\n"
        "async def until_done(state):\n    return bool(state.output.message.tool_calls)\n\n\n"
        "def brief(tools):\n"
        "    return react(prompt='Be brief.', tools=tools, submit=False, on_continue=until_done)\n"
    )
    monkeypatch.chdir(tmp_path)
    outputs = [*map(call, gold()), tool("done"), ModelOutput.from_content("mockllm/model", "That is all.")]
    log = play(scripted(outputs), tmp_path, harness="my_agent:brief")
    about = outcome_of(log)
    assert (about["success"], about["harness"]) == (True, "my_agent:brief")
    (sample,) = log.samples or ()
    assert "Be brief." in sample.messages[0].text


def test_an_unknown_harness_is_refused(data_store: DataPackStore) -> None:
    with pytest.raises(InputError, match=r"agent\.harness: expected .*module:object"):
        AgentSetting.read("agent", {"harness": "reakt"})
    with pytest.raises(InputError, match="eai has no object 'nobody'"):
        make_episode_prompts_and_metadata(
            AgentSetting(harness="eai:nobody"), {}, open_suite("virtualhome", ACTING)
        )


def test_an_episode_of_looking_ends_at_the_step_limit(data_store: DataPackStore, tmp_path: Path) -> None:
    looks = [tool("look") for _ in range(200)]
    about = outcome_of(play(scripted(looks), tmp_path, steps=2))
    assert (about["success"], about["ended"]) == (False, "steps")


def slowly(outputs: Sequence[ModelOutput]) -> Iterator[ModelOutput]:
    for output in outputs:
        time.sleep(0.4)
        output.usage = ModelUsage(input_tokens=1, output_tokens=1, total_tokens=2)
        yield output


def test_episodes_of_a_log_are_scored_by_their_mean(data_store: DataPackStore, tmp_path: Path) -> None:
    outputs = [*map(call, gold()), tool("done"), tool("done")]
    task = TASKS["virtualhome_acting"](tasks=[TASK])
    quietly = {"log_dir": str(tmp_path / "logs"), "display": "none", "max_samples": 1}
    (log,) = inspect_ai.eval(task, model=scripted(outputs), epochs=2, **quietly)  # type: ignore[arg-type]
    for sample in log.samples or ():
        sample.output.completion = "what another solver says at the end"
    file = tmp_path / "log.eval"
    write_eval_log(log, str(file))
    suite = open_suite("virtualhome", ACTING)
    found = read_answers(file, suite)
    assert [answers.model for answers in (found, *found.further_epochs)] == ["mockllm_model"] * 2
    chosen = ("--domain", "virtualhome", "--ability", "acting", "--allow-missing", "--json")
    ran = eai("score", str(file), *chosen, "--out", str(tmp_path / "scores"))
    assert ran.status == 0, ran.err
    printed = json.loads(ran.out)[0]
    success = printed["metrics"]["success"]
    assert (success["numerator"], success["denominator"]) == (0.5, 1)
    records = {record.task_id: record for record in read_records(tmp_path / "scores" / "records.jsonl")}
    assert records[TASK].verdict.success, "the first episode is shown"  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("limit", "ended"),
    [({"tokens": 5}, "tokens"), ({"seconds": 1}, "time"), ({"steps": 2, "feedback": "facts"}, "turns")],
)
def test_a_limit_ends_the_episode_and_it_is_scored(
    data_store: DataPackStore, tmp_path: Path, limit: dict[str, object], ended: str
) -> None:
    looks = [tool("look") for _ in range(20)]
    model = scripted(looks)
    if ended == "time":
        model = get_model("mockllm/model", custom_outputs=slowly(looks))
    about = outcome_of(play(model, tmp_path, **limit))
    assert (about["status"], about["success"], about["ended"]) == ("scored", False, ended)


def test_slips_are_drawn_from_the_seed_and_replayed(data_store: DataPackStore, tmp_path: Path) -> None:
    outputs = [*map(call, gold()), tool("done")]
    about = outcome_of(play(scripted(outputs), tmp_path, slip=1.0))
    turns = about["turns"]
    assert isinstance(turns, list)
    assert (about["status"], about["success"]) == ("scored", False)
    assert turns[0]["slipped"]
    assert all(turn["slipped"] is (turn["fault"] is None) for turn in turns if turn["is_action"])


def test_a_command_is_the_last_line_or_a_json_answer() -> None:
    assert find_command_in_reply("First I look.\n\nOPEN(jar_0) \n") == "OPEN(jar_0)"
    assert find_command_in_reply('{"OPEN": ["jar"],\n "x": []}') == '{"OPEN": ["jar"],\n "x": []}'
    assert find_command_in_reply("") == ""


def run(out: Path, *words: object) -> None:
    done = eai("run", "--ability", "acting", "--domain", "virtualhome", "--tasks", TASK, "--out", out, *words)
    assert done.status == 0, done.err


def test_built_in_models_act(data_store: DataPackStore, tmp_path: Path) -> None:
    models = ("oracle", "explorer", "random", "planner", "empty", "lookup")
    run(tmp_path, *[word for name in models for word in ("--model", f"eai/{name}")])
    won = {}
    for name in models:
        (record,) = read_records(tmp_path / "virtualhome" / "acting" / f"eai_{name}" / "records.jsonl")
        won[name] = record.verdict.success  # type: ignore[attr-defined]
    assert (won["oracle"], won["explorer"], won["random"], won["empty"]) == (True, True, False, False)
    (ran, _) = (each for each in read_runs([tmp_path]) if each.key.model in ("eai/oracle", "eai/empty"))
    assert ran.log is not None
    assert (tmp_path / "logs" / ran.log[0]).exists()
    replayed = tmp_path / "virtualhome" / "acting" / "eai_oracle" / "eai_oracle_outputs.json"
    done = eai(
        "score", replayed, "--ability", "acting", "--domain", "virtualhome", "--out", tmp_path / "again"
    )
    assert done.status == 0, done.err
    run(tmp_path, "--model", "eai/oracle", "--with", "agent.harness=text")
    (by_text,) = read_records(
        tmp_path / "virtualhome" / "acting" / "eai_oracle" / "harness-text" / "records.jsonl"
    )
    assert by_text.verdict.harness == "text"  # type: ignore[attr-defined]


def test_a_killed_run_keeps_finished_episodes_and_restarts_the_others(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    words = (
        "run --ability acting --domain virtualhome --model eai/oracle --limit 6 --with requests.max_retries=0"
    )
    folder = tmp_path / "virtualhome" / "acting" / "eai_oracle"
    begun, journal = folder / "begun.jsonl", folder / "answers.jsonl"
    first = Command(*words.split(), "--out", tmp_path)
    deadline = time.monotonic() + 300
    while time.monotonic() < deadline and not (journal.exists() and journal.read_bytes().count(b"\n") >= 2):
        time.sleep(0.01)
    first.signal(signal.SIGKILL)
    first.outcome()
    finished = journal.read_text().splitlines(keepends=True)
    if len(finished) == len(begun.read_text().splitlines()):  # it was killed between two: lose the last one
        journal.write_text("".join(finished[:-1]))
    kept = [json.loads(line)["task_id"] for line in journal.read_text().splitlines()]
    (unfinished,) = {json.loads(line)[0] for line in begun.read_text().splitlines()}.difference(kept)
    done = eai(*words.split(), "--out", tmp_path)
    assert done.status == 0, done.err
    records = read_records(folder / "records.jsonl")
    times = {record.task_id: record.verdict.begun for record in records}  # type: ignore[attr-defined]
    assert all(times[task_id] == 1 for task_id in kept)
    assert times[unfinished] == 2
    assert "1 episode interrupted before, begun again" in done.err
