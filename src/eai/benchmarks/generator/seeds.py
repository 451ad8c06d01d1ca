"""Choose tasks from the tasks that seeds give.

The task of a seed does not depend on other seeds, so several processes can make tasks. Only two steps must
follow the order of the seeds: to reject copies of earlier tasks, and to choose pairs of a possible and an
impossible task. Pairs are chosen so that categories of objects do not show which task is impossible.
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
from eai.benchmarks.generator.twins import ImpossibleMinusPossibleTasks, PossibleImpossiblePairChooser

_MAX_FAILED_SEEDS = 300
"""Maximum number of seeds in a row without a task. If it is reached, generation fails.

Many seeds belong to other splits (such as the training set). So for a split, the number is divided by the
smallest share in `SHARES`.
"""

_PAIRS_FACTOR = 4
"""Factor by which `_MAX_FAILED_SEEDS` is multiplied if a seed must give a possible and an impossible task.

More seeds fail then, because the two tasks must be alike.
"""

_MAX_FEW_GOALS = 10
"""Maximum number of different lists of goals in a world that counts as a world with few goals."""

_MAX_FAILED_SEEDS_WITH_FEW_GOALS = 100
"""Number of seeds in a row without a task, at which generation fails in a world with few goals."""


@dataclass(frozen=True, slots=True)
class TaskSeedOutcome:
    """The task made from a seed or the reason for rejection, before comparison with tasks of earlier seeds.

    Attributes:
        outcome: the task, the reason why the seed is rejected, or a function that makes a pair of a possible
            and an impossible task. The function takes counts of the pairs of earlier seeds
            (`ImpossibleMinusPossibleTasks`), because they decide which pair it makes.
        fingerprint: digests of goals and scene that show a copy; None if the seed was rejected before these
            were known.
    """

    outcome: GenerationOutcome | PossibleImpossiblePairChooser
    fingerprint: tuple[str, str] | None = None

    def decide_outcome_given_earlier_tasks(
        self,
        known_fingerprints: Collection[tuple[str, str]],
        impossible_minus_possible_counts: ImpossibleMinusPossibleTasks,
    ) -> GenerationOutcome:
        """Return the task of the seed, or the reason why the seed is rejected.

        Args:
            known_fingerprints: fingerprints of earlier tasks.
            impossible_minus_possible_counts: numbers of impossible minus possible tasks in the pairs of
                earlier seeds. The pair of this seed is added to these numbers.
        """
        if self.fingerprint in known_fingerprints and self.outcome is not SeedRejectionReason.OTHER_SPLIT:
            return SeedRejectionReason.COPY
        if isinstance(self.outcome, GeneratedTask | SeedRejectionReason):
            return self.outcome
        return self.outcome(impossible_minus_possible_counts) or SeedRejectionReason.NO_TWIN


def select_tasks(
    judged: Iterable[TaskSeedOutcome],
    spec: TaskSpecification,
    number: int,
    known_fingerprints: set[tuple[str, str]],
    fingerprint_log: list[tuple[str, str]] | None = None,
) -> Iterator[GenerationOutcome]:
    """Yield, for each seed, the generated task or the reason for rejection, until there are `number` tasks.

    If there are no more seeds, fewer tasks are generated.

    Args:
        judged: for each seed in order, its task or the reason for rejection.
        spec: the specification of the tasks.
        number: number of tasks, at least 1.
        known_fingerprints: fingerprints of earlier tasks. Those of the generated tasks are added.
        fingerprint_log: list to which the fingerprints of tasks and rejected duplicates are added in order.

    Raises:
        InputError: too many seeds in a row give no task.
    """
    generated = failures = 0
    reasons = Counter[str]()
    goals = Counter[str]()
    impossible_minus_possible_counts = ImpossibleMinusPossibleTasks()
    fingerprint_log = [] if fingerprint_log is None else fingerprint_log
    limit = _MAX_FAILED_SEEDS * (_PAIRS_FACTOR if spec.kind is TaskKind.PAIRS else 1)
    if spec.split is not TaskSplit.ALL:
        limit = round(limit / min(sets.SHARES.values()))
    for seed in judged:
        outcome = seed.decide_outcome_given_earlier_tasks(
            known_fingerprints, impossible_minus_possible_counts
        )
        if seed.fingerprint is not None:
            goals[seed.fingerprint[0]] += 1
        if isinstance(outcome, GeneratedTask):
            fingerprint = sets.fingerprint_task(outcome.task, spec.held_out)
            known_fingerprints.add(fingerprint)
            fingerprint_log.append(fingerprint)
            generated += 1
            failures = 0
            reasons.clear()
        else:
            if outcome is SeedRejectionReason.COPY and seed.fingerprint is not None:
                fingerprint_log.append(seed.fingerprint)
            failures += 1
            reasons[outcome.value] += 1
        yield outcome
        if generated == number:
            return
        has_few_goals = spec.held_out != "starts" and _has_few_goals(goals)
        if failures >= (_MAX_FAILED_SEEDS_WITH_FEW_GOALS if has_few_goals else limit):
            why = ", ".join(f"{reason} ({n})" for reason, n in reasons.most_common(2))
            given = f"the last {failures} seeds gave no task: {why}"
            few = f"; all seeds have only {len(goals)} different lists of goals: try --held-out starts"
            message = f"only {generated} of {number} tasks generated; {given}"
            raise InputError(message + few * has_few_goals)


def _has_few_goals(goals: Counter[str]) -> bool:
    """Whether many seeds gave goals, but most of their lists of goals are equal to earlier lists."""
    return goals.total() >= _MAX_FAILED_SEEDS_WITH_FEW_GOALS and len(goals) <= _MAX_FEW_GOALS
