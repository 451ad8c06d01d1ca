"""Write the scores of the public answers under both protocols: `python tools/published_scores.py [FOLDER]`.

FOLDER holds the public answers in `<domain>/<ability>/<model>_outputs.json`, or packed as
`<model>_outputs.json.gz`. By default this is `../shared/answers`. docs/study.md says where to get them.
Files of other models are ignored.

    python tools/published_scores.py                    all suites and protocols, in about ten minutes
    python tools/published_scores.py --only behavior    these suites; the others stay as they are
    python tools/published_scores.py --protocol strict  one protocol
    python tools/published_scores.py --check            writes nothing; exit status 1 if a number differs
    python tools/published_scores.py --null-models      the null models instead

Every run also writes the tables of bench/README.md that show these scores, by way of bench/results.

The numbers depend on the rules, the data and the answers, except for the planner of transition modeling,
which has a limit of CPU seconds a task.
"""

from __future__ import annotations

import argparse
import gzip
import hashlib
import json
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # bench

from bench.record import save_result
from bench.result import FOLDER, Figure, read_result
from eai.abilities.protocol import DEFAULT_PROTOCOL, PAPER_ABILITIES, Ability, Protocol
from eai.agents.command import DONE
from eai.agents.play import EpisodeFactory
from eai.agents.setting import ACTING, STANDARD
from eai.benchmarks.registry import PAPER_BENCHMARKS
from eai.benchmarks.suite import Suite, open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.batch import NO_ROW, score_run
from eai.results.codec import hash_text
from eai.results.learnability import OPEN_NULL_MODEL_ANSWERS
from eai.results.options import ScoringOptions
from eai.results.paper_tables import (
    NULL_AGENTS,
    NULL_MODELS,
    SCHEMA,
    PaperTable,
    format_published_scores_file_name,
    format_trivial_baselines_file_name,
    map_files_to_paper_models,
    read_paper_table,
    read_published_scores,
    read_trivial_baseline_scores,
)
from eai.results.record import Record
from eai.results.responses import SUFFIX, Response, ResponseFile, read_responses
from eai.results.summary import compute_metric_rates
from eai.results.totals import RunTotals
from eai.tasks.source import Source

ROOT = Path(__file__).resolve().parents[1]
PAPER = ROOT / "src" / "eai" / "results" / "paper"
ANSWERS = ROOT.parent / "shared" / "answers"
PACKED = f"{SUFFIX}.gz"

NOTES: Mapping[str, Sequence[str]] = {
    "virtualhome/action_sequencing": (
        "The published VirtualHome plans name objects without ids: of two objects of one class that matter "
        "to a task they name one only, plans with ids both. They give the figures of "
        "the paper's text, not those of its tables.",
    )
}
"""Notes for readers on the published answers to a suite."""


_S, _R = Protocol.STRICT, Protocol("eai-1.0.5")
_GOALS, _SUBGOALS, _PLANS, _OPERATORS = PAPER_ABILITIES
_F1, _SUCCESS, _PLANNER = "overall.f1", "task_success", "overall.planner_success"

PAGE_TABLES: Sequence[Sequence[tuple[str, Ability, str, Protocol]]] = (
    [
        ("virtualhome", _PLANS, metric, protocol)
        for metric in (_SUCCESS, "execution_success")
        for protocol in (_R, _S)
    ],
    [
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
    [
        ("behavior", ability, metric, protocol)
        for ability, metric in ((_PLANS, _SUCCESS), (_SUBGOALS, _SUCCESS), (_GOALS, _F1))
        for protocol in (_R, _S)
    ],
    [
        (domain, _OPERATORS, metric, _S)
        for domain in PAPER_BENCHMARKS
        for metric in (_PLANNER, "overall.plan_works")
    ],
    [(domain, _OPERATORS, metric, _S) for domain in PAPER_BENCHMARKS for metric in (_F1, "literals.f1")],
)
"""Columns after the model's name of each table in bench/results/published_scores.json, in order."""

NAMED = {"virtualhome": "VirtualHome", "behavior": "BEHAVIOR"}
AGREEMENT = (
    "goal_interpretation",
    "subgoal_decomposition_trajectory",
    "action_sequencing_trajectory",
    "goal_satisfaction",
    "transition_modeling_virtualhome_logic",
    "transition_modeling_behavior_logic",
    "transition_modeling_planner",
)
"""The paper's tables of all models that public answers are compared with."""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, nargs="?", default=ANSWERS)
    parser.add_argument("--only", default="", help="a part of DOMAIN/ABILITY")
    parser.add_argument(
        "--protocol", choices=[each.value for each in Protocol.list_names()], help="of both, one"
    )
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    parser.add_argument("--null-models", action="store_true", help="score these instead; needs no answers")
    arguments = parser.parse_args()
    made: dict[str, tuple[Protocol, Callable[[str], dict[str, Any]], Iterable[Ability]]] = {}
    for protocol in Protocol.list_names():
        if arguments.protocol not in (None, protocol.value):
            continue
        if arguments.null_models:
            made[format_trivial_baselines_file_name(protocol.value)] = (
                protocol,
                partial(score_null_models, protocol=protocol),
                (*PAPER_ABILITIES, *([ACTING] if protocol is DEFAULT_PROTOCOL else [])),
            )
        else:
            scored = partial(score_suite, protocol=protocol, folder=arguments.folder)
            made[format_published_scores_file_name(protocol.value)] = protocol, scored, PAPER_ABILITIES
    same = [
        make(PAPER / table, protocol, suite_of, abilities, arguments.only, write=not arguments.check)
        for table, (protocol, suite_of, abilities) in made.items()
    ]
    if arguments.protocol is None:
        same += [
            write_tables(name, tables, write=not arguments.check)
            for name, tables in make_page_tables().items()
        ]
    if arguments.check and not all(same):
        sys.exit(1)


