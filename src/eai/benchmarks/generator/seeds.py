"""Choose tasks from the outcomes of seeds.

The outcome of a seed does not depend on other seeds, so several processes can judge seeds. Only a comparison
with earlier tasks must follow the order of the seeds: a copy is rejected, and pairs of tasks are balanced.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass

from eai.base.errors import InputError
from eai.benchmarks.generator import sets
from eai.benchmarks.generator.spec import (
    GeneratedTask,
    GenerationOutcome,
    SeedRejectionReason,
    TaskKind,
    TaskSpecification,
    TaskSplit,
)
from eai.benchmarks.generator.twins import Balance, PairChoice

_MAX_FAILED_SEEDS = 300
"""Number of rejected seeds in a row after which generation fails. The limit is higher for splits of a set."""

_PAIRS_FACTOR = 4
"""Factor by which `_MAX_FAILED_SEEDS` is multiplied for pairs of tasks, because few seeds give a pair."""


@dataclass(frozen=True, slots=True)
class JudgedSeed:
    """The outcome of a seed, before its task is compared with the tasks of earlier seeds.

    Attributes:
        outcome: the task, the reason why the seed is rejected, or a function that makes a pair of tasks.
        fingerprint: digests of goals and scene that show a copy; None if the seed was rejected before a
            comparison with earlier tasks.
    """

    outcome: GenerationOutcome | PairChoice
    fingerprint: tuple[str, str] | None = None

    def compare_with_earlier_tasks(
        self, known: Collection[tuple[str, str]], balance: Balance
    ) -> GenerationOutcome:
        """Return the task of the seed, or the reason why the seed is rejected.

        Args:
            known: fingerprints of earlier tasks.
            balance: counts of the earlier pairs. A new pair is added to them.
        """
        if self.fingerprint in known:
            return SeedRejectionReason.COPY
        if isinstance(self.outcome, GeneratedTask | SeedRejectionReason):
            return self.outcome
        return self.outcome(balance) or SeedRejectionReason.NO_TWIN


def select_tasks(
    judged: Iterable[JudgedSeed], spec: TaskSpecification, number: int, known: set[tuple[str, str]]
) -> Iterator[GenerationOutcome]:
    """Yield, for each seed, the generated task or the reason for rejection, until there are `number` tasks.

    Args:
        judged: the outcomes of endless seeds, in the order of the seeds.
        spec: the specification of the tasks.
        number: number of tasks.
        known: fingerprints of earlier tasks. Fingerprints of the generated tasks are added to this set.

    Raises:
        InputError: too many seeds in a row give no task.
    """
    generated = failures = 0
    reasons, balance = Counter[str](), Balance()
    limit = _MAX_FAILED_SEEDS * (_PAIRS_FACTOR if spec.kind is TaskKind.PAIRS else 1)
    if spec.split is not TaskSplit.ALL:
        limit = round(limit / min(sets.SHARES.values()))
    outcomes = iter(judged)
    while generated < number:
        if failures == limit:
            why = ", ".join(f"{reason} ({n})" for reason, n in reasons.most_common(2))
            given = f"the last {failures} seeds gave no task: {why}"
            raise InputError(f"only {generated} of {number} tasks generated; {given}")
        outcome = next(outcomes).compare_with_earlier_tasks(known, balance)
        if isinstance(outcome, GeneratedTask):
            known.add(sets.fingerprint_task(outcome.task))
            generated += 1
            failures = 0
            reasons.clear()
        else:
            failures += 1
            reasons[outcome.value] += 1
        yield outcome
