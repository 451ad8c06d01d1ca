"""Scoring many answers, in this process or in several, and what is not answered with them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from eai.abilities.declarations import DECLARATIONS
from eai.abilities.protocol import Ability
from eai.abilities.record import NOT_ANSWERED, Record
from eai.abilities.responses import Response, ResponseFile
from eai.benchmarks.suite import Suite
from eai.scoring.reward import Reward
from eai.scoring.shards import Shard
from eai.scoring.workers import LARGEST, SMALLEST, Workers

NO_ROW = "the response file has no row of the task"
"""Why a task without an answer has none, where answers come from a file."""


@dataclass(frozen=True, slots=True)
class Settings:
    """How answers are scored.

    Attributes:
        workers: how many processes to use.
        explanations: put the step-by-step explanation into each record.
        allow_missing: leave tasks without an answer out of all rates instead of counting them as failures.
        shard: score this part of the tasks alone; all of them if None.
    """

    workers: int = 1
    explanations: bool = True
    allow_missing: bool = False
    shard: Shard | None = None


Told: TypeAlias = Callable[[int], None]
"""Is told how many answers are scored so far."""


def untold(scored: int) -> None:
    """Tells nobody."""


@dataclass(frozen=True, slots=True)
class Missing:
    """A task that was asked and has no answer, and why."""

    task_id: str
    why: str


class Scoring(Workers):
    """Scores streams of answers, in this process or with workers that stay as long as it is open.

        with Scoring(workers=8) as scoring:
            for record in scoring.records(suite, "my-model", responses):
                ...

    Results come in the order of the answers and are the same for any number of workers. No more than a few
    batches are read ahead, so that memory does not grow with the stream. What a worker that dies was at is
    done again: nothing is lost, nothing comes twice. Workers import the program that uses them, which
    therefore has to begin below ``if __name__ == "__main__":``.

    Args:
        workers: how many processes to use; this one alone if fewer than two.
    """

    def records(
        self,
        suite: Suite,
        model: str,
        responses: Iterable[Response | Missing],
        *,
        explanations: bool = False,
        allow_missing: bool = False,
    ) -> Iterator[Record]:
        """The records of a model's answers, in their order.

        Args:
            suite: the tasks, opened for these answers (`Suite.over`).
            model: who answered.
            responses: the answers; a task may be answered any number of times.
            explanations: put the step-by-step explanation into each record.
            allow_missing: leave tasks without an answer out of all rates instead of counting them as failed.
        """
        workers = self if suite.portable else Workers()  # what has no name cannot be opened elsewhere
        work = _Records(suite, explanations, allow_missing)
        return workers.each(work, responses, model, at_a_time=_at_a_time(suite))

    def rewards(self, reward: Reward, answers: Iterable[tuple[str, str]]) -> Iterator[float | None]:
        """What answers are worth, in their order.

        Args:
            reward: of which suite, and what is paid for.
            answers: ids of tasks with answers.
        """
        workers = self if reward.suite.portable else Workers()
        return workers.each(_Rewards(reward), answers, at_a_time=_at_a_time(reward.suite))


def _at_a_time(suite: Suite) -> tuple[int, int]:
    """How many answers a worker is given at first and at most: few where a planner may take minutes."""
    return (1, 4) if suite.ability is Ability.TRANSITION_MODELING else (SMALLEST, LARGEST)


@dataclass(frozen=True, slots=True)
class _Records:
    """From answers to records."""

    suite: Suite
    explanations: bool
    allow_missing: bool

    def __call__(self, items: Sequence[Response | Missing], model: str) -> list[Record]:
        return [
            _lacking(self.suite, model, item, left_out=self.allow_missing)
            if isinstance(item, Missing)
            else _record(self.suite, model, item, explanations=self.explanations)
            for item in items
        ]


@dataclass(frozen=True, slots=True)
class _Rewards:
    """From answers to what they are worth."""

    reward: Reward

    def __call__(self, items: Sequence[tuple[str, str]]) -> list[float | None]:
        return [self.reward(task_id, text) for task_id, text in items]


def _asked(suite: Suite, answers: ResponseFile, unanswered: Mapping[str, str]) -> list[Response | Missing]:
    """All tasks that a model was asked, in the order of the data set: its answers, or why there are none."""
    by_id: dict[str, Response | Missing] = {response.task_id: response for response in answers.responses}
    by_id |= {task_id: Missing(task_id, why) for task_id, why in unanswered.items()}
    return [by_id[task_id] for task_id in suite.task_ids if task_id in by_id]


def score_run(
    suite: Suite,
    answers: ResponseFile,
    unanswered: Mapping[str, str],
    settings: Settings,
    told: Told = untold,
    scoring: Scoring | None = None,
) -> list[Record]:
    """The records of all tasks that a model was asked, in the order of the data set.

    Args:
        suite: the tasks.
        answers: the answers, whose form together may decide how each is read.
        unanswered: why a task that was asked has no answer, by its id.
        settings: how to score.
        told: is told how far it is.
        scoring: what scores; opened for this alone if None.
    """
    if scoring is None:
        with Scoring(settings.workers) as opened:
            return score_run(suite, answers, unanswered, settings, told, opened)
    together = suite.over([response.text for response in answers.responses])
    items = _asked(suite, answers, unanswered)
    records = scoring.records(
        together,
        answers.model,
        items if settings.shard is None else settings.shard.of_these(items),
        explanations=settings.explanations,
        allow_missing=settings.allow_missing,
    )
    return _counted(records, told)


def score_batch(
    suite: Suite,
    answers: ResponseFile,
    *,
    workers: int = 1,
    explanations: bool = False,
    told: Told = untold,
) -> list[Record]:
    """The records of a model's answers, in the order of the answers.

    Args:
        suite: the tasks, opened for these answers.
        answers: what to score.
        workers: how many processes to use for this alone; see `Scoring`.
        explanations: put the step-by-step explanation into each record.
        told: is told how far it is.
    """
    with Scoring(workers) as scoring:
        records = scoring.records(suite, answers.model, answers.responses, explanations=explanations)
        return _counted(records, told)


def _counted(records: Iterable[Record], told: Told) -> list[Record]:
    """All records, of whose number word is given as they come."""
    found: list[Record] = []
    for record in records:
        found.append(record)
        told(len(found))
    return found


def _record(suite: Suite, model: str, response: Response, *, explanations: bool) -> Record:
    assessment = suite.scorer(response.task_id).assess(response.text)
    return Record(
        suite.protocol,
        suite.domain,
        suite.ability,
        model,
        response.task_id,
        response.text,
        suite.data_sha256,
        assessment.verdict,
        assessment.explain() if explanations else None,
        task=suite.features(response.task_id),
        suite_size=len(suite.task_ids),
        errata=suite.errata.use(suite.ability, response.task_id),
    )


def _lacking(suite: Suite, model: str, missing: Missing, *, left_out: bool) -> Record:
    """The record of a task without an answer."""
    task_id = missing.task_id
    verdict = suite.unanswered(task_id)
    if left_out and verdict.excluded is None:
        verdict = DECLARATIONS[suite.ability].verdict(excluded=NOT_ANSWERED)
    return Record(
        suite.protocol,
        suite.domain,
        suite.ability,
        model,
        task_id,
        "",
        suite.data_sha256,
        verdict,
        task=suite.features(task_id),
        unanswered=missing.why,
        suite_size=len(suite.task_ids),
        errata=suite.errata.use(suite.ability, task_id),
    )
