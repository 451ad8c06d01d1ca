"""Write the study as a page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path

from claim import Claim, Finding, Status
from conditions import partial_success_table
from evidence import Evidence
from statements import Checker, Statement, read_statements

from eai.results.paper_tables import map_files_to_paper_models

HEAD = (Path(__file__).parent / "head.md").read_text(encoding="utf-8")

MEANING = {
    Status.REPRODUCED: "the claimed figures, or the claimed order, are confirmed",
    Status.IN_PART: "a part of the claim is confirmed",
    Status.NOT_SUPPORTED: "the answers contradict the claim, or its effect cannot be distinguished from zero",
    Status.ARTEFACT: "the figures are confirmed, but do not mean what the paper claims",
    Status.CANNOT_BE_CHECKED: "the necessary data are not published, or the paper contradicts itself",
    Status.NOT_JUDGED: "a definition, a guess, or about things outside the data; the row gives the reason",
}


def page_of(claims: Sequence[Claim], evidence: Evidence, *, planner: bool = True) -> str:
    """Return the whole page. Claims without records or planner are named at its end."""
    known = [claim for claim in claims if has_records(claim, evidence) and (planner or not claim.plans)]
    found = [(claim, claim.find(evidence)) for claim in known]
    judged = judged_statements(evidence, found, planner=planner) if evidence.is_whole else []
    measured = partial_success_table() if evidence.is_whole else iter(())
    parts = [_statements(judged), _overview(found), _details(found), _left_out(claims, known), measured]
    lines = [head(evidence, len(known), judged), *(line for part in parts for line in part)]
    return "\n".join(lines).rstrip() + "\n"


def judged_statements(
    evidence: Evidence, found: Sequence[tuple[Claim, Finding]], *, planner: bool
) -> list[tuple[Statement, Finding]]:
    """Return all statements of the paper with their findings."""
    checker = Checker(evidence, {claim.key: (claim, finding) for claim, finding in found}, planner=planner)
    return [(statement, checker.find(statement.check)) for statement in read_statements()]


def rows_with(words: str, claims: Sequence[Claim], evidence: Evidence, *, planner: bool) -> str:
    """Return the rows of statements whose section, text or check has some words."""
    chosen = [each for each in read_statements() if any(words in part for part in each)]
    checks = " & ".join(each.check for each in chosen).split(" & ")
    known = [claim for claim in claims if f"claim: {claim.key}" in checks and (planner or not claim.plans)]
    checker = Checker(
        evidence, {claim.key: (claim, claim.find(evidence)) for claim in known}, planner=planner
    )
    return "\n".join(_statements([(each, checker.find(each.check)) for each in chosen]))


def has_records(claim: Claim, evidence: Evidence) -> bool:
    """Return whether all suites that a claim needs have records."""
    return claim.needs <= evidence.suites.keys()


def head(evidence: Evidence, claims: int, judged: Sequence[tuple[Statement, Finding]]) -> str:
    names = [map_files_to_paper_models().get(model, model) for model in evidence.models]
    records = next(iter(next(iter(evidence.suites.values())).values()), None) if evidence.suites else None
    protocol = records[0].protocol.value if records else "-"
    return HEAD.format(
        models=", ".join(names) or "No model",
        count=len(names),
        protocol=protocol,
        claims=claims,
        statements=len(judged),
    )


def _statements(judged: Sequence[tuple[Statement, Finding]]) -> Iterator[str]:
    """Yield the list of statements, the tally first."""
    if not judged:
        return
    tally = Counter(finding.status for _, finding in judged)
    yield "## All statements"
    yield ""
    yield "| status | statements | meaning |"
    yield "|---|--:|---|"
    yield from (
        f"| {status.value} | {tally[status]} | {MEANING[status]} |" for status in Status if tally[status]
    )
    yield ""
    yield "A statement that stands in several sections counts once in each of them."
    yield ""
    for section_name, group in groupby(judged, key=lambda item: item[0].section):
        yield f"### {section_name}"
        yield ""
        yield "| statement | status | evidence |"
        yield "|---|---|---|"
        for statement, finding in group:
            yield f"| {statement.text} | **{finding.status.value}** | {finding.summary.rstrip('.')} |"
        yield ""


def _overview(found: Sequence[tuple[Claim, Finding]]) -> Iterator[str]:
    tally = Counter(finding.status for _, finding in found)
    yield "## Claims with figures"
    yield ""
    yield "| status | claims | meaning |"
    yield "|---|--:|---|"
    yield from (
        f"| {status.value} | {tally[status]} | {MEANING[status]} |" for status in Status if tally[status]
    )
    yield ""
    yield "| | claim | status | result |"
    yield "|---|---|---|---|"
    for claim, finding in found:
        link = f"[{claim.key}](#{claim.anchor})"
        yield f"| {link} | {claim.title} | **{finding.status.value}** | {finding.summary} |"
    yield ""


def _details(found: Sequence[tuple[Claim, Finding]]) -> Iterator[str]:
    for claim, finding in found:
        yield from section(claim, finding)


def section(claim: Claim, finding: Finding) -> Iterator[str]:
    """Yield the section of a claim with its finding."""
    yield f"## {claim.key} {claim.title}"
    yield ""
    yield f"*The paper ({claim.place}):* {claim.says}"
    yield ""
    yield f"**{finding.status.value.capitalize()}.** {finding.summary}"
    yield ""
    if finding.rows:
        yield "| | paper | result |"
        yield "|---|--:|--:|"
        yield from (f"| {row.what} | {row.printed} | {row.ours} |" for row in finding.rows)
        yield ""
    yield f"Rule for “reproduced”: {claim.rule}.{f' {claim.note}' if claim.note else ''}"
    yield ""


def _left_out(claims: Sequence[Claim], known: Sequence[Claim]) -> Iterator[str]:
    missing = [claim for claim in claims if claim not in known]
    if missing:
        yield "## Left out"
        yield ""
        for claim in missing:
            needs = [*sorted(map(str, claim.needs)), *(["a planner"] if claim.plans else [])]
            yield f"* {claim.key} {claim.title}: needs {'; '.join(needs)}"
