"""Scores are written into a log sample by sample, and the log is as if Inspect had written it at once."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from inspect_ai.log import (
    EvalLog,
    read_eval_log,
    read_eval_log_sample_summaries,
    recompute_metrics,
    write_eval_log,
)

from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from eai.benchmarks.suite import open_suite
from eai.results.epochs import SuiteResult, score_answers
from eai.results.options import ScoringOptions
from eai.run.job import QuestionJob
from eai.run.log_scores import write_scores
from eai.run.scorer import make_score
from eai.run.tasks import find_log
from eai.studies.variation import ModelEndpoint
from processes import own_process
from run.child import obtain_with_logs_of
from suites import official_prompts

SUITE = ("virtualhome", Ability.ACTION_SEQUENCING)
TASKS = 7
EPOCHS = 2


def ask(
    folder: Path, store: DataPackStore, max_samples: int = TASKS * EPOCHS
) -> tuple[QuestionJob, SuiteResult, Mapping[str, Path]]:
    """Ask a built-in model, and return the job, its result and its logs without scores."""
    prompts = dict(list(official_prompts(*SUITE, store).items())[:TASKS])
    endpoint = ModelEndpoint("eai/noisy", {"rate": 0.5})
    job = QuestionJob(endpoint, open_suite(*SUITE), prompts, EPOCHS)
    with own_process() as process:
        places = folder / "answers.jsonl", folder / "logs"
        answers = process.submit(obtain_with_logs_of, max_samples, job, *places).result()
    result = score_answers(answers, folder / "out", job.suite, ScoringOptions())
    return job, result, answers.logs


def write_at_once(path: Path, result: SuiteResult) -> None:
    """Write scores with Inspect's own functions."""
    log = read_eval_log(str(path))
    of_epochs = enumerate(result.read_records_by_epoch(), 1)
    records = {(record.task_id, epoch): record for epoch, of_epoch in of_epochs for record in of_epoch}
    for sample in log.samples or ():
        record = records[str(sample.id), sample.epoch]
        score = make_score(record, sample.epoch, answered=bool(sample.output.choices))
        sample.scores = {record.ability.value: score}
    recompute_metrics(log)
    write_eval_log(log, str(path))


def contents(log: EvalLog) -> object:
    results = log.results
    assert results is not None
    sizes = (results.total_samples, results.completed_samples)
    samples = [json.loads(sample.model_dump_json()) for sample in log.samples or ()]
    return sizes, [score.model_dump_json() for score in results.scores], results.headline, samples


def test_scores_are_written_as_inspect_writes_them(data_store: DataPackStore, tmp_path: Path) -> None:
    job, result, logs = ask(tmp_path, data_store)
    (path,) = set(logs.values())
    expected = tmp_path / "expected.eval"
    shutil.copy(path, expected)
    write_at_once(expected, result)
    write_scores(logs, result)
    log = read_eval_log(str(path))
    assert contents(log) == contents(read_eval_log(str(expected)))
    summaries, others = [
        sorted(each.model_dump_json() for each in read_eval_log_sample_summaries(str(file)))
        for file in (path, expected)
    ]
    assert summaries == others
    assert (log.eval.dataset.samples, log.eval.dataset.sample_ids) == (TASKS, list(job.prompts))
    assert [path.name for path in (tmp_path / "logs").iterdir()] == [path.name]
    assert find_log(job, tmp_path / "logs") == path
    write_scores(logs, result)  # again, over the scores that the log has
    assert contents(read_eval_log(str(path))) == contents(log)


def test_lone_surrogates_are_written_as_text(data_store: DataPackStore, tmp_path: Path) -> None:
    _, result, logs = ask(tmp_path, data_store)
    (path,) = set(logs.values())
    records = [replace(record, unanswered="lone \udc80") for record in result.by_epoch[0].records]
    folder = result.by_epoch[0].folder
    lines = [json.loads(line) for line in (folder / "records.jsonl").read_text().splitlines()]
    changed = [json.dumps({**line, "unanswered": "lone \udc80"}) for line in lines]
    (folder / "records.jsonl").write_text("\n".join(changed))
    first = replace(result.by_epoch[0], records=records)
    write_scores(logs, replace(result, by_epoch=(first, *result.by_epoch[1:])))
    sample = (read_eval_log(str(path)).samples or [])[0]
    assert "lone \\udc80" in ((sample.scores or {})[SUITE[1].value].explanation or "")


def test_a_large_run_has_several_logs_that_are_scored_and_found_again(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    job, result, logs = ask(tmp_path, data_store, max_samples=3 * EPOCHS)
    paths = list(dict.fromkeys(logs.values()))
    assert [[task_id for task_id in logs if logs[task_id] == path] for path in paths] == [
        list(job.prompts)[start : start + 3] for start in range(0, TASKS, 3)
    ]
    for path in paths:
        expected = tmp_path / f"expected_{path.name}"
        shutil.copy(path, expected)
        write_at_once(expected, result)
    write_scores(logs, result)
    for path in paths:
        assert contents(read_eval_log(str(path))) == contents(
            read_eval_log(str(tmp_path / f"expected_{path.name}"))
        )
    written = {path: path.read_bytes() for path in paths}
    assert ask(tmp_path, data_store, max_samples=3 * EPOCHS)[2] == logs
    assert {path: path.read_bytes() for path in (tmp_path / "logs").iterdir()} == written
