"""Scoring many answers, in this process or in several, and what is not answered with them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain, tee
from operator import length_hint
from typing import TYPE_CHECKING, TypeAlias

from eai.abilities.declaration import declaration_of
from eai.abilities.experiment import Experiment
from eai.abilities.explanation import Explanation
from eai.abilities.protocol import Ability
from eai.abilities.task_features import TaskFeatures
from eai.abilities.verdict import Verdict
from eai.benchmarks.suite import Suite
from eai.results.options import ScoringOptions
from eai.results.record import NOT_ANSWERED, Record
from eai.results.records import AT_A_TIME, Part, Shard, part_of, record_of
from eai.results.responses import Response, ResponseFile, Row, response_of
from eai.results.workers import LARGEST, SMALLEST, Workers, batches

if TYPE_CHECKING:
    from eai.results.reward import Reward

NO_ROW = "the response file has no row of the task"
"""Why a task without an answer has none, where answers come from a file."""


OTHER_RULES = "the model played the task by other rules of the game"
"""The reason for a task without an answer whose episode is by other rules. The task counts as failed."""


Progressed: TypeAlias = Callable[[int], None]
"""Shows how many answers are scored so far."""


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
        self, suite: Suite, model: str, responses: Iterable[Response], *, explanations: bool = False
    ) -> Iterator[Record]:
        """The records of a model's answers, in their order.

        Args:
            suite: the tasks, opened for these answers (`Suite.over`).
            model: who answered.
            responses: the answers; a task may be answered any number of times.
            explanations: put the step-by-step explanation into each record.
        """
        return self._records(suite, model, responses, ScoringOptions(explanations=explanations))

    def _records(
        self, suite: Suite, model: str, responses: Iterable[Response], settings: ScoringOptions
    ) -> Iterator[Record]:
        workers = self if suite.portable else Scoring()  # what has no name cannot be opened elsewhere
        asked, given = tee(responses)
        shares = workers._shares(suite, length_hint(responses))
        judged = workers.each(partial(_judge, suite, settings), given, at_a_time=shares)
        return map(partial(_record, suite, model), asked, judged)

    def parts(
        self,
        suite: Suite,
        answers: ResponseFile,
        unanswered: Mapping[str, str],
        settings: ScoringOptions,
        finish: Callable[[Record], Record] | None = None,
        shard: Shard | None = None,
    ) -> Iterator[Part]:
        """The records of all tasks that a model was asked, ready to be written, a part at a time.

        Answers come in the order of the data set; where a task has several, in that of their file, and tasks
        without any follow. Who scores makes the lines, too, so that here nothing is left but to write them.

        Args:
            suite: the tasks.
            answers: the answers, whose form together may decide how each is read.
            unanswered: why a task that was asked has no answer, by its id.
            settings: how to score; the processes are those of this pool.
            finish: what becomes of a record before it is written; it is pickled.
            shard: the part of the tasks that is scored; all of them if None.
        """
        suite = suite.over(response.text for response in answers.responses)
        items, number = _items_of(suite, answers, unanswered), len(answers.responses) + len(unanswered)
        if shard is not None:
            items, number = shard.of_these(items), -(-number // shard.of)
        marked = partial(_marked, first=_made_by(suite.ability, answers))
        work = partial(_part, suite, settings, answers.model, marked, finish)
        if self._number < 2 or not suite.portable:
            at_a_time = (1, 1) if suite.ability is Ability.TRANSITION_MODELING else (SMALLEST, AT_A_TIME)
            return (part for batch in batches(items, 1, *at_a_time) for part in work(batch))
        first, most = self._shares(suite, number)
        return self.each(work, items, at_a_time=(min(first, AT_A_TIME), min(most, AT_A_TIME)))

    def rewards(self, reward: Reward, answers: Iterable[tuple[str, str]]) -> Iterator[float | None]:
        """The rewards of answers, in their order.

        Args:
            reward: of which suite, and what is paid for.
            answers: ids of tasks with answers.
        """
        workers = self if reward.suite.portable else Scoring()
        shares = workers._shares(reward.suite, length_hint(answers))
        return workers.each(partial(_rewards, reward), answers, at_a_time=shares)

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


_Judged: TypeAlias = tuple[Verdict, TaskFeatures | None, Explanation | None]
"""The part of a record that is not known before an answer is scored: all that a worker sends back."""


def _judge(suite: Suite, settings: ScoringOptions, items: Sequence[Response]) -> list[_Judged]:
    """From answers to what is made of them."""
    return [_judged(suite, settings, item) for item in items]


def _judged(suite: Suite, settings: ScoringOptions, item: Response) -> _Judged:
    explanation = None
    if item.unanswered is not None:
        verdict = suite.unanswered(item.task_id)
        is_elsewhere = item.unanswered == OTHER_RULES
        if settings.allow_missing and not is_elsewhere and suite.scorer(item.task_id).why_excluded() is None:
            verdict = declaration_of(suite.ability).verdict(excluded=NOT_ANSWERED)
    else:
        assessment = suite.assess(item.task_id, item.text)
        explanation = assessment.explain() if settings.explanations else None
        verdict = assessment.verdict
        if settings.look_back is not None and assessment.look_back is not None:
            verdict = assessment.look_back(settings.look_back)
    return verdict, suite.features(item.task_id), explanation


def _part(
    suite: Suite,
    settings: ScoringOptions,
    model: str,
    marked: Callable[[Record], Record],
    finish: Callable[[Record], Record] | None,
    rows: Sequence[Row],
) -> list[Part]:
    """From answers to a part of the records of a run."""
    items = [response_of(row, suite.benchmark.task_id_of) for row in rows]
    records = [marked(_record(suite, model, item, _judged(suite, settings, item))) for item in items]
    return [part_of(records if finish is None else [*map(finish, records)])]


def _rewards(reward: Reward, items: Sequence[tuple[str, str]]) -> list[float | None]:
    return [reward(task_id, text) for task_id, text in items]


def without_row(suite: Suite, answers: ResponseFile) -> dict[str, str]:
    """The tasks of a suite that a response file has no row of, each with that as the reason."""
    answered = answers.answered
    return {task_id: NO_ROW for task_id in suite.task_ids if task_id not in answered}


def _items_of(suite: Suite, answers: ResponseFile, unanswered: Mapping[str, str]) -> Iterator[Row]:
    """All tasks that a model was asked, in the order of the data set: its answers, or why there are none.

    Several answers to a task come as they stand in their file, before all tasks without any.
    """
    lacking = {task_id: Response(task_id, "", unanswered=why) for task_id, why in unanswered.items()}
    if answers.sampled:
        return chain(answers.rows(), [lacking[i] for i in suite.task_ids if i in lacking])
    by_id = {response.task_id: response for response in answers.responses} | lacking
    return (by_id[task_id] for task_id in suite.task_ids if task_id in by_id)


def by_rules(ability: Ability, answers: ResponseFile) -> dict[str | None, ResponseFile]:
    """Return answers by the rules of the game by which they were made, with their further epochs.

    Answers by the standard rules, whose key is None, come first. Empty and unreadable answers, which fail by
    any rules, are with them, or with the most frequent rules if no answer is by the standard rules.
    """
    declared = declaration_of(ability)
    if not declared.takes_turns:
        return {None: answers}
    made_by = declared.made_by
    epochs = (replace(answers, further=()), *answers.further)
    made = (made_by(response.text) for epoch in epochs for response in epoch.responses)
    times = Counter(each.rules for each in made if each is not None)
    if len(times) < 2:
        return dict.fromkeys(times or (None,), answers)
    usual = None if None in times else times.most_common(1)[0][0]

    def key(text: str) -> str | None:
        each = made_by(text)
        return usual if each is None else each.rules

    parts = [epoch.split(key) for epoch in epochs]
    found = {}
    for rules in sorted(times, key=lambda rules: rules or ""):
        first, *further = [part[rules] for part in parts if rules in part]
        found[rules] = replace(first, further=tuple(further))
    return found


def _made_by(ability: Ability, answers: ResponseFile) -> Experiment:
    """Return the first harness that answers name, and the rules of the first answer that can be read."""
    declared = declaration_of(ability)
    first: Experiment | None = None
    if not declared.takes_turns:
        return Experiment()
    for each in filter(None, (declared.made_by(response.text) for response in answers.responses)):
        first = first or each
        if each.harness is not None:
            return replace(first, harness=each.harness)
    return first or Experiment()


def _marked(record: Record, first: Experiment) -> Record:
    """Return a record with the harness and the rules of its answer, or else of the answers beside it."""
    own = declaration_of(record.ability).made_by(record.response) or first
    return record.varied(replace(own, harness=own.harness or first.harness))


def score_run(
    suite: Suite,
    answers: ResponseFile,
    unanswered: Mapping[str, str],
    settings: ScoringOptions,
    progressed: Progressed | None = None,
) -> list[Record]:
    """The records of all tasks that a model was asked, in the order of the data set.

    Args:
        suite: the tasks.
        answers: the answers, whose form together may decide how each is read.
        unanswered: why a task that was asked has no answer, by its id.
        settings: how to score.
        progressed: shows how far it is.
    """
    suite = suite.over(response.text for response in answers.responses)
    rows = _items_of(suite, answers, unanswered)
    items = [response_of(row, suite.benchmark.task_id_of) for row in rows]
    found: list[Record] = []
    first = _made_by(suite.ability, answers)
    with Scoring(settings.workers) as scoring:
        for record in scoring._records(suite, answers.model, items, settings):
            found.append(_marked(record, first))
            if progressed is not None:
                progressed(len(found))
    return found


def _record(suite: Suite, model: str, item: Response, judged: _Judged) -> Record:
    verdict, task, explanation = judged
    about = {"explanation": explanation, "task": task, "sample": item.sample, "unanswered": item.unanswered}
    return record_of(suite, model, item.task_id, item.text, verdict, **about)
