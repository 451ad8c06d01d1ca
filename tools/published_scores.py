"""Writes the table of the published answers under `strict`: `python tools/published_scores.py [FOLDER]`.

FOLDER holds the answers in `<domain>/<ability>/`, as `<model>_outputs.json` or, by default, as the verdicts
beside the repository hold them (`<model>.json.gz`). Every file whose name is that of a model's published
answers is scored, others are left alone, so that further models join the table by joining the folder.

    python tools/published_scores.py                    all suites, some minutes
    python tools/published_scores.py --only behavior    these alone; the others stay as they are
    python tools/published_scores.py --check            writes nothing; exit status 1 if a number differs

The numbers depend on the rules, the data and the answers alone, but for the planner of transition modeling,
which is given so many CPU seconds a task.
"""

from __future__ import annotations

import argparse
import gzip
import hashlib
import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from eai.abilities.codec import sha256_of
from eai.abilities.protocol import Ability
from eai.abilities.record import Record
from eai.abilities.responses import SUFFIX, Response, ResponseFile, read_responses
from eai.benchmarks.registry import FIRST
from eai.benchmarks.source import Source
from eai.benchmarks.suite import DEFAULT_PROTOCOL, Suite, open_suite
from eai.metrics.coverage import coverage_of
from eai.metrics.paper_tables import paper_models
from eai.metrics.published_scores import SCHEMA, TABLE
from eai.metrics.summary import summarise
from eai.pddl.planning import PlannerChoice
from eai.scoring.batch import NO_ROW, Settings, score_run

ROOT = Path(__file__).resolve().parents[1]
PATH = ROOT / "src" / "eai" / "metrics" / "paper" / TABLE
ANSWERS = ROOT.parent / "shared" / "oracle"
PACKED = ".json.gz"

NOTES: Mapping[str, Sequence[str]] = {
    "virtualhome/action_sequencing": (
        "The published VirtualHome plans name objects without ids: of two objects of one class that matter "
        "to a task they name one only, plans with ids both. The paper's tables were made from other plans.",
    ),
}
"""What a reader must know of the published answers to a suite."""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, nargs="?", default=ANSWERS)
    parser.add_argument("--only", default="", help="a part of DOMAIN/ABILITY")
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    arguments = parser.parse_args()
    known: dict[str, Any] = json.loads(PATH.read_text())["suites"] if PATH.exists() else {}
    suites = dict(known)
    for name in [f"{domain}/{ability.value}" for domain in FIRST for ability in Ability]:
        if arguments.only in name:
            suites[name] = scored_suite(name, arguments.folder)
            models = suites[name]["models"]
            same = "equal" if suites[name] == known.get(name) else "DIFFERS"
            print(f"{name:36} {len(models):3} models  {same}", flush=True)
    if not arguments.check:
        PATH.write_text(table_text(suites), encoding="utf-8")
    elif suites != known:
        sys.exit(1)


def scored_suite(
    name: str,
    folder: Path,
    *,
    only: Iterable[str] | None = None,
    planner: PlannerChoice = PlannerChoice.FULL,
) -> dict[str, Any]:
    """The part of the table on one suite, of all published models that the folder has answers of.

    Args:
        name: domain, slash, ability.
        folder: where the answers are.
        only: the names of the files, without ending, that are scored; all if None.
        planner: which planner judges operators.
    """
    domain, ability = name.split("/")
    suite = open_suite(domain, Ability(ability), DEFAULT_PROTOCOL, source=Source(planner=planner))
    metrics = list(summarise([], suite.ability))
    models: dict[str, Any] = {}
    for file, model in sorted(paper_models().items(), key=lambda item: item[1]):
        answers = find_answers(folder / domain / ability, file, suite)
        if answers is None or (only is not None and file not in only):
            continue
        if model in models:
            sys.exit(f"{folder / domain / ability}: two files of {model}")
        models[model] = scored(suite, answers, metrics)
    if not models:
        sys.exit(f"{folder / domain / ability}: no answers of the paper's models")
    return {
        "data_sha256": suite.data_sha256,
        "tasks": len(suite.task_ids),
        "metrics": metrics,
        "notes": list(NOTES.get(name, ())),
        "models": models,
    }


def scored(suite: Suite, answers: ResponseFile, metrics: Sequence[str]) -> dict[str, Any]:
    """One model's row: what it lacks counts as failures, as everywhere.

    One process scores all models, because equal operators are planned with once.
    """
    given = {response.task_id for response in answers.responses}
    missing = {task_id: NO_ROW for task_id in suite.task_ids if task_id not in given}
    records = score_run(suite, answers, missing, Settings(explanations=False))
    rates = summarise([record.verdict for record in records], suite.ability)
    return {
        "answers_sha256": digest(records),
        "answered": coverage_of(records).answered,
        "rates": [[rates[metric].numerator, rates[metric].denominator] for metric in metrics],
    }


def digest(records: Iterable[Record]) -> str:
    """Digest of the answers: their tasks and texts, in the order of the data set."""
    lines = (f"{r.task_id} {sha256_of(r.response)}\n" for r in records if r.unanswered is None)
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def find_answers(folder: Path, file: str, suite: Suite) -> ResponseFile | None:
    """The answers of a model to a suite, or None if the folder does not have them."""
    plain, packed = folder / f"{file}{SUFFIX}", folder / f"{file}{PACKED}"
    if plain.is_file():
        return read_responses(plain, suite.task_ids, suite.benchmark.task_id_of)
    if not packed.is_file():
        return None
    content = json.loads(gzip.decompress(packed.read_bytes()))
    rows = content.get("tasks") or content.get("records")
    return ResponseFile(file, tuple(_responses(rows, suite)))


def _responses(rows: Iterable[Mapping[str, Any]], suite: Suite) -> Iterator[Response]:
    for row in rows:
        identifier = row.get("id", row.get("identifier"))
        text = row.get("llm_output", row.get("response")) or ""
        yield Response(suite.benchmark.task_id_of(str(identifier)), text)


def table_text(suites: Mapping[str, Any]) -> str:
    """The file: a line a model, so that a change can be read."""
    parts = []
    for name, suite in suites.items():
        models = ",\n".join(f"    {json.dumps(m)}: {json.dumps(row)}" for m, row in suite["models"].items())
        head = ",\n".join(
            f"   {json.dumps(key)}: {json.dumps(value)}" for key, value in suite.items() if key != "models"
        )
        parts.append(f'  {json.dumps(name)}: {{\n{head},\n   "models": {{\n{models}\n   }}\n  }}')
    head, body = f'"schema": {SCHEMA},\n "protocol": "{DEFAULT_PROTOCOL.value}"', ",\n".join(parts)
    return f'{{\n {head},\n "suites": {{\n{body}\n }}\n}}\n'


if __name__ == "__main__":
    main()
