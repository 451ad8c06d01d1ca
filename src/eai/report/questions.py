"""World-model questions in a report: how many of each kind are right, and what guessing gives."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from itertools import groupby

from eai.questions.question import Kind
from eai.questions.records import QuestionRun
from eai.questions.results import Row, table_json, tabulate
from eai.report.markdown import escaped, grid
from eai.report.table_specs import domain_title

_INTRODUCTION = """\
Right in all that is asked, in percent, with 95 % intervals whose units are the tasks that questions are
about. Chance is what guessing gives: of a choice the share that is hit at random, in open form that of the
most common answer. A question without an answer is wrong. Models stand side by side where they were asked
questions of the same file."""


def question_section(runs: Sequence[QuestionRun]) -> Iterator[str]:
    """The section of the page.

    Args:
        runs: the runs, by domain and questions.
    """
    if not runs:
        return
    yield "## World-model questions\n"
    yield f"{_INTRODUCTION}\n"
    for (domain, digest), group in groupby(runs, key=lambda run: (run.domain, run.questions_sha256)):
        yield f"### {domain_title(domain)}, questions {digest[:12]}\n"
        yield _table(list(group))


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


def _table(runs: Sequence[QuestionRun]) -> str:
    """A row a kind; of the same file models may have been asked different parts."""
    tables = [tabulate(run.results) for run in runs]
    kinds: list[Kind | None] = [kind for kind in Kind if any(kind in table.by_kind for table in tables)]
    rows = []
    for kind in (*kinds, None):
        found = [table.overall if kind is None else table.by_kind.get(kind) for table in tables]
        rows.append(["all" if kind is None else kind.value, *(cell for row in found for cell in _cells(row))])
    header = ["kind", *(heading for run in runs for heading in (escaped(run.model), "95 %", "of", "chance"))]
    return "\n".join(grid(header, rows)) + "\n"


def _cells(row: Row | None) -> list[str]:
    if row is None:
        return ["–"] * 4
    interval = "–" if row.interval is None else f"{row.interval[0]:.1f}–{row.interval[1]:.1f}"
    return [_number(row.exact.percent), interval, f"{row.exact.denominator:g}", _number(row.chance.percent)]


def _number(percent: float | None) -> str:
    return "–" if percent is None else f"{percent:.1f}"
