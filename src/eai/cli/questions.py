"""``eai export questions``: world-model questions, written to a file that `eai run` and `eai score` take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

from eai.abilities.verdict import Json
from eai.benchmark.registry import find_benchmark
from eai.cli.console import counted, output, tell
from eai.cli.options import AsJson, DataFolder, OfDomain, Seed, flag, opened_source
from eai.cli.table import PERCENT
from eai.data.files import write_whole
from eai.data.grouping import grouped
from eai.errors import InputError
from eai.prompts.template import Templates
from eai.questions.question import Form, Kind, Question, questions_content
from eai.questions.shortcuts import best_chance, chances_of, entropy_of, guesses_of
from eai.questions.writer import Writer
from eai.results.rate import Rate
from eai.results.table import Cell, Column, Estimate, NamedCells
from eai.results.table import Table as Shown
from eai.results.terminal import print_table


def questions(
    domain: OfDomain,
    out: Annotated[Path, flag("The file to write, JSON lines.", metavar="FILE")],
    kind: Annotated[list[Kind] | None, flag(f"{', '.join(Kind)}. All if not given.", metavar="KIND")] = None,
    form: Annotated[list[Form] | None, flag(f"{', '.join(Form)}. All if not given.", metavar="FORM")] = None,
    n: Annotated[int, flag("How many, evenly of all kinds and forms.", "--n", min=1)] = 500,
    seed: Seed = 0,
    rules: Annotated[
        bool, flag("Tell the rules. Without them the same questions are a closed-book test.")
    ] = True,
    prompts: Annotated[Path | None, flag("Texts of your own in place of single ones of ours.")] = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write questions about the world of a benchmark. Equal arguments give equal bytes.

    Example: eai export questions --domain tasks/ --n 500 --seed 0 --out questions.jsonl
    """
    with opened_source(data) as source:
        writer = Writer(find_benchmark(domain), source, Templates(prompts))
        found = list(writer.write(kind or tuple(Kind), form or tuple(Form), n, seed, rules=rules))
    if not found:
        raise InputError(f"{domain}: no task of it gives a question of these kinds and forms")
    write_whole({out: questions_content(found)})
    if not as_json:
        _print_balance(found)
        _print_chances(found)
    fewer = "" if len(found) == n else f"; the tasks give no more than these of {n:,}"
    line = f"{counted(len(found), 'question')} written to {out}{fewer}"
    chance: dict[str, Json] = {
        f"{kind.value}.{form.value}": {name: rate.percent for name, rate in chances.items()}
        for (kind, form), chances in _chances(found).items()
    }
    value: dict[str, Json] = {"file": str(out), "questions": len(found), "chance": chance}
    tell(line, value=value, as_json=as_json)


def _print_balance(questions: Sequence[Question]) -> None:
    kinds = list(dict.fromkeys([question.kind for question in questions]))
    columns: list[NamedCells] = [
        (
            Column(f"{form.value}\n{heading}", number=True),
            [cell(questions, kind, form) for kind in kinds],
        )
        for form in dict.fromkeys([question.form for question in questions])
        for heading, cell in (("n", _number), ("entropy", _entropy))
    ]
    title = "Questions, and how even their answers are (1: entirely)"
    print_table(output(), Shown.of_columns(title, [("kind", [kind.value for kind in kinds]), *columns]))


def _print_chances(questions: Sequence[Question]) -> None:
    """The rates of guessing and shortcuts, the best of them for each kind and form."""
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
    alike = grouped(((question.kind, question.form), question) for question in questions)
    return {cell: chances_of(some, guesses) for cell, some in alike.items()}


def _best(chances: Mapping[str, Rate], heading: str) -> Cell:
    if not chances:
        return "-"
    best = best_chance(chances)
    return best if heading == "by" else Estimate.of_rate(chances[best])


def _number(questions: Sequence[Question], kind: Kind, form: Form) -> str:
    return str(sum((each.kind, each.form) == (kind, form) for each in questions))


def _entropy(questions: Sequence[Question], kind: Kind, form: Form) -> str:
    entropy = entropy_of(questions, kind, form)
    return "-" if entropy is None else f"{entropy:.2f}"