def make(
    path: Path,
    protocol: Protocol,
    suite_of: Callable[[str], dict[str, Any]],
    abilities: Iterable[Ability],
    only: str,
    *,
    write: bool,
) -> bool:
    """Make a table, and return whether it equals the file's."""
    known: dict[str, Any] = json.loads(path.read_text())["suites"] if path.exists() else {}
    suites = dict(known)
    for name in [f"{domain}/{ability.value}" for domain in PAPER_BENCHMARKS for ability in abilities]:
        if only in name:
            suites[name] = suite_of(name)
            models = suites[name]["models"]
            same = "equal" if suites[name] == known.get(name) else "DIFFERS"
            print(f"{name:36} {len(models):3} models  {protocol.value:9}  {same}", flush=True)
    if write:
        path.write_text(format_table(suites, protocol), encoding="utf-8")
    return suites == known


def score_suite(
    name: str,
    folder: Path,
    *,
    protocol: Protocol,
    only: Iterable[str] | None = None,
    planner: PlannerChoice = PlannerChoice.FULL,
) -> dict[str, Any]:
    """Return the part of the table on one suite, with all models whose answers are in the folder.

    Args:
        name: Suite, as `DOMAIN/ABILITY`.
        folder: Folder of the answers.
        protocol: Rules that judge the answers.
        only: Names of the files to score, without ending; None for all.
        planner: Planner that judges operators.
    """
    domain, ability = name.split("/")
    suite = open_suite(domain, Ability(ability), protocol, source=Source(planner=planner))
    metrics = list(compute_metric_rates([], suite.ability))
    models: dict[str, Any] = {}
    for file, model in sorted(map_files_to_paper_models().items(), key=lambda item: item[1]):
        answers = find_answers(folder / domain / ability, file, suite)
        if answers is None or (only is not None and file not in only):
            continue
        if model in models:
            sys.exit(f"{folder / domain / ability}: two files of {model}")
        models[model] = score_answers(suite, answers, metrics)
    if not models:
        sys.exit(f"{folder / domain / ability}: no answers of the paper's models")
    return {
        "data_sha256": suite.data_sha256,
        "tasks": len(suite.task_ids),
        "metrics": metrics,
        "notes": list(NOTES.get(name, ())),
        "models": models,
    }


def score_null_models(
    name: str,
    *,
    protocol: Protocol,
    only: Iterable[str] | None = None,
    planner: PlannerChoice = PlannerChoice.FULL,
) -> dict[str, Any]:
    """Return the part of the table on one suite for the null models, or for some of them."""
    domain, ability = name.split("/")
    suite = open_suite(domain, Ability(ability), protocol, source=Source(planner=planner))
    metrics = list(compute_metric_rates([], suite.ability))
    models: dict[str, Any] = {}
    for model in only or (NULL_AGENTS if suite.ability == ACTING else NULL_MODELS):
        if suite.ability == ACTING:
            responses = tuple(play_with_null_agent(suite, model))
        else:
            book = OPEN_NULL_MODEL_ANSWERS[model](suite.benchmark, suite.ability, suite.source)
            responses = tuple([Response(task_id, book[task_id].text) for task_id in suite.task_ids])
        models[model] = score_answers(suite, ResponseFile(model, responses), metrics)
    return {
        "data_sha256": suite.data_sha256,
        "tasks": len(suite.task_ids),
        "metrics": metrics,
        "models": models,
    }


def play_with_null_agent(suite: Suite, model: str) -> Iterator[Response]:
    """Yield an episode of each task in the standard setting, as one command a line."""
    episodes = EpisodeFactory(suite.benchmark, STANDARD)
    for task_id, task in suite.tasks.items():
        is_playable = task.unplannable_reason is None
        commands = (
            episodes.play_episode_and_return_commands(model.removeprefix("eai/"), task, 0, 1)
            if is_playable
            else [DONE]
        )
        yield Response(task_id, "\n".join(commands))


