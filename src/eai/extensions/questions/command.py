"""``eai export questions``: write world-model questions to a file that `eai run` and `eai score` read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, TypeAlias

from eai.base.errors import InputError
from eai.base.files import write_files_atomically
from eai.base.grouping import group_pairs
from eai.base.json_value import Json
from eai.benchmarks.registry import find_benchmark
from eai.cli.console import format_count, get_output_console, print_result
from eai.cli.options import (
    AsJson,
    DataFolder,
    OfDomain,
    OnRay,
    Seed,
    Workers,
    make_flag,
    open_data_source,
    open_scoring_workers,
)
from eai.cli.progress import show_scoring_progress
from eai.cli.table import PERCENT
from eai.extensions.questions.question import Question, QuestionForm, QuestionKind, questions_to_bytes
from eai.extensions.questions.shortcuts import (
    compute_answer_entropy,
    compute_guess_probabilities,
    compute_success_rates_of_shortcuts,
    find_best_shortcut,
)
from eai.extensions.questions.writer import QuestionGenerator
from eai.results.rate import Rate
from eai.results.table import Cell, Column, Estimate, NamedCells
from eai.results.table import Table as Shown
from eai.results.terminal import print_table
from eai.tasks.prompts.template import PromptTemplates


def questions(
    domain: OfDomain,
    out: Annotated[Path, make_flag(metavar="FILE")],
    kind: Annotated[
        list[QuestionKind] | None,
        make_flag(help=f"{', '.join(QuestionKind)}. All if not given.", metavar="KIND"),
    ] = None,
    form: Annotated[
        list[QuestionForm] | None,
        make_flag(help=f"{', '.join(QuestionForm)}. All if not given.", metavar="FORM"),
    ] = None,
    n: Annotated[int, make_flag(min=1)] = 500,
    seed: Seed = 0,
    rules: bool = True,
    prompts: Path | None = None,
    workers: Workers = None,
    ray: OnRay = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write questions on single steps and plans in the world of a benchmark, with their right answers.

    A line of FILE has a prompt, its kind and form, and the right answer, found by executing actions. eai run
    and eai score take FILE as --domain. Equal arguments give equal bytes.

    Two tables show the questions by kind and form: their number, and the rate that guessing or the best
    shortcut reaches without knowledge of the world.

    Example: eai export questions --domain tasks/ --n 500 --seed 0 --out questions.jsonl

    Options:
        out: The file to write, JSON lines.
        n: Number of questions, spread evenly over kinds and forms.
        rules: Show the rules of actions. Without them, the same questions are a closed-book test.
        prompts: Folder of your own templates; each replaces the packaged template of its name.
    """
    kinds, forms = kind or tuple(QuestionKind), form or tuple(QuestionForm)
    with open_data_source(data) as source, open_scoring_workers(workers, ray) as pool:
        writer = QuestionGenerator(find_benchmark(domain), source, PromptTemplates(prompts))
        with show_scoring_progress(f"writing questions on {domain}", n, quiet=as_json) as report:
            written_questions = list(
                writer.write_questions(kinds, forms, n, seed, rules=rules, pool=pool, report=report)
            )
    if not written_questions:
        raise InputError(f"{domain}: its tasks yield no question of these kinds and forms; choose others")
    write_files_atomically({out: questions_to_bytes(written_questions)})
    chances = _compute_shortcut_rates_by_kind_and_form(written_questions)
    if not as_json:
        _print_answer_balance(written_questions)
        _print_best_rates_without_world_knowledge(written_questions, chances)
    fewer = "" if len(written_questions) == n else f"; the tasks yield no more, {n:,} were requested"
    number = format_count(len(written_questions), "question")
    line = f"{number} written to {out}, each with its right answer{fewer}"
    then = f"next: eai run --model eai/oracle --ability world_model --domain {out}"
    chance: dict[str, Json] = {
        f"{kind.value}.{form.value}": {name: rate.percent for name, rate in rates.items()}
        for (kind, form), rates in chances.items()
    }
    value: dict[str, Json] = {"file": str(out), "questions": len(written_questions), "chance": chance}
    print_result(line, then, value=value, as_json=as_json)


_QuestionKindAndForm: TypeAlias = tuple[QuestionKind, QuestionForm]


def _print_table_by_question_kind_and_form(
    title: str,
    questions: Sequence[Question],
    columns: Mapping[Column, Callable[[_QuestionKindAndForm], Cell]],
) -> None:
    """Print a table with a row for each kind of question, and the given columns for each form of answer."""
    kinds = list(dict.fromkeys([question.kind for question in questions]))
    cells: list[NamedCells] = [
        (replace(column, name=f"{form.value}\n{column.name}"), [cell((kind, form)) for kind in kinds])
        for form in dict.fromkeys([question.form for question in questions])
        for column, cell in columns.items()
    ]
    print_table(
        get_output_console(), Shown.from_columns(title, [("kind", [kind.value for kind in kinds]), *cells])
    )


def _print_answer_balance(questions: Sequence[Question]) -> None:
    numbers = Counter((question.kind, question.form) for question in questions)

    def format_gold_answer_entropy(kind_and_form: _QuestionKindAndForm) -> str:
        share = compute_answer_entropy(questions, *kind_and_form)
        return "-" if share is None else f"{share:.2f}"

    columns = {
        Column("n", is_number=True): lambda group: str(numbers[group]),
        Column("entropy", is_number=True): format_gold_answer_entropy,
    }
    _print_table_by_question_kind_and_form(
        "Number of questions, and entropy of their answers (1: evenly spread)", questions, columns
    )


def _print_best_rates_without_world_knowledge(
    questions: Sequence[Question], shortcut_rates: Mapping[_QuestionKindAndForm, Mapping[str, Rate]]
) -> None:
    """Print, for each kind and form of question, the best rate of rules that need no knowledge of the world.

    These rules are random guessing and the shortcuts, such as to take the longest choice.
    """
    best = {group: find_best_shortcut(rates) for group, rates in shortcut_rates.items()}
    columns = {
        replace(PERCENT, name="chance"): lambda group: (
            Estimate.from_rate(shortcut_rates[group][best[group]]) if group in best else "-"
        ),
        replace(PERCENT, name="by"): lambda group: best.get(group, "-"),
    }
    _print_table_by_question_kind_and_form(
        "Best rate without knowledge of the world, in percent", questions, columns
    )


def _compute_shortcut_rates_by_kind_and_form(
    questions: Sequence[Question],
) -> dict[_QuestionKindAndForm, dict[str, Rate]]:
    guesses = compute_guess_probabilities(questions)
    groups = group_pairs(((question.kind, question.form), question) for question in questions)
    return {
        kind_and_form: compute_success_rates_of_shortcuts(group, guesses)
        for kind_and_form, group in groups.items()
    }
