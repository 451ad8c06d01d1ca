"""Replanning with a model: equal attempts in ``eai run``, ``inspect eval`` and a loop without Inspect."""

from __future__ import annotations

import json
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator
from concurrent.futures import Executor
from pathlib import Path

import pytest
from inspect_ai.log import read_eval_log

from by_path import ROOT
from eai.abilities.feedback import REASONS_PREFIX
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.replanning_options import FeedbackLevel, ReplanningOptions
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import make_noisy_answer, make_noisy_answer_heeding_feedback
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.suite import open_suite
from eai.results.codec import record_to_json
from eai.results.record import Record
from eai.results.records import read_records
from eai.results.trials import make_replanning_conversation_factory
from eai.tasks.source import Source
from processes import eai, own_process
from run.child import Asked, Whom, evaluate_experiment_in_child, score_in_child
from run.server import Reply, serve
from suites import answer_book, official_prompts
from sweeps import first_of, sweep, swept

ACTIONS = Ability.ACTION_SEQUENCING
TASKS = 8
RATE = 0.3
RUN = f"run --domain behavior --ability action_sequencing --limit {TASKS} --json"
NOISY = f"{RUN} --model eai/noisy -M rate={RATE}"
FOLDER = Path("behavior", "action_sequencing", "eai_noisy")


@pytest.fixture(scope="module")
def process() -> Iterator[Executor]:
    """A process of its own for Inspect."""
    with own_process() as pool:
        yield pool


def records_of(folder: Path) -> list[Record]:
    return list(read_records(folder / "records.jsonl"))


def offline(
    options: ReplanningOptions, store: DataPackStore, heed: float | None
) -> dict[str, list[tuple[str, object]]]:
    """Return the answers and verdicts of the loop without Inspect, by task."""
    suite, library = open_suite("behavior", ACTIONS, source=Source(store)), PromptLibrary("official")
    prompts = library.open(suite.benchmark, ACTIONS)
    trials = make_replanning_conversation_factory(
        suite, options, library.make_question_writer(suite.benchmark, ACTIONS, prompts), prompts
    )
    book = answer_book("behavior", ACTIONS, store)
    found = {}
    for task_id in suite.task_ids[:TASKS]:
        inquiry = trials.start_conversation(task_id)
        while not inquiry.is_over:
            attempt = len(inquiry.attempts) + 1
            if heed is None:
                seed = "0 1" + (f" {attempt}" if attempt > 1 else "")
                text = make_noisy_answer(book, task_id, RATE, seed).text
            else:
                shown = inquiry.question.user
                text = make_noisy_answer_heeding_feedback(
                    book, task_id, shown, attempt, error_rate=RATE, seed="0 1", repair_probability=heed
                ).text
            inquiry.add_answer(text)
        found[task_id] = [(attempt.response, attempt.verdict) for attempt in inquiry.attempts]
    return found


@pytest.mark.parametrize(("feedback", "heed"), first_of([("explained", 1.0), ("none", None)]))
def test_a_run_makes_the_same_attempts_as_a_loop_without_inspect(
    feedback: FeedbackLevel, heed: float | None, data_store: DataPackStore, tmp_path: Path
) -> None:
    """The files of the run can be replayed, and give the same records."""
    arguments = f"--with replanning.replans=2 --with replanning.feedback={feedback}"
    heeding = "" if heed is None else f"-M heed={heed}"
    done = eai(*f"{NOISY} {heeding} {arguments} --out {tmp_path}".split())
    assert done.status == 0, done.err
    label = f"replans-2-restart-{feedback}"
    folder = tmp_path / FOLDER / label
    records = records_of(folder)
    attempts = {
        record.task_id: [(attempt.response, attempt.verdict) for attempt in record.attempts]
        for record in records
    }
    assert attempts == offline(ReplanningOptions(2, feedback=feedback), data_store, heed)
    assert {record.experiment.label for record in records if record.experiment} == {label}
    assert [record.verdict for record in records] == [record.attempts[-1].verdict for record in records]
    assert not list((tmp_path / FOLDER).glob("*.json*"))
    summary = json.loads((folder / "summary.json").read_text())
    by_attempt = [each["task_success"]["numerator"] for each in summary["by_attempt"]]
    assert by_attempt == sorted(by_attempt)
    assert by_attempt[-1] == summary["task_success"]["numerator"]
    assert summary["study"]["replanning"]["label"] == label
    replayed = tmp_path / "replayed"
    again = eai(*f"{RUN} --model eai/replay -M path={folder} {arguments} --out {replayed}".split())
    assert again.status == 0, again.err
    copied = records_of(replayed / "behavior" / "action_sequencing" / "eai_replay" / label)
    assert [record.attempts for record in copied] == [record.attempts for record in records]


