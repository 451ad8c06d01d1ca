"""The metrics of a run, as its ability declares them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from eai.abilities.declaration import declaration_of
from eai.abilities.protocol import Ability
from eai.abilities.record import Record
from eai.abilities.share import Shares
from eai.abilities.verdict import Verdict
from eai.results.certainty import Case
from eai.results.rate import NOTHING, Rate, total


def summarise(verdicts: Sequence[Verdict], ability: Ability) -> dict[str, Rate]:
    """All metrics of the paper's tables for an ability, by name, over the verdicts that are not excluded.

    Metrics without any verdict are there all the same, as nothing of nothing.
    """
    declared = declaration_of(ability)
    nothing = dict.fromkeys(declared.contributions(declared.verdict()), NOTHING)
    return {**nothing, **total(_contributions(verdicts, ability))}


def contributions(verdicts: Sequence[Verdict], ability: Ability) -> list[Shares]:
    """What each verdict of a run that is not excluded contributes to each metric, in order."""
    return list(_contributions(verdicts, ability))


def _contributions(verdicts: Sequence[Verdict], ability: Ability) -> Iterator[Shares]:
    """The same one after the other: of a long run all at once are a great many small objects."""
    declared = declaration_of(ability)
    scored = [verdict for verdict in verdicts if verdict.excluded is None]
    return map(declared.contributions, declared.of_run(scored))


def cases_of(records: Sequence[Record], ability: Ability) -> dict[str, list[Case]]:
    """What the records of a run add to each metric, in order; excluded ones add nothing."""
    scored = [record for record in records if record.verdict.excluded is None]
    cases: dict[str, list[Case]] = {}
    for record, shares in zip(scored, contributions([r.verdict for r in scored], ability), strict=True):
        for metric, share in shares.items():
            cases.setdefault(metric, []).append(Case(record.task_id, name_of(record), share))
    return cases


def name_of(record: Record) -> str:
    """The name that near copies of a task share; where it is not known, the task stands for itself."""
    return record.task_id if record.task is None else record.task.name
