"""Suites: all tasks of a domain and an ability, ready to score answers under a protocol."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Protocol as Interface
from typing import TypeAlias

from eai.abilities.explanation import Explanation
from eai.abilities.protocol import Ability, Domain, Protocol
from eai.abilities.verdict import Verdict
from eai.data.progress import Report, silent
from eai.data.store import Store
from eai.errors import InputError


class Scorer(Interface):
    """What scores the answers to one task."""

    def score(self, text: str) -> Verdict:
        """The verdict on an answer: a pure function."""
        ...

    def explain(self, text: str) -> Explanation:
        """What became of an answer, in words."""
        ...


@dataclass(frozen=True)
class Suite:
    """The tasks of a domain and an ability under one protocol.

    Attributes:
        task_ids: the ids of all tasks, in the order of the data set.
        data_sha256: digest of the data behind them.
    """

    domain: Domain
    ability: Ability
    protocol: Protocol
    task_ids: tuple[str, ...]
    data_sha256: str
    _make: Callable[[str], Scorer]
    _made: dict[str, Scorer] = field(default_factory=dict, repr=False)

    def scorer(self, task_id: str) -> Scorer:
        """The scorer of a task; it is made once."""
        scorer = self._made.get(task_id)
        if scorer is None:
            scorer = self._made[task_id] = self._make(task_id)
        return scorer

    def score(self, task_id: str, text: str) -> Verdict:
        """The verdict on an answer to a task."""
        return self.scorer(task_id).score(text)


@dataclass(frozen=True, slots=True)
class Source:
    """Where a suite's data comes from: a store, and who is told of a download."""

    store: Store | None = None
    report: Report = silent


Opener: TypeAlias = Callable[[Protocol, Sequence[str], Source], Suite]


def open_suite(
    domain: Domain,
    ability: Ability,
    protocol: Protocol = Protocol.STRICT,
    *,
    answers: Sequence[str] = (),
    source: Source | None = None,
) -> Suite:
    """Open a suite; the data set is fetched first if it is not there.

    Args:
        domain: the domain.
        ability: the ability.
        protocol: the rules for scoring.
        answers: the texts that will be scored, where the form of all decides how each is read.
        source: where the data comes from; the user's default store if None.

    Raises:
        DataError: the data cannot be had.
        InputError: there is no such suite.
    """
    opener = _OPENERS.get((domain, ability))
    if opener is None:
        raise InputError(f"{domain.value} has no {ability.value} yet")
    return opener(protocol, answers, source or Source())


def available_suites() -> tuple[tuple[Domain, Ability], ...]:
    """Every domain and ability for which there is a suite."""
    return tuple(_OPENERS)


def _virtualhome_action_sequencing(protocol: Protocol, answers: Sequence[str], source: Source) -> Suite:
    from eai.abilities.action_sequencing.virtualhome import ActionSequencing, written_with_ids
    from eai.data.virtualhome_tasks import open_tasks

    tasks = open_tasks(source.store, report=source.report)
    with_ids = written_with_ids(answers) if answers and protocol is Protocol.EAI_1_0_5 else None
    make = partial(ActionSequencing, protocol=protocol, with_ids=with_ids)
    return Suite(
        Domain.VIRTUALHOME,
        Ability.ACTION_SEQUENCING,
        protocol,
        tuple(tasks),
        tasks.sha256,
        lambda task_id: make(tasks[task_id]),
    )


_OPENERS: Mapping[tuple[Domain, Ability], Opener] = {
    (Domain.VIRTUALHOME, Ability.ACTION_SEQUENCING): _virtualhome_action_sequencing,
}
