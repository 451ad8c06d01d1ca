"""Export results in the formats of two collections: Every Eval Ever and the Hugging Face Hub.

`Every Eval Ever <https://github.com/evaleval/every_eval_ever>`_ takes one JSON file for each model. On the
Hugging Face Hub, a model's repository takes files ``.eval_results/*.yaml``. They name a data set, whose page
then shows their scores. The data set's tasks are listed in its ``eval.yaml``, which
``eai export prompts --format hf`` writes.
"""

from __future__ import annotations

import hashlib
import json
import re
import uuid
from collections.abc import Iterator, Mapping, Sequence
from datetime import date, datetime, timezone
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from eai import __version__
from eai.abilities.declaration import get_declaration, get_display_name
from eai.base.errors import InputError
from eai.base.grouping import group_pairs
from eai.base.json_value import Json
from eai.benchmarks.names import suite_name
from eai.benchmarks.registry import list_paper_benchmarks
from eai.studies.report.run_summary import RunSummary
from eai.tasks.options import Options

SCHEMA = "0.3.0"
"""Version of the schema of Every Eval Ever that exported files follow."""

_PAPER = "https://embodied-agent-interface.github.io"


_OwnerAndName = Annotated[str, Field(pattern=r"^[A-Za-z0-9][\w.-]*/[A-Za-z0-9][\w.-]*$")]
"""Name of a model or data set in Every Eval Ever and on the Hugging Face Hub: OWNER/NAME."""


class _PublicationMetadata(Options):
    """The content of the publication file: evaluator, date, and public names of models and data set."""

    by: str = Field(min_length=1)
    date: date
    relationship: Literal["first_party", "third_party", "collaborative", "other"] = "third_party"
    url: str = Field("", pattern=r"^(https://\S+)?$")
    logs: str = Field("", pattern=r"^(https://\S+)?$")
    dataset: _OwnerAndName | None = None
    models: Mapping[str, _OwnerAndName] = Field(min_length=1)


def make_files_to_publish(metadata_file: Path, runs: Sequence[RunSummary]) -> dict[str, str]:
    """Return a mapping from the relative path of each file to publish to its content.

    Runs that no ranking contains are left out.

    Args:
        metadata_file: TOML file with ``by``, ``date`` and ``models``, the models to publish; optionally also
            ``relationship``, ``url``, ``logs`` and ``dataset``.
        runs: runs of any models, suites and protocols, sorted by their keys.

    Raises:
        InputError: the file cannot be read or is malformed, or two models get one file.
    """
    metadata = _PublicationMetadata.read_file(metadata_file)
    plain = [
        run
        for run in runs
        if run.key.has_standard_rules_and_no_study_options and run.key.model in metadata.models
    ]
    rows = group_pairs(
        ((run.key.protocol.value, run.key.name), run)
        for run in plain
        if run.coverage.is_complete_enough_for_ranking
    )
    written = {}
    for (protocol, name), suites in rows.items():
        record = _make_eval_record(metadata, suites)
        model = suites[0].key.model
        place = metadata.models[model]
        written[f"every_eval_ever/data/eai/{place}/{_make_content_uuid(record)}.json"] = (
            f"{json.dumps(record, indent=2)}\n"
        )
        if metadata.dataset:
            variant = _to_file_name_part(protocol + name.removeprefix(model))
            file = f"hugging_face/{place}/.eval_results/eai-{variant}.yaml"
            if file in written:
                raise InputError(
                    f"{metadata_file}: several models or variants are published in {file}; keep one of them"
                )
            written[file] = "".join(_write_hugging_face_results(metadata, suites))
    return written


def _to_file_name_part(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9.]+", "-", text)[:100]


def _make_content_uuid(record: Mapping[str, Any]) -> uuid.UUID:
    """Return a UUID, version 4, made from an exported result. Equal results have equal UUIDs."""
    return uuid.UUID(bytes=hashlib.sha256(json.dumps(record).encode()).digest()[:16], version=4)


