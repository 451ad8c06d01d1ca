"""``eai questions``: world-model questions, written, put to a model, and scored."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from eai.abilities.responses import Response, ResponseFile, file_name, read_responses, write_responses
from eai.abilities.verdict import Json
from eai.benchmark.registry import find_benchmark
from eai.cli.console import (
    DOMAIN_HELP,
    counted,
    data_progress,
    note,
    output,
    print_json,
    tell,
    without_inspect,
)
from eai.cli.models import pair
from eai.cli.options import AsJson
from eai.cli.progress import resumable, run_progress
from eai.cli.store import DataFolder, store
from eai.cli.table import PERCENT
from eai.data.files import write_whole
from eai.errors import InputError
from eai.prompts.template import Templates
from eai.questions.question import Form, Kind, Question, questions_content, read_questions
from eai.questions.records import QuestionRun, write_results
from eai.questions.results import (
    DEPTHS,
    Result,
    Row,
    Table,
    depth_text,
    score,
    table_json,
    tabulate,
)
from eai.questions.shortcuts import Balance, balance_of, best_chance, chances_of, guesses_of
from eai.questions.writer import Wanted, Writer
from eai.results.rate import Rate
from eai.results.table import Cell, Column, Estimate, NamedCells
from eai.results.table import Table as Shown
from eai.results.terminal import print_table
from eai.run.job import Endpoint, Pace, check_model
from eai.run.journal import sole_run
from eai.tasks.source import Source

WRITE = "write"


class _WritesByDefault(TyperGroup):
    """A group whose options without a command are those of ``write``."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """The arguments, after the command that they are for."""
        named = args and (args[0] in self.commands or args[0] in ctx.help_option_names)
        return super().parse_args(ctx, args if named or not args else [WRITE, *args])


app = typer.Typer(
    cls=_WritesByDefault,
    no_args_is_help=True,
    help="World-model questions with computed answers. Options without a command are those of write.",
)
QuestionPath = Annotated[Path, typer.Argument(help="The questions.", metavar="FILE")]
Out = Annotated[Path | None, typer.Option(help="Where records and the summary go.")]


@app.command(WRITE)
def write(
    domain: Annotated[str, typer.Option(help=DOMAIN_HELP)],
    out: Annotated[Path, typer.Option(metavar="FILE", help="The file to write, JSON lines.")],
    kind: Annotated[
        list[Kind] | None, typer.Option(metavar="KIND", help=f"{', '.join(Kind)}. All if not given.")
    ] = None,
    form: Annotated[
        list[Form] | None, typer.Option(metavar="FORM", help=f"{', '.join(Form)}. All if not given.")
    ] = None,
    n: Annotated[int, typer.Option("--n", min=1, help="How many, evenly of all kinds and forms.")] = 500,
    seed: Annotated[int, typer.Option(help="Of all that is random.")] = 0,
    rules: Annotated[
        bool, typer.Option(help="Tell the rules. Without them the same questions are a closed-book test.")
    ] = True,
    prompts: Annotated[
        Path | None, typer.Option(help="Texts of your own in place of single ones of ours.")
    ] = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write questions about the world of a benchmark. Equal arguments give equal bytes.

    Example: eai questions --domain tasks/ --n 500 --seed 0 --out questions.jsonl
    """
    with data_progress() as report:
        writer = Writer(find_benchmark(domain), Source(store(data), report), Templates(prompts))
        wanted = Wanted(tuple(kind or Kind), tuple(form or Form), n, seed, rules)
        questions = list(writer.write(wanted))
    if not questions:
        raise InputError(f"{domain}: no task of it gives a question of these kinds and forms")
    write_whole({out: questions_content(questions)})
    if not as_json:
        _print_balance(questions)
        _print_chances(questions)
    fewer = "" if len(questions) == n else f"; the tasks give no more than these of {n:,}"
    told = f"{counted(len(questions), 'question')} written to {out}{fewer}"
    chance: dict[str, Json] = {
        f"{kind.value}.{form.value}": {name: rate.percent for name, rate in chances.items()}
        for (kind, form), chances in _chances(questions).items()
    }
    value: dict[str, Json] = {"file": str(out), "questions": len(questions), "chance": chance}
    tell(told, value=value, as_json=as_json)


@app.command()
@resumable
def run(
    path: QuestionPath,
    model: Annotated[str, typer.Option(help="As for eai run; eai/oracle, eai/noisy built in.")],
    out: Annotated[Path, typer.Option(help="Where answers, the log and results go.")],
    model_arg: Annotated[
        list[str] | None, typer.Option("-M", metavar="KEY=VALUE", help="An argument of the model.")
    ] = None,
    model_base_url: Annotated[str | None, typer.Option(help="Where a local server listens.")] = None,
    limit: Annotated[int | None, typer.Option(min=1, help="The first N alone.")] = None,
    max_connections: Annotated[int | None, typer.Option(min=1, help="Requests at a time.")] = None,
    as_json: AsJson = False,
) -> None:
    """Put questions to a model and score the answers. The same command goes on where it was interrupted.

    Exit status 1 if some questions were not answered; until they are, they count as wrong.

    Example: eai questions run questions.jsonl --model eai/noisy -M rate=0.2 --out answers
    """
    try:
        from eai.run.questions import ask_questions
    except ImportError as error:
        raise without_inspect(error) from error
    check_model(model)
    file, name = read_questions(path), file_name(model)
    asked, folder = file.questions[:limit], out / name
    endpoint = Endpoint(model, dict(pair(text) for text in model_arg or ()), model_base_url)
    with sole_run(folder):
        with run_progress(f"questions {model}", quiet=as_json) as watch:
            answers = ask_questions(
                asked, endpoint, folder, Pace(max_connections=max_connections), watch=watch
            )
        given = {place[0]: answer.text for place, answer in answers.given.items()}
        responses = tuple([Response(each.id, given[each.id]) for each in asked if each.id in given])
        write_responses(folder, ResponseFile(name, responses))
        results = score(asked, given)
        write_results(folder, QuestionRun(name, file.sha256, tuple(results)))
    _print(name, results, as_json=as_json)
    for why, number in Counter(answers.failures.values()).items():
        note(f"{counted(number, 'question')} not answered: {why}")
    if answers.failures:
        raise typer.Exit(1)