def test_feedback_on_a_failure_reaches_the_model(data_store: DataPackStore, tmp_path: Path) -> None:
    """A server gets the first question, then the question with its own answer and why that failed."""
    (task_id, prompt), *_ = official_prompts("behavior", ACTIONS, data_store).items()
    gold = answer_book("behavior", ACTIONS, data_store)[task_id].text
    wrong = '[{"action": "OPEN", "object": "moon_1"}]'
    script = defaultdict(lambda: [Reply(gold)], {prompt.user: [Reply(wrong)]})
    with serve(script) as served:
        arguments = f"run --model openai-api/local/scripted -M api_key=none --model-base-url {served.url}"
        arguments += (
            f" --domain behavior --tasks {task_id} --with replanning.replans=3 --json --out {tmp_path}"
        )
        done = eai(*arguments.split())
        assert done.status == 0, done.err
        said = [[message["content"] for message in each["messages"]] for each in served.log.requests]
    assert [len(messages) for messages in said] == [1, 1]
    (first,), (second,) = said
    assert first == prompt.user
    assert second.startswith(prompt.user.rstrip())
    feedback = second.removeprefix(prompt.user.rstrip())
    assert wrong in feedback
    assert REASONS_PREFIX in feedback
    assert "there is no moon_1" in feedback


@pytest.mark.parametrize("slip", [0.2, *swept(0.0)])
def test_inspect_takes_the_same_options(
    slip: float, data_store: DataPackStore, process: Executor, tmp_path: Path
) -> None:
    """Inspect's log has the records of ``eai run``, and scoring it again changes nothing."""
    world = {"world": "continue", "feedback": "state"} if slip else {"feedback": "explained"}
    choices = {"replans": 2, **world, "slip": slip}
    options = " ".join(f"--with replanning.{name}={value}" for name, value in choices.items())
    done = eai(*f"{NOISY} {options} --out {tmp_path}".split())
    assert done.status == 0, done.err
    (folder,) = (tmp_path / FOLDER).iterdir()
    records = {record.task_id: record for record in records_of(folder)}
    asked = Asked("behavior", ACTIONS, Protocol.STRICT, list(records))
    whom = Whom("eai/noisy", {"rate": RATE})
    path = process.submit(evaluate_experiment_in_child, asked, whom, tmp_path, choices).result()
    scored = process.submit(score_in_child, path, asked).result()
    for log in (read_eval_log(path), read_eval_log(scored)):
        assert log.samples
        for sample in log.samples:
            told = (sample.scores or {})[ACTIONS.value].metadata or {}
            record = record_to_json(records[str(sample.id)].drop_explanations())
            same = ("study", "success", "executable", "error", "goals", "additional_steps")
            assert {name: told[name] for name in same} == {name: record[name] for name in same}
            assert len(told["attempts"]) == len(records[str(sample.id)].attempts)
            assert len(sample.messages) == 2 * len(told["attempts"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            "--with replanning.feedback=kind",
            "feedback kind: has no effect without further attempts; also give replanning.replans",
        ),
        (
            "--with replanning.replans=1 --with replanning.feedback=state",
            "feedback state: has no effect if attempts restart in the initial state; also give replanning",
        ),
        (
            "--with replanning.replans=1 --ability goal_interpretation",
            "only plans can be attempted again",
        ),
    ],
)
def test_contradicting_options_are_refused(options: str, message: str, tmp_path: Path) -> None:
    done = eai(*f"run --model eai/oracle --out {tmp_path} {options}".split())
    assert done.status == 2
    assert message in done.err


@sweep
def test_a_killed_and_resumed_experiment_loses_and_repeats_no_attempt(data_store: DataPackStore) -> None:
    """A few of the hundred cycles of the benchmark."""
    command = [sys.executable, "-m", "bench", "kill_and_resume", "--kills", "3", "--tasks", "6"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert (found["lost"], found["doubled"], found["differing"]) == (0, 0, 0)
    assert found["kills"] == 3
