"""A run that is killed in the middle and restarted gets the same results and asks nothing twice."""

from __future__ import annotations

import json
import signal
import time
from functools import partial
from pathlib import Path

import pytest
from inspect_ai.log import read_eval_log

from eai.abilities.protocol import Ability
from eai.base.errors import EaiError
from eai.base.store import DataPackStore
from eai.benchmarks.suite import open_suite
from eai.run.job import QuestionJob
from eai.run.tasks import request_missing_answers
from eai.studies.variation import ModelEndpoint
from processes import Command
from run.hindrances import interrupt_at
from run.server import Reply, serve
from suites import answer_book, official_prompts

SUITE = ("virtualhome", Ability.ACTION_SEQUENCING)
RESULTS = Path("virtualhome", "action_sequencing", "openai-api_local_scripted")
TASKS = 10
KILLED_AFTER = 4


def start(url: str, out: Path) -> Command:
    """Return the command of a run that asks one question after the other."""
    arguments = f"run --model openai-api/local/scripted -M api_key=none --model-base-url {url}".split()
    arguments += f"--domain virtualhome --ability action_sequencing --limit {TASKS}".split()
    arguments += f"--max-connections 1 --with requests.max_retries=0 --json --out {out}".split()
    return Command(*arguments)


def test_a_killed_run_resumes_where_it_stopped(data_store: DataPackStore, tmp_path: Path) -> None:
    prompts = dict(list(official_prompts(*SUITE, data_store).items())[:TASKS])
    gold = answer_book(*SUITE, data_store)
    script = {prompt.user: [Reply(gold[task_id].text, delay=0.1)] for task_id, prompt in prompts.items()}
    with serve(script) as served:
        first = start(served.url, tmp_path / "killed")
        deadline = time.monotonic() + 300
        while sum(served.log.asked.values()) <= KILLED_AFTER and time.monotonic() < deadline:
            time.sleep(0.01)
        first.signal(signal.SIGKILL)
        first.outcome()
        journal = tmp_path / "killed" / RESULTS / "answers.jsonl"
        finished = [json.loads(line)["task_id"] for line in journal.read_text().splitlines()]
        assert KILLED_AFTER <= len(finished) < TASKS
        resumed = start(served.url, tmp_path / "killed")
        status, printed, errors = resumed.outcome()
        assert status == 0, errors
        for task_id, prompt in prompts.items():
            assert served.log.asked[prompt.user] == 1 or task_id not in finished
        killed, at_once = str(tmp_path / "killed"), tmp_path / "at_once"
        assert start(served.url, at_once).outcome().out == printed.replace(killed, str(at_once))
    for name in ("records.jsonl", "summary.json", "openai-api_local_scripted_outputs.json"):
        interrupted, whole = (tmp_path / run / RESULTS / name for run in ("killed", "at_once"))
        assert interrupted.read_bytes() == whole.read_bytes()
    assert json.loads(printed)[0]["metrics"]["task_success"]["numerator"] == TASKS
    log = read_eval_log(max((tmp_path / "killed" / "logs").glob("*.eval")))
    samples, results = log.samples or [], log.results
    assert {
        sample.id: (sample.scores or {})["action_sequencing"].value for sample in samples
    } == dict.fromkeys(prompts, "C")
    assert {sample.messages[-1].text for sample in samples} == {gold[task_id].text for task_id in prompts}
    assert results is not None
    assert results.scores[-1].metrics["task_success"].value == 1.0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_says_how_to_resume(
    data_store: DataPackStore, tmp_path: Path, number: signal.Signals
) -> None:
    """An interrupt at any time is reported in one line, without a traceback."""
    prompts = dict(list(official_prompts(*SUITE, data_store).items())[:TASKS])
    script = {prompt.user: [Reply("{}", delay=0.3)] for prompt in prompts.values()}
    with serve(script) as served:
        run = start(served.url, tmp_path)
        deadline = time.monotonic() + 300
        while not served.log.asked and time.monotonic() < deadline:
            time.sleep(0.01)
        run.signal(number)
        status, printed, errors = run.outcome()
    assert (status, printed) == (128 + number, "")
    assert errors.splitlines()[-1] == "eai: interrupted; the same command resumes from here"


def must_stop_after_one_more_answer(model: str, ability: str, domain: str, out: Path) -> None:
    """Fail unless an interrupted run ends after at most one more answer."""
    arguments = f"run --model {model} --domain {domain} --limit {TASKS} --out {out}".split()
    arguments += f"--ability {ability} --max-connections {TASKS}".split()
    done = Command(*arguments, before=partial(interrupt_at, KILLED_AFTER)).outcome()
    assert (done.status, done.out) == (130, ""), done.err
    assert done.err.splitlines()[-1] == "eai: interrupted; the same command resumes from here"
    (journal,) = out.glob(f"*/{ability}/{model.replace('/', '_')}/answers.jsonl")
    assert KILLED_AFTER <= len(journal.read_text().splitlines()) <= KILLED_AFTER + 1


def test_a_built_in_model_computes_at_most_one_answer_after_an_interrupt(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    """A plan may take seconds, and a run once computed tens of them after an interrupt."""
    must_stop_after_one_more_answer("eai/planner", "action_sequencing", "virtualhome", tmp_path / "out")


def test_a_run_interrupted_before_its_first_question_says_how_to_resume(
    data_store: DataPackStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("inspect_ai.eval", lambda *arguments, **options: [])
    prompts = dict(list(official_prompts(*SUITE, data_store).items())[:1])
    job = QuestionJob(ModelEndpoint("eai/oracle"), open_suite(*SUITE), prompts)
    with pytest.raises(EaiError, match="interrupted; the same command resumes from here"):
        request_missing_answers(job, tmp_path / "a.jsonl", tmp_path / "logs")