def make_page_tables() -> Mapping[str, Sequence[Sequence[Sequence[Figure]]]]:
    """Return the rows of the page's tables by the name of the result that holds them."""
    return {
        "published_scores": [score_rows(columns) for columns in PAGE_TABLES],
        "paper_tables": [list(make_agreement_rows())],
    }


def write_tables(name: str, tables: Sequence[Sequence[Sequence[Figure]]], *, write: bool) -> bool:
    """Write the rows of a result's tables and the page, and return whether the rows are unchanged."""
    result = read_result(FOLDER / f"{name}.json")
    new = tuple(
        replace(table, rows=tuple(map(tuple, rows)))
        for table, rows in zip(result.tables, tables, strict=True)
    )
    if write:
        save_result(name, replace(result, tables=new))
    return new == result.tables


def score_rows(columns: Sequence[tuple[str, Ability, str, Protocol]]) -> list[list[Figure]]:
    """Return the rates of all models, then of the null models."""
    rows = [
        [file, *make_cells(model, columns, read_published_scores)]
        for file, model in sorted(answer_files().items())
    ]
    return rows + [
        [f"`{model}`", *make_cells(model, columns, read_trivial_baseline_scores)] for model in NULL_MODELS
    ]


def make_agreement_rows() -> Iterator[list[Figure]]:
    """Yield how many cells of each of the paper's tables are within some distances of ours."""
    for name in AGREEMENT:
        table = read_paper_table(name)
        for domain in PAPER_BENCHMARKS:
            gaps = list(list_differences(table, domain))
            if gaps:
                near = [sum(gap <= limit for gap in gaps) for limit in (0.056, 1.05, 2.05)]
                title = name.replace("_", " ").replace(f" {domain}", "")
                yield [title, NAMED[domain], len(gaps), *near, round(max(gaps), 1)]


def list_differences(table: PaperTable, domain: str) -> Iterator[float]:
    """Yield the points by which cells of a table differ from the public answers' rates."""
    suites = read_published_scores("eai-1.0.5").suites
    for column in [each for each in table.columns if each.domain == domain]:
        suite = suites[f"{domain}/{column.ability}"]
        for model in table.rows:
            printed = table.find_printed_number(model, column)
            ours = suite.find_rates(model)[column.metric].percent
            if printed is not None and ours is not None:
                yield abs(ours - printed)


def answer_files() -> Mapping[str, str]:
    """Return the paper's name of each model by the name of its public file, each model once."""
    return {
        file: model
        for model, file in {model: file for file, model in map_files_to_paper_models().items()}.items()
    }


def make_cells(
    model: str, columns: Sequence[tuple[str, Ability, str, Protocol]], scores: Callable[[str], Any]
) -> Iterator[Figure]:
    """Yield the rates of a model in percent, with one decimal, or "-" without a rate."""
    for domain, ability, metric, protocol in columns:
        percent = scores(protocol.value).suites[f"{domain}/{ability.value}"].find_rates(model)[metric].percent
        yield "-" if percent is None else round(percent, 1)


def score_answers(suite: Suite, answers: ResponseFile, metrics: Sequence[str]) -> dict[str, Any]:
    """Return the row of a model. Missing answers count as failures.

    One process scores all models, because equal operators are planned with once.
    """
    given = {response.task_id for response in answers.responses}
    missing = {task_id: NO_ROW for task_id in suite.task_ids if task_id not in given}
    records = score_run(suite, answers, missing, ScoringOptions(explanations=False))
    totals = RunTotals.from_records(records)
    return {
        "answers_sha256": compute_digest(records),
        "answered": totals.coverage.answered,
        "rates": [[totals.rates[metric].numerator, totals.rates[metric].denominator] for metric in metrics],
    }


def compute_digest(records: Iterable[Record]) -> str:
    """Return a digest of the answers: their tasks and texts, in the order of the data set."""
    lines = (f"{r.task_id} {hash_text(r.response)}\n" for r in records if r.unanswered is None)
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def find_answers(folder: Path, file: str, suite: Suite) -> ResponseFile | None:
    """Return the answers of a model to a suite, or None if the folder does not have them."""
    plain, packed = folder / f"{file}{SUFFIX}", folder / f"{file}{PACKED}"
    if plain.is_file():
        return read_responses(plain, suite.task_ids, suite.benchmark.data.task_id_of)
    if not packed.is_file():
        return None
    with tempfile.TemporaryDirectory(prefix="eai-answers-") as unpacked:
        copy = Path(unpacked) / plain.name
        copy.write_bytes(gzip.decompress(packed.read_bytes()))
        return read_responses(copy, suite.task_ids, suite.benchmark.data.task_id_of)


def format_table(suites: Mapping[str, Any], protocol: Protocol) -> str:
    """Return the text of the file, with one line for each model, so that a change is easy to read."""
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
