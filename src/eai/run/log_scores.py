"""Writes verdicts as scores into Inspect's log, sample by sample.

Inspect's own functions hold all samples of a log in memory.
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain, groupby
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any, TypeAlias
from zipfile import ZipFile

from inspect_ai.log import EvalLog, EvalSample, recompute_metrics, write_eval_log
from inspect_ai.scorer import Score
from pydantic_core import from_json

from eai.base.files import raise_write_errors_as_input_errors
from eai.results.epochs import SuiteResult
from eai.results.record import Record
from eai.results.trials import TaskIdAndEpoch
from eai.run.scorer import RECORD, make_score
from eai.run.tasks import read_inspect_log

_START = "_journal/start.json"

_UNSUMMARIZED: dict[str, Any] = {"events": [], "events_data": None, "attachments": {}, "store": {}}
"""Large fields of a sample with empty values: Inspect's summary of a sample does not need them."""

_RecordOfEpoch: TypeAlias = tuple[Record, int]
"""A record (scored answer), and its epoch (round of answers to all tasks)."""

_LONE_SURROGATE = re.compile("[\ud800-\udfff]")


def write_scores(logs: Mapping[str, Path], result: SuiteResult) -> None:
    """Write verdicts as scores into logs. The new scores replace the scores that the logs have.

    Args:
        logs: mapping from each asked task to its log; tasks of a log are consecutive.
        result: the scored answers to all requests.

    Raises:
        InputError: a log cannot be read or written.
    """
    kept = result.map_keys_to_records()
    of_epochs = [
        _group_by_log(records, epoch, logs) for epoch, records in enumerate(result.read_records_by_epoch(), 1)
    ]
    for groups in zip(*of_epochs, strict=True):
        path = groups[0][0]
        _write_scores_of_log(path, chain.from_iterable(scored for _, scored in groups), kept, result)


def _group_by_log(
    records: Iterable[Record], epoch: int, logs: Mapping[str, Path]
) -> Iterator[tuple[Path, Iterator[_RecordOfEpoch]]]:
    """Yield each log with the records (scored answers) of its tasks. Skip tasks without a log."""
    asked = ((record, epoch) for record in records if record.task_id in logs)
    return groupby(asked, key=lambda scored: logs[scored[0].task_id])


def _write_scores_of_log(
    path: Path,
    scored: Iterable[_RecordOfEpoch],
    kept: Mapping[TaskIdAndEpoch, Record],
    result: SuiteResult,
) -> None:
    """Write the scores of one log.

    Args:
        path: the log.
        scored: for each sample of the log, the whole record (scored answer) and the epoch. The sample's
            score is made from the record.
        kept: for each task and epoch, the record without explanations, which takes less memory. The log's
            metrics are computed from these records.
        result: the scored answers to all requests of the run; the log states its scoring rules and errata.
    """
    log = read_inspect_log(path, header_only=True)
    log.samples, partial_file = [], path.with_name(f".{path.stem}.part")
    try:
        with (
            raise_write_errors_as_input_errors(path),
            TemporaryFile() as summaries,
            ZipFile(path) as old,
            ZipFile(partial_file, "w", old.getinfo(_START).compress_type) as new,
        ):
            new.writestr(_START, old.read(_START))
            summaries.write(b"[")
            for record, epoch in scored:
                name = f"samples/{record.task_id}_epoch_{epoch}.json"
                sample = from_json(old.read(name))
                score = make_score(record, epoch, answered=bool(sample["output"]["choices"]))
                sample["scores"] = {record.ability.value: score.model_dump(mode="json", exclude_none=True)}
                new.writestr(name, _dump_json(sample))
                summary = EvalSample.model_validate({**sample, **_UNSUMMARIZED}).summary()
                summaries.write(b"," if log.samples else b"")
                summaries.write(_dump_json(summary.model_dump(mode="json", exclude_none=True)))
                log.samples.append(_make_scored_sample(sample, score, kept[record.task_id, epoch]))
            summaries.write(b"]")
            summaries.seek(0)
            with new.open("summaries.json", "w", force_zip64=True) as file:
                shutil.copyfileobj(summaries, file)
            _add_metrics_and_data_set_to_log(log, result)
            reductions = [each.model_dump(mode="json", exclude_none=True) for each in log.reductions or ()]
            new.writestr("reductions.json", _dump_json(reductions))
        with raise_write_errors_as_input_errors(path):
            write_eval_log(log, partial_file, format="eval", header_only=True)
            partial_file.replace(path)
    finally:
        partial_file.unlink(missing_ok=True)


def _dump_json(value: object) -> bytes:
    """Return a value as JSON. A lone surrogate becomes the text of its escape, as in Inspect's own logs."""
    text = json.dumps(value, ensure_ascii=False)
    return _LONE_SURROGATE.sub(lambda match: f"\\\\u{ord(match[0]):04x}", text).encode()


def _make_scored_sample(sample: dict[str, Any], score: Score, record: Record) -> EvalSample:
    """Return a sample with only the fields from which metrics are computed."""
    metadata = {"epoch": sample["epoch"], "answered": (score.metadata or {})["answered"], RECORD: record}
    scores = {record.ability.value: Score(value=score.value, answer=record.response, metadata=metadata)}
    return EvalSample.model_construct(
        id=sample["id"],
        epoch=sample["epoch"],
        scores=scores,
        metadata={"domain": sample["metadata"]["domain"]},
        error=sample.get("error"),
    )


def _add_metrics_and_data_set_to_log(log: EvalLog, result: SuiteResult) -> None:
    """Compute the metrics of a log, and complete its header."""
    source, (protocol,) = result.suite.source, {record.protocol.value for record in result.records}
    rules = {"protocol": protocol, "planner": source.planner.value, "errata": source.errata.value}
    for scorer in log.eval.scorers or ():
        scorer.options = {**(scorer.options or {}), **rules}
    recompute_metrics(log)
    for reduction in log.reductions or ():
        for score in reduction.samples:
            score.metadata = None
    dataset = log.eval.dataset
    dataset.name, dataset.sample_ids = log.eval.task, list(dict.fromkeys(s.id for s in log.samples or ()))
    dataset.samples = len(dataset.sample_ids)
