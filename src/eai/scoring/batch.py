"""Scoring many answers, in this process or in several, and what is not answered with them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import tee
from operator import length_hint
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from eai.abilities.declaration import declaration_of
from eai.abilities.explanation import Explanation
from eai.abilities.protocol import Ability
from eai.abilities.record import NOT_ANSWERED, Record, TaskFeatures
from eai.abilities.responses import Response, ResponseFile
from eai.abilities.verdict import Verdict
from eai.benchmark.suite import Suite
from eai.scoring.records import Shard
from eai.scoring.workers import LARGEST, SMALLEST, Workers

if TYPE_CHECKING:
    from eai.scoring.reward import Reward

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
        look_back: how many states a search that says more of a verdict may look at; no search if None.
    """

    workers: int = 1
    explanations: bool = True
    allow_missing: bool = False
    shard: Shard | None = None
    look_back: int | None = None


Progressed: TypeAlias = Callable[[int], None]
"""Shows how many answers are scored so far."""


@dataclass(frozen=True, slots=True)
class _Missing:
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
        responses: Iterable[Response | _Missing],
        *,
        explanations: bool = False,
        allow_missing: bool = False,
        look_back: int | None = None,
    ) -> Iterator[Record]:
        """The records of a model's answers, in their order.

        Args:
            suite: the tasks, opened for these answers (`Suite.over`).
            model: who answered.
            responses: the answers; a task may be answered any number of times.
            explanations: put the step-by-step explanation into each record.
            allow_missing: leave tasks without an answer out of all rates instead of counting them as failed.
            look_back: how many states a search that says more of a verdict may look at; no search if None.
        """
        workers = self if suite.portable else Scoring()  # what has no name cannot be opened elsewhere
        asked, given = tee(responses)
        work = _Judge(suite, explanations, allow_missing, look_back)
        judged = workers.each(work, given, at_a_time=workers._shares(suite, length_hint(responses)))
        return map(partial(_record, suite, model), asked, judged)

    def rewards(self, reward: Reward, answers: Iterable[tuple[str, str]]) -> Iterator[float | None]:
        """The records of answers, in their order.

        Args:
            reward: of which suite, and what is paid for.
            answers: ids of tasks with answers.
        """
        workers = self if reward.suite.portable else Scoring()
        shares = workers._shares(reward.suite, length_hint(answers))
        return workers.each(_Rewards(reward), answers, at_a_time=shares)

    def _shares(self, suite: Suite, number: int) -> tuple[int, int]:
        """How many answers a worker is given at first and at most: few where a planner may take minutes.

        Of a known number each worker has two equal shares, since every batch costs something by itself.

        Args:
            suite: what is answered.
            number: how many answers there are; 0 where that is not known.
        """
        if suite.ability is Ability.TRANSITION_MODELING:
            return 1, 4
        if not number:
            return SMALLEST, LARGEST
        share = min(max(SMALLEST, -(-number // (2 * max(1, self._number)))), LARGEST)
        return share, share


class _Judged(NamedTuple):
    """The part of a record that is not known before an answer is scored: all that a worker sends back."""

    verdict: Verdict
    task: TaskFeatures | None
    explanation: Explanation | None = None


@dataclass(frozen=True, slots=True)
class _Judge:
    """From answers to what is made of them."""

    suite: Suite
    explanations: bool
    allow_missing: bool
    look_back: int | None

    def __call__(self, items: Sequence[Response | _Missing]) -> list[_Judged]:
        return [self._missing(item) if isinstance(item, _Missing) else self._judged(item) for item in items]

    def _judged(self, response: Response) -> _Judged:
        assessment = self.suite.scorer(response.task_id).assess(response.text)
        explanation = assessment.explain() if self.explanations else None
        verdict = assessment.verdict
        if self.look_back is not None and assessment.look_back is not None:
            verdict = assessment.look_back(self.look_back)
        return _Judged(verdict, self.suite.features(response.task_id), explanation)

    def _missing(self, missing: _Missing) -> _Judged:
        """The record of a task without an answer."""
        if self.allow_missing and self.suite.scorer(missing.task_id).why_excluded() is None:
            verdict = declaration_of(self.suite.ability).verdict(excluded=NOT_ANSWERED)
        else:
            verdict = self.suite.unanswered(missing.task_id)
        return _Judged(verdict, self.suite.features(missing.task_id))


@dataclass(frozen=True, slots=True)
class _Rewards:
    """From answers to what they are worth."""

    reward: Reward

    def __call__(self, items: Sequence[tuple[str, str]]) -> list[float | None]:
        return [self.reward(task_id, text) for task_id, text in items]


def _items_of(
    suite: Suite, answers: ResponseFile, unanswered: Mapping[str, str]
) -> list[Response | _Missing]:
    """All tasks that a model was asked, in the order of the data set: its answers, or why there are none."""
    by_id: dict[str, Response | _Missing] = {response.task_id: response for response in answers.responses}
    by_id |= {task_id: _Missing(task_id, why) for task_id, why in unanswered.items()}
    return [by_id[task_id] for task_id in suite.task_ids if task_id in by_id]


def score_run(
    suite: Suite,
    answers: ResponseFile,
    unanswered: Mapping[str, str],
    settings: Settings,
    progressed: Progressed | None = None,
    scoring: Scoring | None = None,
) -> list[Record]:
    """The records of all tasks that a model was asked, in the order of the data set.

    Args:
        suite: the tasks.
        answers: the answers, whose form together may decide how each is read.
        unanswered: why a task that was asked has no answer, by its id.
        settings: how to score.
        progressed: shows how far it is.
        scoring: what scores; opened for this alone if None.
    """
    if scoring is None:
        with Scoring(settings.workers) as opened:
            return score_run(suite, answers, unanswered, settings, progressed, opened)
    together = suite.over([response.text for response in answers.responses])
    items = _items_of(suite, answers, unanswered)
    records = scoring.records(
        together,
        answers.model,
        items if settings.shard is None else settings.shard.of_these(items),
        explanations=settings.explanations,
        allow_missing=settings.allow_missing,
        look_back=settings.look_back,
    )
    found: list[Record] = []
    for record in records:
        found.append(record)
        if progressed is not None:
            progressed(len(found))
    return _with_harness(suite.ability, found)


def _with_harness(ability: Ability, records: list[Record]) -> list[Record]:
    """The records of a run with the harness that answers name; tasks without an answer have the first."""
    harness_of = declaration_of(ability).harness
    harnesses = [harness_of(record.verdict) for record in records]
    first = next(filter(None, harnesses), None)
    return [record.varied(harness=own or first) for record, own in zip(records, harnesses, strict=True)]


def _record(suite: Suite, model: str, item: Response | _Missing, judged: _Judged) -> Record:
    text, why = ("", item.why) if isinstance(item, _Missing) else (item.text, None)
    return Record(
        suite.protocol,
        suite.domain,
        suite.ability,
        model,
        item.task_id,
        text,
        suite.data_sha256,
        judged.verdict,
        judged.explanation,
        task=judged.task,
        unanswered=why,
        suite_size=len(suite.task_ids),
        errata=suite.errata.use(suite.ability, item.task_id),
    )
