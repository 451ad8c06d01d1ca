"""Export the data set as Croissant 1.0: JSON lines, and metadata that data loaders and catalogues read.

The library `mlcroissant`, by the authors of the format, writes the metadata (extra ``croissant``).
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from datetime import datetime, timezone
from itertools import islice
from pathlib import Path
from typing import Any

from eai.abilities.reports import action_text, fact_text
from eai.base.errors import EaiError, make_install_command
from eai.base.files import write_files_atomically
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.reference_wheel import EAI_EVAL, SCENE_PREFIX
from eai.tasks.source import Source
from eai.tasks.task_lines import write_goals

LICENCE = "https://creativecommons.org/licenses/by/4.0/"
"""Address of the license of the data set, as its authors give it."""

PAPER_CITATION = (
    "Li, M., Zhao, S., Wang, Q., Wang, K., Zhou, Y., et al. Embodied Agent Interface: Benchmarking LLMs for "
    "Embodied Decision Making. NeurIPS 2024, Datasets and Benchmarks Track."
)

PUBLICATION_DATE = datetime(2024, 10, 9, tzinfo=timezone.utc)
"""Publication date of the paper."""

TASK_FIELDS = {
    "id": "The id of the task, as files of answers name it.",
    "title": "The name that tasks of a kind share.",
    "instruction": "The task in natural language.",
    "goals": "What must be true in the end, or be done: formulas, each a goal.",
    "objects": "The objects that the task is about, by name.",
    "initially": "What holds at the start, of these objects alone.",
    "plan": "The data set's own plan, step by step; empty where it has none.",
}
OPERATOR_FIELDS = {
    "name": "The name of the operator.",
    "parameters": "Its parameters with their types, in PDDL.",
    "precondition": "Its precondition, in PDDL.",
    "effect": "Its effect, in PDDL.",
}
_LISTS = {"goals", "objects", "initially", "plan"}

Row = dict[str, str | list[str]]


def write_croissant_files(benchmarks: Sequence[Benchmark], source: Source, out: Path) -> list[Path]:
    """Write the tasks and the gold operators of benchmarks as JSON lines, and ``croissant.json`` beside them.

    Returns:
        the paths of the written files, that of the metadata last.

    Raises:
        EaiError: ``mlcroissant`` is not installed.
        InputError: the folder cannot be written to.
        DataError: the data set cannot be obtained.
    """
    try:
        import mlcroissant
    except ImportError as error:
        raise EaiError(
            f"Croissant needs mlcroissant ({error.name} is missing): {make_install_command('croissant')}"
        ) from error
    tables: dict[str, tuple[Mapping[str, str], list[Row]]] = {}
    for benchmark in benchmarks:
        tables[f"{benchmark.name}_tasks"] = TASK_FIELDS, list(make_task_rows(benchmark, source))
        tables[f"{benchmark.name}_operators"] = OPERATOR_FIELDS, list(make_operator_rows(benchmark, source))
    contents = {name: _to_json_lines(rows) for name, (_, rows) in tables.items()}
    metadata = mlcroissant.Metadata(
        name="eai-bench",
        description="Tasks of "
        + " and ".join(benchmark.title for benchmark in benchmarks)
        + ", as eai reads them.",
        cite_as=PAPER_CITATION,
        license=[LICENCE],
        url="https://embodied-agent-interface.github.io",
        version=EAI_EVAL.version,
        date_published=PUBLICATION_DATE,
        data_collection="Selected and annotated by the paper's authors (its appendix on annotation).",
        data_limitations=["4 of the 342 VirtualHome tasks have no goal.", "Near copies share a title."],
        distribution=[_make_file_object(mlcroissant, name, content) for name, content in contents.items()],
        record_sets=[_make_record_set(mlcroissant, name, fields) for name, (fields, _) in tables.items()],
    )
    described = json.dumps(metadata.to_json(), indent=2, ensure_ascii=False, default=str) + "\n"
    files = {f"{name}.jsonl": content for name, content in contents.items()}
    files["croissant.json"] = described.encode()
    write_files_atomically({out / name: content for name, content in files.items()})
    return [out / name for name in files]


def make_task_rows(benchmark: Benchmark, source: Source) -> Iterator[Row]:
    """Yield a row of the exported data set for each task of a benchmark."""
    for task in benchmark.tasks(source).values():
        facts = [fact for fact in task.initial.facts() if {*task.relevant}.issuperset(fact.arguments)]
        yield {
            "id": make_row_id(task.id),
            "title": task.title,
            "instruction": task.instruction,
            "goals": write_goals([goal.formula for goal in task.goals], benchmark.domain, task.scene),
            "objects": [task.scene.objects[i].name for i in task.relevant],
            "initially": [fact_text(fact, task.scene) for fact in facts],
            "plan": [action_text(step, task.scene) for step in task.script],
        }


def make_operator_rows(benchmark: Benchmark, source: Source) -> Iterator[Row]:
    """Yield a row for each gold operator of a benchmark, sorted by name. No operator tasks give no rows."""
    for task in islice(benchmark.operator_tasks(source).values(), 1):  # all tasks have the same operators
        yield from (asdict(text) for _, text in sorted(task.domain.operators.items()))


def make_row_id(task_id: str) -> str:
    """Return the id of a task's row.

    Loaders read ids such as ``27_2`` as 272, so such ids get the prefix of their scene.
    """
    return SCENE_PREFIX + task_id if task_id.replace("_", "").isdigit() else task_id


def _to_json_lines(rows: Sequence[Row]) -> bytes:
    return "".join(json.dumps(row, ensure_ascii=False) + "\n" for row in rows).encode()


def _make_file_object(croissant: Any, name: str, content: bytes) -> Any:
    return croissant.FileObject(
        id=f"{name}.jsonl",
        name=f"{name}.jsonl",
        content_url=f"{name}.jsonl",
        content_size=f"{len(content)} B",
        encoding_formats=["application/jsonlines"],
        sha256=hashlib.sha256(content).hexdigest(),
    )


def _make_record_set(croissant: Any, name: str, fields: Mapping[str, str]) -> Any:
    return croissant.RecordSet(
        id=name,
        name=name,
        key=[f"{name}/{next(iter(fields))}"],
        fields=[
            croissant.Field(
                id=f"{name}/{field}",
                name=field,
                description=meaning,
                data_types=croissant.DataType.TEXT,
                repeated=field in _LISTS,
                source=croissant.Source(file_object=f"{name}.jsonl", extract=croissant.Extract(column=field)),
            )
            for field, meaning in fields.items()
        ],
    )
