"""World-model questions in a report: how many of each kind are right, and what guessing gives."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Sequence
from itertools import groupby

from eai.questions.question import Kind
from eai.questions.records import QuestionRun
from eai.questions.results import Row, table_json, tabulate
from eai.report.table_specs import domain_title
from eai.results.markdown import escaped, table_markdown
from eai.results.table import NO_NUMBER, Cell, Column, Estimate, Table

_INTRODUCTION = """\
Right in all that is asked, in percent, with 95 % intervals whose units are the tasks that questions are
about. Chance is the best rate without knowing the world: by guessing (of a choice the share that is hit at
random, in open form that of the most common answer) or by a shortcut, such as the longest choice;
`questions.json` has each. A question without an answer is wrong. Models stand side by side where they were
asked questions of the same file."""

_BESIDES = ("95 %", "of", "chance")
"""What stands beside how many are right."""


def question_section(runs: Sequence[QuestionRun]) -> Iterator[str]:
    """The section of the page.

    Args:
        runs: the runs, by domain and questions.
    """
    if not runs:
        return
    yield "## World-model questions\n"
    yield f"{_INTRODUCTION}\n"
    for title, group in _by_questions(runs):
        yield f"### {title}\n"
        yield table_markdown(_table(title, group))


def questions_latex(runs: Sequence[QuestionRun], models: Collection[str] = ()) -> Iterator[tuple[str, Table]]:
    """The same tables for LaTeX, by what they are referred to by.

    Args:
        runs: the runs, by domain and questions.
        models: the only ones that are shown; all if empty.
    """
    shown = [run for run in runs if not models or run.model in models]
    for title, group in _by_questions(shown):
        yield f"questions:{group[0].questions_sha256[:12]}", _table(title, group)


def _by_questions(runs: Sequence[QuestionRun]) -> Iterator[tuple[str, list[QuestionRun]]]:
    """The runs on each file of questions, under a title."""
    for (domain, digest), group in groupby(runs, key=lambda run: (run.domain, run.questions_sha256)):
        yield f"{domain_title(domain)}, questions {digest[:12]}", list(group)


def questions_json(runs: Sequence[QuestionRun]) -> str:
    """All rates for programs."""
    content = [
        {
            "domain": run.domain,
            "model": run.model,
            "questions_sha256": run.questions_sha256,
            "unit": "percent",
            **table_json(tabulate(run.results)),
        }
        for run in runs
    ]
    return json.dumps({"questions": content}, indent=1, ensure_ascii=False) + "\n"


def _table(title: str, runs: Sequence[QuestionRun]) -> Table:
    """A row a kind, and one of all; of the same file models may have been asked different parts."""
    tables = [tabulate(run.results) for run in runs]
    kinds: list[Kind | None] = [kind for kind in Kind if any(kind in table.by_kind for table in tables)]
    rows: list[tuple[Cell, ...]] = []
    for kind in (*kinds, None):
        found = [table.overall if kind is None else table.by_kind.get(kind) for table in tables]
        rows.append(("all" if kind is None else kind.value, *(cell for row in found for cell in _cells(row))))
    caption = (
        f"World-model questions, {title}. Percent right, with 95 % intervals by task, of how many, and "
        "what guessing or a shortcut gives"
    )
    columns = [column for run in runs for column in _columns(run.model)]
    return Table("questions", title, caption, ("kind", *columns), tuple(rows))


def _columns(model: str) -> Iterator[Column]:
    yield Column("right", group=model, alone=escaped(model), digits=1, number=True)
    for name in _BESIDES:
        yield Column(name, group=model, digits=1, number=True)


def _cells(row: Row | None) -> Sequence[Cell]:
    if row is None:
        return [NO_NUMBER] * 4
    interval = NO_NUMBER if row.interval is None else f"{row.interval[0]:.1f}–{row.interval[1]:.1f}"
    exact, chance = Estimate.of_rate(row.exact), Estimate.of_rate(row.chance)
    return [exact, interval, f"{row.exact.denominator:g}", chance]