def _make_eval_record(metadata: _PublicationMetadata, runs: Sequence[RunSummary]) -> dict[str, Any]:
    key = runs[0].key
    model = metadata.models[key.model]
    seconds = int(datetime.combine(metadata.date, datetime.min.time(), timezone.utc).timestamp())
    source = {
        "source_name": "eai",
        "source_type": "evaluation_run",
        "source_organization_name": metadata.by,
        "evaluator_relationship": metadata.relationship,
    }
    return {
        "schema_version": SCHEMA,
        "evaluation_id": f"eai-{key.protocol.value}/{model}/{seconds}",
        "retrieved_timestamp": str(seconds),
        "source_metadata": {**source, **({"source_organization_url": metadata.url} if metadata.url else {})},
        "eval_library": {"name": "eai", "version": __version__},
        "model_info": {
            "name": key.name,
            "id": model,
            "additional_details": {"deployment_type": "unknown", "model_availability": "unknown"},
        },
        "evaluation_results": [
            result for run in runs for result in _convert_run_to_every_eval_ever_results(metadata, run)
        ],
    }


def _convert_run_to_every_eval_ever_results(
    metadata: _PublicationMetadata, run: RunSummary
) -> Iterator[dict[str, Json]]:
    """Yield the main metrics of a run as JSON values, each in percent with its confidence interval."""
    key = run.key
    for metric in get_declaration(key.ability).overview_headings:
        rate = run.rates.get(metric)
        if rate is None or rate.percent is None:
            continue
        name = suite_name(key.domain, key.ability)
        yield {
            "evaluation_result_id": f"{name}.{metric}",
            "evaluation_name": name,
            "source_data": _make_data_set_json(metadata, run),
            "metric_config": {
                "metric_id": metric,
                "metric_name": get_display_name(metric),
                "metric_unit": "percent",
                "lower_is_better": False,
                "score_type": "continuous",
                "min_score": 0,
                "max_score": 100,
            },
            "score_details": {"score": rate.percent, **_make_uncertainty(run, metric)},
        }


def _make_data_set_json(metadata: _PublicationMetadata, run: RunSummary) -> dict[str, Json]:
    """Return a JSON value that names the source of the tasks, the protocol, and the digests of the data."""
    key = run.key
    details: dict[str, Json] = {
        "protocol": key.protocol.value,
        "data_sha256": " ".join(run.data_sha256),
        "tasks": str(run.coverage.tasks),
        "answered": str(run.coverage.answered),
    }
    place: dict[str, Json] = {"source_type": "other"}
    if key.domain in list_paper_benchmarks():
        place = {"source_type": "url", "url": [_PAPER]}
    elif metadata.dataset:
        place = {"source_type": "hf_dataset", "hf_repo": metadata.dataset}
    return {"dataset_name": key.domain, **place, "additional_details": details}


def _make_uncertainty(run: RunSummary, metric: str) -> dict[str, Json]:
    sure = run.certainties.get(metric)
    if sure is None:
        return {}
    low, high = sure.interval
    interval: dict[str, Json] = {"lower": low, "upper": high, "confidence_level": 0.95}
    interval["method"] = "Wilson, with the tasks of one name as one unit"
    return {"uncertainty": {"confidence_interval": interval, "num_samples": sure.tasks}}


def _write_hugging_face_results(metadata: _PublicationMetadata, runs: Sequence[RunSummary]) -> Iterator[str]:
    """Yield the first main metric of each suite as YAML. Strings are quoted as in JSON, which YAML allows."""
    for run in runs:
        key = run.key
        metric = next(iter(get_declaration(key.ability).overview_headings))
        percent = run.rates[metric].percent
        if percent is None:
            continue
        yield (
            f"- dataset:\n    id: {json.dumps(metadata.dataset)}\n"
            f"    task_id: {json.dumps(suite_name(key.domain, key.ability))}\n"
            f'  value: {percent}\n  date: "{metadata.date}"\n  evaluation_framework: inspect-ai\n'
        )
        if metadata.logs:
            yield f"  source:\n    url: {json.dumps(metadata.logs)}\n    name: {json.dumps(metadata.by)}\n"
        notes = f"{get_display_name(metric)}, {key.name}, protocol {key.protocol.value}"
        yield f"  notes: {json.dumps(notes)}\n"
