"""``eai export``: write prompts, training data and task files. Extensions add more formats."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from importlib import resources
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

import typer

from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.base.errors import InputError
from eai.base.files import Content, write_files_atomically
from eai.base.grouping import group_pairs
from eai.base.json_value import Json
from eai.benchmarks.names import suite_name
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark, list_benchmarks
from eai.benchmarks.suite import Suite, open_suite
from eai.cli import options
from eai.cli.console import DOMAIN_HELP, format_count, print_result, select_default_abilities
from eai.cli.options import AsJson, DataFolder, make_flag, open_data_source
from eai.cli.prompts import OfSet, is_prompt_list_file, select_entries_of_tasks, write_prompts
from eai.pddl.planning import PlannerChoice
from eai.results import training_data
from eai.results.records import read_records
from eai.results.reward import Reward, Shaping, can_earn_reward
from eai.results.runs import find_record_files
from eai.results.training_data import TrainingRow
from eai.tasks.prompts.prompt import PromptSet
from eai.tasks.source import ErrataChoice
from eai.tasks.task_files import find_task_files

app = typer.Typer(no_args_is_help=True)


_Format: TypeAlias = Literal["jsonl", "hf"]
"""Format of a written data set: a JSON Lines file, or a folder for the Hugging Face library `datasets`."""

_Out = Annotated[Path, make_flag(help="The file to write; of --format hf, the folder.", metavar="FILE")]
_OfFormat = Annotated[
    _Format, make_flag("--format", help="One file of JSON Lines, or a folder for datasets.load_dataset.")
]
_Records = Annotated[
    list[Path], typer.Argument(help="Files of records, or folders of them.", metavar="RECORDS")
]
_Domains = Annotated[
    list[str] | None,
    make_flag("--domain", help="Where the benchmark of records is that is not known by its name alone."),
]
_Shaping = Annotated[
    Shaping, make_flag(help=f"What answers are worth: by {', '.join(Shaping)}.", metavar="HOW")
]

_LIST = "Of a list or a page"
_OF_LISTS = "--prompts, --tasks, --sample, --goals"

TRAIN = "train"
"""Name of the only split if the tasks are not divided into splits."""


@app.command("prompts", no_args_is_help=True)
def export_prompts(
    domain: Annotated[list[str], make_flag(help=DOMAIN_HELP)],
    out: _Out,
    ability: Annotated[
        list[Ability] | None,
        make_flag(help=f"{options.ABILITIES}. All if not given.", parser=Ability.from_name),
    ] = None,
    prompt_set: OfSet = "official",
    form: _OfFormat = "jsonl",
    folder: Annotated[Path | None, make_flag("--prompts", panel=_LIST)] = None,
    tasks: Annotated[str, make_flag(panel=_LIST)] = "",
    sample: Annotated[int | None, make_flag(panel=_LIST, min=1)] = None,
    seed: Annotated[int, make_flag(panel=_LIST)] = 0,
    goals: Annotated[Path | None, make_flag(panel=_LIST)] = None,
    errata: options.Errata = ErrataChoice.CURRENT,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write prompts: rows for training, a list as the data set has it, or a page for people.

    FILE.json is a list of {"identifier", "llm_prompt"} for one benchmark and ability. Official prompts equal
    the data set's byte for byte. The exceptions are prompts that did not ask for what is scored: they are
    corrected (docs/errata.md), unless you give --errata none. A system message is in FILE with _system before
    its extension. With --goals, tasks without an answer in that file have no prompt.

    FILE.html is a page on which a person answers the questions of models; it sends nothing. The person saves
    a response file. eai score scores it like a model's (with --allow-missing, because other tasks were not
    asked), and eai compare compares it with a model's records on the same tasks.

    Any other FILE has a row for each task that has a reward, for TRL, verl, SkyRL and OpenRLHF. Each file
    of a folder of task files is a split.

    Example: eai export prompts --domain virtualhome --ability action_sequencing --out prompts.json

    Example: eai export prompts --domain tasks/ --ability action_sequencing --out train.jsonl

    Options:
        folder: A folder with your own prompts.
        tasks: Only these tasks: ids separated by commas.
        sample: Number of tasks, drawn at random.
        seed: Seed of --sample.
        goals: A file of a model's answers to goal interpretation. Prompts state their goals, not the tasks'.
    """
    if is_prompt_list_file(out) and form == "jsonl":
        if len(domain) != 1 or ability is None or len(ability) != 1:
            raise InputError(
                f"--out {out}: the file holds prompts of one suite; give one --domain and one --ability"
            )
        chosen = (
            partial(select_entries_of_tasks, tasks=tasks, sample=sample, seed=seed)
            if tasks or sample
            else None
        )
        with open_data_source(data, errata=errata) as source:
            library = PromptLibrary(prompt_set, folder, source)
            write_prompts(library, find_benchmark(domain[0]), ability[0], out, chosen, goals, as_json=as_json)
        return
    if folder or tasks or sample or goals:
        raise InputError(f"--out {out}: {_OF_LISTS} only work with --out FILE.json or FILE.html")

    def generate_prompt_rows() -> Iterator[TrainingRow]:
        with open_data_source(data, PlannerChoice.NONE, errata) as source:
            for split, name in [
                each for given in domain for each in _list_splits_and_their_benchmarks(given)
            ]:
                benchmark = find_benchmark(name)
                for each in ability or select_default_abilities(benchmark, PAPER_ABILITIES):
                    asked = PromptLibrary(prompt_set, None, source).open(benchmark, each)
                    for row in training_data.make_prompt_rows(
                        Reward(open_suite(name, each, source=source)), asked
                    ):
                        yield {**row, "split": split}

    _print_written_rows(
        out, _write_data_set_and_count_rows(generate_prompt_rows(), out, form), Counter(), as_json=as_json
    )