@app.command("score")
def score_answers(
    path: QuestionPath,
    answers: Annotated[
        Path, typer.Argument(help='A list of {"identifier", "llm_output"}.', metavar="ANSWERS")
    ],
    out: Out = None,
    as_json: AsJson = False,
) -> None:
    """Score the answers in a file, named <model>_outputs.json or _outputs.jsonl, and print a table.

    A question without an answer counts as wrong.

    Example: eai questions score questions.jsonl answers/eai_noisy_outputs.json
    """
    file = read_questions(path)
    ids = {question.id: None for question in file.questions}
    given = read_responses(answers, ids, asked=f"questions, which have ids such as {next(iter(ids))!r}")
    results = score(file.questions, {response.task_id: response.text for response in given.responses})
    if out is not None:
        write_results(out, QuestionRun(given.model, file.sha256, tuple(results)))
    _print(given.model, results, as_json=as_json)


def _print(model: str, results: Sequence[Result], *, as_json: bool) -> None:
    table = tabulate(results)
    if as_json:
        print_json({"model": model, **table_json(table)})
        return
    answered = sum(result.text is not None for result in results)
    title = f"{model}: {answered:,} of {counted(len(results), 'question')} answered; right, in percent"
    rows = {**{k.value: row for k, row in table.by_kind.items()}, "all": table.overall}
    by_kind: list[NamedCells] = [("kind", list(rows)), *_columns(rows), *_depths(table)]
    print_table(output(), Shown.of_columns(title, by_kind))
    forms = {form.value: row for form, row in table.by_form.items()}
    print_table(output(), Shown.of_columns("By form of answer", [("form", list(forms)), *_columns(forms)]))


def _columns(rows: dict[str, Row]) -> list[NamedCells]:
    found = list(rows.values())
    unreadable = any(row.unreadable.numerator for row in found)
    not_read = [Estimate.of_rate(row.unreadable) for row in found]
    intervals = ["-" if r.interval is None else f"{r.interval[0]:.0f}-{r.interval[1]:.0f}" for r in found]
    return [
        (Column("of", number=True), [f"{row.exact.denominator:g}" for row in found]),
        (replace(PERCENT, name="right"), [Estimate.of_rate(row.exact) for row in found]),
        (Column("95 %", number=True), intervals),
        (replace(PERCENT, name="chance"), [Estimate.of_rate(row.chance) for row in found]),
        (replace(PERCENT, name="F1"), [Estimate.of_rate(row.f1) for row in found]),
        *([(replace(PERCENT, name="unread"), not_read)] if unreadable else []),
    ]


def _depths(table: Table) -> list[NamedCells]:
    """The rates by depth, below how many actions the questions are about."""
    rates = list(table.by_depth.values())
    return [
        (
            replace(PERCENT, name=f"depth\n{depth_text(depth)}"),
            [*(Estimate.of_rate(of_kind[place]) for of_kind in rates), None],
        )
        for place, depth in enumerate(DEPTHS)
    ]


def _print_balance(questions: Sequence[Question]) -> None:
    kinds = list(dict.fromkeys([question.kind for question in questions]))
    columns: list[NamedCells] = [
        (
            Column(f"{form.value}\n{heading}", number=True),
            [_cell(balance_of(questions, kind, form), field) for kind in kinds],
        )
        for form in dict.fromkeys([question.form for question in questions])
        for heading, field in (("n", "number"), ("entropy", "entropy"))
    ]
    title = "Questions, and how even their answers are (1: entirely)"
    print_table(output(), Shown.of_columns(title, [("kind", [kind.value for kind in kinds]), *columns]))


def _print_chances(questions: Sequence[Question]) -> None:
    """What guessing and shortcuts give, the best of them for each kind and form."""
    found = _chances(questions)
    kinds = list(dict.fromkeys([question.kind for question in questions]))
    columns: list[NamedCells] = [
        (
            replace(PERCENT, name=f"{form.value}\n{heading}"),
            [_best(found.get((kind, form), {}), heading) for kind in kinds],
        )
        for form in dict.fromkeys([question.form for question in questions])
        for heading in ("chance", "by")
    ]
    title = "Right without knowing the world, at best, in percent"
    print_table(output(), Shown.of_columns(title, [("kind", [kind.value for kind in kinds]), *columns]))


def _chances(questions: Sequence[Question]) -> dict[tuple[Kind, Form], dict[str, Rate]]:
    guesses = guesses_of(questions)
    alike: dict[tuple[Kind, Form], list[Question]] = {}
    for question in questions:
        alike.setdefault((question.kind, question.form), []).append(question)
    return {cell: chances_of(some, guesses) for cell, some in alike.items()}


def _best(chances: Mapping[str, Rate], heading: str) -> Cell:
    if not chances:
        return "-"
    best = best_chance(chances)
    return best if heading == "by" else Estimate.of_rate(chances[best])


def _cell(balance: Balance, field: str) -> str:
    value = getattr(balance, field)
    return "-" if value is None else f"{value:g}" if isinstance(value, int) else f"{value:.2f}"
