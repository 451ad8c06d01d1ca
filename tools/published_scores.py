"""Writes the table of the published answers under `strict`: `python tools/published_scores.py [FOLDER]`.

FOLDER holds the answers in `<domain>/<ability>/`, as `<model>_outputs.json` or, by default, as the verdicts
beside the repository hold them (`<model>.json.gz`). Every file whose name is that of a model's published
answers is scored, others are left alone, so that further models join the table by joining the folder.

    python tools/published_scores.py                    all suites, some minutes
    python tools/published_scores.py --only behavior    these alone; the others stay as they are
    python tools/published_scores.py --check            writes nothing; exit status 1 if a number differs
    python tools/published_scores.py --null-models      what the null models earn, under both protocols

The numbers depend on the rules, the data and the answers alone, but for the planner of transition modeling,
which is given so many CPU seconds a task.
"""

from __future__ import annotations

import argparse
import gzip
import hashlib
import json
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from eai.abilities.codec import sha256_of
from eai.abilities.protocol import DEFAULT_PROTOCOL, FOUR, Ability, Protocol
from eai.abilities.record import Record
from eai.abilities.responses import SUFFIX, Response, ResponseFile, read_responses
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.copied_answers import open_copy_book, open_empty_book, open_lookup_book
from eai.benchmark.random_answers import open_random_answers
from eai.benchmark.registry import FIRST
from eai.benchmark.suite import Suite, open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.paper_tables import NULL_MODELS, SCHEMA, TABLE, null_scores, null_table, paper_models
from eai.results.summary import summarise
from eai.results.totals import Totals
from eai.run.job import PROVIDER
from eai.scoring.batch import NO_ROW, score_run
from eai.scoring.options import ScoringOptions
from eai.tasks.source import Source

ROOT = Path(__file__).resolve().parents[1]
PAPER = ROOT / "src" / "eai" / "results" / "paper"
ANSWERS = ROOT.parent / "shared" / "oracle"
PACKED = ".json.gz"
RANDOM_SEED = "0 1 1"
"""Seed, epoch and attempt, as the built-in model has them where nobody says otherwise."""

NOTES: Mapping[str, Sequence[str]] = {
    "virtualhome/action_sequencing": (
        "The published VirtualHome plans name objects without ids: of two objects of one class that matter "
        "to a task they name one only, plans with ids both. The paper's tables were made from other plans.",
    ),
}
"""What a reader must know of the published answers to a suite."""


_S, _R = Protocol.STRICT, Protocol("eai-1.0.5")
_GOALS, _SUBGOALS, _PLANS, _OPERATORS = FOUR
_F1, _SUCCESS, _PLANNER = "overall.f1", "task_success", "overall.planner_success"

FLOORS: Mapping[tuple[str, str], Sequence[tuple[str, Ability, str, Protocol]]] = {
    ("bench/README.md", "| model | task success: "): [
        ("virtualhome", _PLANS, metric, protocol)
        for metric in (_SUCCESS, "execution_success")
        for protocol in (_R, _S)
    ],
    ("bench/README.md", "| model | VirtualHome goals, F1 "): [
        (domain, ability, metric, protocol)
        for domain, ability, metric in (
            ("virtualhome", _GOALS, _F1),
            ("virtualhome", _SUBGOALS, _SUCCESS),
            ("virtualhome", _OPERATORS, _F1),
            ("virtualhome", _OPERATORS, _PLANNER),
            ("behavior", _OPERATORS, _F1),
        )
        for protocol in (_R, _S)
    ],
    ("bench/README.md", "| model | VirtualHome: planner success "): [
        (domain, _OPERATORS, metric, _S) for domain in FIRST for metric in (_PLANNER, "overall.plan_works")
    ],
    ("bench/README.md", "| model | VirtualHome: clauses "): [
        (domain, _OPERATORS, metric, _S) for domain in FIRST for metric in (_F1, "literals.f1")
    ],
    ("bench/README.md", "| model | sequencing: "): [
        ("behavior", ability, metric, protocol)
        for ability, metric in ((_PLANS, _SUCCESS), (_SUBGOALS, _SUCCESS), (_GOALS, _F1))
        for protocol in (_R, _S)
    ],
}
"""Tables of documentation, each by its page and how it begins: what the columns beside the names show."""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, nargs="?", default=ANSWERS)
    parser.add_argument("--only", default="", help="a part of DOMAIN/ABILITY")
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    parser.add_argument("--null-models", action="store_true", help="score these instead; needs no answers")
    arguments = parser.parse_args()
    if arguments.null_models:
        made = {
            null_table(each.value): (each, partial(null_suite, protocol=each)) for each in Protocol.known()
        }
    else:
        made = {TABLE: (DEFAULT_PROTOCOL, partial(scored_suite, folder=arguments.folder))}
    same = [
        make(PAPER / table, protocol, suite_of, arguments.only, write=not arguments.check)
        for table, (protocol, suite_of) in made.items()
    ]
    if arguments.null_models:
        same += [write_floor(ROOT / page, header, write=not arguments.check) for page, header in FLOORS]
    if arguments.check and not all(same):
        sys.exit(1)


