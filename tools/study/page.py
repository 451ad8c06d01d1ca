"""The study as a page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from claim import Claim, Finding, Status
from evidence import Evidence

from eai.results.paper_tables import paper_models

HEAD = (Path(__file__).parent / "head.md").read_text(encoding="utf-8")

MEANING = {
    Status.REPRODUCED: "the figures, or the order that is claimed, come out",
    Status.IN_PART: "some of what is claimed does",
    Status.NOT_SUPPORTED: "the answers say otherwise, or cannot tell it from nothing",
    Status.ARTEFACT: "the figures come out, and mean something else than what is claimed",
    Status.CANNOT_BE_CHECKED: "what it takes is not published, or the paper contradicts itself",
}


def page_of(claims: Sequence[Claim], evidence: Evidence, *, planner: bool = True) -> str:
    """The whole page; claims that there are no records or no planner for are named at the end."""
    known = [claim for claim in claims if has_records(claim, evidence) and (planner or not claim.plans)]
    found = [(claim, claim.find(evidence)) for claim in known]
    return (
        "\n".join(
            [head(evidence, len(known)), *_overview(found), *_details(found), *_left_out(claims, known)]
        )
        + "\n"
    )


def has_records(claim: Claim, evidence: Evidence) -> bool:
    """Whether all suites that a claim takes are there."""
    return claim.needs <= evidence.suites.keys()


def head(evidence: Evidence, claims: int) -> str:
    names = [paper_models().get(model, model) for model in evidence.models]
    records = next(iter(next(iter(evidence.suites.values())).values()), None) if evidence.suites else None
    protocol = records[0].protocol.value if records else "-"
    return HEAD.format(
        models=", ".join(names) or "No model", count=len(names), protocol=protocol, claims=claims
    )


def _overview(found: Sequence[tuple[Claim, Finding]]) -> Iterator[str]:
    tally = Counter(finding.status for _, finding in found)
    yield "| status | claims | meaning |"
    yield "|---|--:|---|"
    yield from (
        f"| {status.value} | {tally[status]} | {MEANING[status]} |" for status in Status if tally[status]
    )
    yield ""
    yield "| | claim | status | what comes out |"
    yield "|---|---|---|---|"
    for claim, finding in found:
        link = f"[{claim.key}](#{anchor(claim)})"
        yield f"| {link} | {claim.title} | **{finding.status.value}** | {finding.summary} |"
    yield ""


def _details(found: Sequence[tuple[Claim, Finding]]) -> Iterator[str]:
    for claim, finding in found:
        yield from section(claim, finding)


def section(claim: Claim, finding: Finding) -> Iterator[str]:
    """A claim with all that was found."""
    yield f"## {claim.key} {claim.title}"
    yield ""
    yield f"*The paper ({claim.place}):* {claim.says}"
    yield ""
    yield f"**{finding.status.value.capitalize()}.** {finding.summary}"
    yield ""
    if finding.rows:
        yield "| | paper | what comes out |"
        yield "|---|--:|--:|"
        yield from (f"| {row.what} | {row.printed} | {row.ours} |" for row in finding.rows)
        yield ""
    yield f"Rule for “reproduced”: {claim.rule}.{f' {claim.note}' if claim.note else ''}"
    yield ""


def anchor(claim: Claim) -> str:
    """The address of a section, as GitHub makes it from a heading."""
    kept = "".join(c for c in f"{claim.key} {claim.title}".lower() if c.isalnum() or c in " -_")
    return kept.replace(" ", "-")


def _left_out(claims: Sequence[Claim], known: Sequence[Claim]) -> Iterator[str]:
    missing = [claim for claim in claims if claim not in known]
    if missing:
        yield "## Left out"
        yield ""
        for claim in missing:
            needs = [*sorted(map(str, claim.needs)), *(["a planner"] if claim.plans else [])]
            yield f"* {claim.key} {claim.title}: takes {'; '.join(needs)}"