@app.command("sft", no_args_is_help=True)
def export_sft_data(
    records: _Records,
    out: _Out,
    domain: _Domains = None,
    least: Annotated[float, make_flag(min=0, max=1)] = 1.0,
    shaping: _Shaping = Shaping.SUCCESS,
    prompt_set: OfSet = "official",
    form: _OfFormat = "jsonl",
    workers: options.Workers = None,
    ray: options.OnRay = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write answers that are right when they are scored again, each with its prompt.

    Example: eai export sft runs --out sft.jsonl

    Example: eai export sft scores --domain lamps:lamps --out sft.jsonl

    Options:
        least: Minimum reward, from 0 to 1, of an answer.
    """
    left_out = Counter[str]()
    answers = _make_rows_with_rewards_of_records(
        records, domain or [], shaping, prompt_set, data, left_out, workers=workers, ray=ray
    )
    _print_written_rows(
        out,
        _write_data_set_and_count_rows(training_data.select_verified_rows(answers, least), out, form),
        left_out,
        as_json=as_json,
    )


@app.command("preference", no_args_is_help=True)
def export_preference_data(
    records: _Records,
    out: _Out,
    domain: _Domains = None,
    margin: Annotated[float, make_flag(min=0)] = 0.0,
    shaping: _Shaping = Shaping.PROGRESS,
    prompt_set: OfSet = "official",
    form: _OfFormat = "jsonl",
    workers: options.Workers = None,
    ray: options.OnRay = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write pairs of answers to one prompt: the best answer with each answer of lower value.

    Example: eai export preference runs --out preference.jsonl

    Options:
        margin: The values of a pair differ by more than this number.
    """
    left_out = Counter[str]()
    answers = _make_rows_with_rewards_of_records(
        records, domain or [], shaping, prompt_set, data, left_out, workers=workers, ray=ray
    )
    _print_written_rows(
        out,
        _write_data_set_and_count_rows(training_data.make_preference_rows(answers, margin), out, form),
        left_out,
        as_json=as_json,
    )


@app.command("process", no_args_is_help=True)
def export_plans_with_step_labels(
    records: _Records,
    out: _Out,
    domain: _Domains = None,
    effort: Annotated[int, make_flag(metavar="N", min=1)] = 1_000,
    shaping: _Shaping = Shaping.PROGRESS,
    prompt_set: OfSet = "official",
    form: _OfFormat = "jsonl",
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write plans with a label for each step: how the step changes the distance to the goals.

    The distance of a state is the number of actions in a shortest plan from it. A step of a shortest plan
    changes it by -1, and a step that fails or is skipped by 0. The change is null for steps after a failed
    step, and if the distance before or after the step is unknown. A distance is unknown if the search for a
    shortest plan reaches its limit. Distances are computed from the last state back to the first, until three
    in a row are unknown.

    Example: eai export process runs --out process.jsonl

    Options:
        effort: Limit of the search for the distance of a state: about the number of steps that it tries.
    """
    left_out, counts = Counter[str](), Counter[str]()
    label = partial(
        training_data.make_function_adding_goal_distance_and_steps, search_effort=effort, step_counts=counts
    )
    answers = _make_rows_with_rewards_of_records(
        records, domain or [], shaping, prompt_set, data, left_out, label
    )
    number = _write_data_set_and_count_rows(answers, out, form)
    executed = format_count(counts["executed"], "executed step")
    exact = f"the change is exact for {counts['exact']:,} of {executed} (--effort {effort})"
    numbers = {name: counts[name] for name in ("exact", "executed")}
    _print_written_rows(out, number, left_out, exact, as_json=as_json, **numbers)


def _make_rows_with_rewards_of_records(
    record_files: list[Path],
    domains: list[str],
    shaping: Shaping,
    prompt_set: PromptSet,
    data: Path | None,
    count_by_exclusion_reason: Counter[str],
    label: Callable[[Suite], training_data.AddColumns] | None = None,
    *,
    workers: int | None = None,
    ray: str | None = None,
) -> Iterator[TrainingRow]:
    """Yield the scored answers in files, each with its reward, grouped by benchmark and ability."""
    named = {benchmark.name: benchmark for benchmark in map(find_benchmark, domains)}
    records = (record for file in find_record_files(record_files) for record in read_records(file))
    by_suite = group_pairs(((record.domain, record.ability), record) for record in records)
    with (
        open_data_source(data, PlannerChoice.NONE) as source,
        options.open_scoring_workers(workers, ray) as scoring,
    ):
        for (domain, ability), of_suite in by_suite.items():
            if not can_earn_reward(ability):
                count_by_exclusion_reason[training_data.NOT_PAID] += len(of_suite)
                continue
            if domain not in named and domain not in list_benchmarks():
                raise InputError(
                    f"{domain}: no installed benchmark has this name; give the same --domain as for the run "
                    "that made the records, such as tasks/ or module:object"
                )
            benchmark = named.get(domain) or find_benchmark(domain)
            asked = PromptLibrary(prompt_set, None, source).open(benchmark, ability)
            paid = Reward(open_suite(benchmark, ability, source=source), shaping)
            columns = {} if label is None else {"add_columns": label(paid.suite)}
            yield from training_data.make_reward_rows(
                of_suite, paid, asked, count_by_exclusion_reason, scoring=scoring, **columns
            )


def _list_splits_and_their_benchmarks(domain: str) -> list[tuple[str, str]]:
    """Return the name and the benchmark of each split.

    In a folder of task files, each file is a split. Any other benchmark is a single split.
    """
    folder = Path(domain)
    if not folder.is_dir():
        return [(TRAIN, domain)]
    return [(file.name.partition(".")[0].replace("-", "_"), str(file)) for file in find_task_files(folder)]


def _write_data_set_and_count_rows(rows: Iterable[TrainingRow], out: Path, file_format: _Format) -> int:
    """Write a data set, and return its number of rows. Its files appear only when all are complete."""
    made = list(rows)
    if file_format == "jsonl":
        write_files_atomically({out: _format_json_lines(made)})
        return len(made)
    by_split = group_pairs((row.get("split", TRAIN), row) for row in made) or {TRAIN: []}
    contents: dict[Path, Content] = {
        out / f"{split}.jsonl": _format_json_lines(some) for split, some in by_split.items()
    }
    files = "".join(f"  - split: {split}\n    path: {split}.jsonl\n" for split in by_split)
    contents[out / "README.md"] = _read_template("card.txt").format(files=files)
    asked = dict.fromkeys((row["data_source"], row["split"]) for row in made if "data_source" in row)
    if asked:
        contents[out / "eval.yaml"] = _format_hugging_face_eval_yaml(out, asked)
    write_files_atomically(contents)
    return len(made)


def _format_json_lines(rows: Iterable[TrainingRow]) -> Iterator[str]:
    return (f"{json.dumps(row)}\n" for row in rows)


def _format_hugging_face_eval_yaml(out: Path, suites_and_splits: Iterable[tuple[str, str]]) -> str:
    """Return the text of eval.yaml, which registers a data set as a benchmark on the Hugging Face Hub.

    The file lists each suite with its split. Splits for training are left out.
    """
    held_out = [each for each in suites_and_splits if each[1] != TRAIN] or list(suites_and_splits)
    tasks = ""
    for source, split in held_out:
        domain, _, ability = source.rpartition("/")
        suite = suite_name(domain, Ability(ability))
        tasks += f"  - id: {suite}\n    config: default\n    split: {split}\n"
    return _read_template("eval.txt").format(name=json.dumps(out.resolve().name), tasks=tasks)


def _read_template(name: str) -> str:
    return (resources.files("eai.cli") / "templates" / name).read_text(encoding="utf-8")


def _print_written_rows(
    out: Path,
    row_count: int,
    count_by_exclusion_reason: Counter[str],
    *more_lines: str,
    as_json: bool,
    **json_counts: int,
) -> None:
    lines = [
        f"left out: {format_count(times, 'record')} {why}" for why, times in count_by_exclusion_reason.items()
    ]
    made: Json = {
        "path": str(out),
        "rows": row_count,
        "left_out": {**count_by_exclusion_reason},
        **json_counts,
    }
    print_result(
        f"{format_count(row_count, 'row')} written to {out}", *more_lines, *lines, value=made, as_json=as_json
    )