def make(
    path: Path, protocol: Protocol, suite_of: Callable[[str], dict[str, Any]], only: str, *, write: bool
) -> bool:
    """Make a table again, and say whether it is as it was."""
    known: dict[str, Any] = json.loads(path.read_text())["suites"] if path.exists() else {}
    suites = dict(known)
    for name in [f"{domain}/{ability.value}" for domain in FIRST for ability in FOUR]:
        if only in name:
            suites[name] = suite_of(name)
            models = suites[name]["models"]
            same = "equal" if suites[name] == known.get(name) else "DIFFERS"
            print(f"{name:36} {len(models):3} models  {protocol.value:9}  {same}", flush=True)
    if write:
        path.write_text(table_text(suites, protocol), encoding="utf-8")
    return suites == known


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


def null_suite(
    name: str,
    *,
    protocol: Protocol,
    only: Iterable[str] = NULL_MODELS,
    planner: PlannerChoice = PlannerChoice.FULL,
) -> dict[str, Any]:
    """The part of the table on one suite, of the null models, or only of some."""
    domain, ability = name.split("/")
    suite = open_suite(domain, Ability(ability), protocol, source=Source(planner=planner))
    metrics = list(summarise([], suite.ability))
    models: dict[str, Any] = {}
    answers = null_answers(suite.benchmark, suite.ability, suite.source)
    for model, answer in ((model, answers[model]) for model in only):
        responses = tuple([Response(task_id, answer(task_id)) for task_id in suite.task_ids])
        models[model] = scored(suite, ResponseFile(model, responses), metrics)
    return {
        "data_sha256": suite.data_sha256,
        "tasks": len(suite.task_ids),
        "metrics": metrics,
        "models": models,
    }


def null_answers(
    benchmark: Benchmark, ability: Ability, source: Source
) -> Mapping[str, Callable[[str], str]]:
    """What each null model answers to a task, as `eai run` asks it."""
    books = {"copy": open_copy_book, "empty": open_empty_book, "lookup": open_lookup_book}
    found = {name: open_book(benchmark, ability, source) for name, open_book in books.items()}
    draw = open_random_answers(benchmark, ability, source)
    return {
        **{
            f"{PROVIDER}/{name}": lambda task_id, book=book: book[task_id].text
            for name, book in found.items()
        },
        f"{PROVIDER}/random": lambda task_id: draw(task_id, RANDOM_SEED, ()).text,
    }


def write_floor(page: Path, header: str, *, write: bool) -> bool:
    """Write the null models' rows below a table of a page, and say whether they are as they were."""
    lines = page.read_text(encoding="utf-8").splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith(header))
    end = next(i for i, line in enumerate([*lines, ""]) if i > start and not line.startswith("|"))
    names = [f"| `{model}` | " for model in NULL_MODELS]
    kept = [line for line in lines[start:end] if not line.startswith(tuple(names))]
    columns = FLOORS[str(page.relative_to(ROOT)), header]
    rows = [
        name + " | ".join(floor_cells(model, columns)) + " |"
        for name, model in zip(names, NULL_MODELS, strict=True)
    ]
    new = [*lines[:start], *kept, *rows, *lines[end:]]
    if write:
        page.write_text("\n".join(new) + "\n", encoding="utf-8")
    return new == lines


def floor_cells(model: str, columns: Sequence[tuple[str, Ability, str, Protocol]]) -> Iterator[str]:
    """What a null model comes to, in percent, with one decimal."""
    for domain, ability, metric, protocol in columns:
        percent = null_scores(protocol.value).suites[f"{domain}/{ability.value}"].rates(model)[metric].percent
        yield "-" if percent is None else f"{percent:.1f}"


def scored(suite: Suite, answers: ResponseFile, metrics: Sequence[str]) -> dict[str, Any]:
    """One model's row: what it lacks counts as failures, as everywhere.

    One process scores all models, because equal operators are planned with once.
    """
    given = {response.task_id for response in answers.responses}
    missing = {task_id: NO_ROW for task_id in suite.task_ids if task_id not in given}
    records = score_run(suite, answers, missing, ScoringOptions(explanations=False))
    totals = Totals.of(records)
    return {
        "answers_sha256": digest(records),
        "answered": totals.coverage.answered,
        "rates": [[totals.rates[metric].numerator, totals.rates[metric].denominator] for metric in metrics],
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


def table_text(suites: Mapping[str, Any], protocol: Protocol) -> str:
    """The file: a line a model, so that a change can be read."""
    parts = []
    for name, suite in suites.items():
        models = ",\n".join(f"    {json.dumps(m)}: {json.dumps(row)}" for m, row in suite["models"].items())
        head = ",\n".join(
            f"   {json.dumps(key)}: {json.dumps(value)}" for key, value in suite.items() if key != "models"
        )
        parts.append(f'  {json.dumps(name)}: {{\n{head},\n   "models": {{\n{models}\n   }}\n  }}')
    head, body = f'"schema": {SCHEMA},\n "protocol": "{protocol.value}"', ",\n".join(parts)
    return f'{{\n {head},\n "suites": {{\n{body}\n }}\n}}\n'


if __name__ == "__main__":
    main()
