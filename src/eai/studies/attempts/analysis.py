"""Replanning: what further attempts are worth, and how much of that is feedback (paper, "Replanning").

Whoever is asked more often succeeds more often. So every arm, a way to ask again, is set beside its control:
the same number of attempts in the same world, without feedback. Attempts at one task depend on each other,
and so do those at near copies; the unit of every interval is the name of the task, whatever its seeds and
attempts.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import fmean
from typing import get_args

from eai.abilities.declaration import COLUMNS, GRAMMAR, RUNTIME, AnswerOutcome
from eai.abilities.experiment import Experiment, Feedback
from eai.abilities.record import Record
from eai.data.grouping import grouped
from eai.results.certainty import Case
from eai.results.rate import rate_of
from eai.results.summary import after, cases_of, outcome, share_of
from eai.results.table import Estimate, Row, Table, table_of
from eai.world.fault import FaultKind

SUCCESS, EXECUTION = "task_success", "execution_success"
_ERRORS = tuple([column.metric for column in COLUMNS if column.group in (GRAMMAR, RUNTIME)])
_RIGHT = (AnswerOutcome.SUCCESS, AnswerOutcome.EXCLUDED, AnswerOutcome.NOT_ANSWERED)


@dataclass(frozen=True, slots=True)
class Arm:
    """One way to ask again, under one or several seeds of slips.

    Attributes:
        experiment: what it is, without the seed.
        runs: the records under each seed, by seed.
    """

    experiment: Experiment
    runs: Mapping[int | None, Sequence[Record]]

    @property
    def name(self) -> str:
        """Its label, in which there is no seed."""
        return self.experiment.label

    @property
    def attempts(self) -> int:
        """How many a task may have."""
        return self.experiment.replans + 1

    @property
    def control(self) -> Experiment:
        """The same without a word."""
        return replace(self.experiment, feedback="none", form="prompt")

    def records(self, attempts: int) -> list[Record]:
        """Those of all seeds, as they would be after so many attempts."""
        return [after(record, attempts) for records in self.runs.values() for record in records]

    def cases(self, metric: str, attempts: int) -> list[Case]:
        """The cases that tasks add to a metric after so many attempts, one seed after the other."""
        return [case for records in self.runs.values() for case in _cases(records, metric, attempts)]


def _cases(records: Sequence[Record], metric: str, attempts: int) -> list[Case]:
    """The cases that a run adds to a metric after so many attempts."""
    stopped = [after(record, attempts) for record in records]
    return cases_of(stopped, stopped[0].ability).get(metric, [])


def arms_of(runs: Sequence[Sequence[Record]]) -> list[Arm]:
    """The arms of some runs of one model and suite, those without feedback first; other runs are none."""
    found: dict[Experiment, dict[int | None, Sequence[Record]]] = {}
    for records in runs:
        experiment = records[0].experiment
        if experiment is not None and experiment.acts:
            found.setdefault(replace(experiment, slip_seed=None), {})[experiment.slip_seed] = records
    order = [*get_args(Feedback)]
    return sorted(
        (Arm(experiment, dict(sorted(by_seed.items(), key=str))) for experiment, by_seed in found.items()),
        key=lambda arm: (arm.experiment.slip, order.index(arm.experiment.feedback), arm.name),
    )


def tables(arms: Sequence[Arm]) -> list[Table]:
    """All tables."""
    return [_by_attempt(arms), _worth(arms), _mended(arms)]


def remarks(arms: Sequence[Arm]) -> list[str]:
    """Remarks for readers: which arms have no control, and which were run once."""
    known = {arm.experiment for arm in arms}
    alone = [arm.name for arm in arms if arm.attempts > 1 and arm.control not in known]
    found = []
    if alone:
        found.append(
            f"No resampling arm stands beside {', '.join(alone)}: what feedback is worth is not known. "
            "`eai run` with the same options and `attempts.feedback=none` makes it."
        )
    once = [arm.name for arm in arms if arm.experiment.slip and len(arm.runs) == 1]
    if once:
        found.append(
            f"One seed of slips: {', '.join(once)}. Its intervals are of other tasks, not of other luck; run "
            "more with `attempts.slip_seed`."
        )
    return found


def success_by_attempt(arm: Arm) -> list[Estimate]:
    """Task success after 1, 2, ... attempts."""
    return [Estimate.of(arm.cases(SUCCESS, number)) for number in range(1, arm.attempts + 1)]


@table_of(
    "attempts",
    (
        *("arm", "attempts", "seeds", "task success", "execution success"),
        *(kind.replace("_", " ") for kind in _ERRORS),
        *("slip", "attempts used", "tokens"),
    ),
)
def _by_attempt(arms: Sequence[Arm]) -> Iterator[Row]:
    """By the number of attempts.

    What each arm would have come to after so many attempts, in percent, with 95 % intervals whose units are
    the names of tasks. Errors are those of the last attempt made; a slip is no error of the model's. Success
    cannot fall, since a success ends the attempts: a rise from one row to the next is no finding by itself.
    Attempts used and tokens are means a task, up to that attempt.
    """
    for arm in arms:
        yield from _attempt_rows(arm)


def _attempt_rows(arm: Arm) -> Iterator[Row]:
    for number in range(1, arm.attempts + 1):
        records = [record for record in arm.records(number) if record.verdict.excluded is None]
        cases = [arm.cases(metric, number) for metric in _ERRORS]
        errors = [rate_of(case.share for case in each).percent for each in cases]
        tokens = [
            sum(each.usage.input_tokens + each.usage.output_tokens for each in record.attempts if each.usage)
            for record in records
        ]
        yield (
            arm.name,
            number,
            len(arm.runs),
            Estimate.of(arm.cases(SUCCESS, number)),
            Estimate.of(arm.cases(EXECUTION, number)),
            *errors,
            share_of(records, [_has_slipped(record) for record in records]).value,
            fmean([len(record.attempts) for record in records]) if records else None,
            fmean(tokens) if any(tokens) else None,
        )


@table_of(
    "worth",
    ("arm", "attempts", "told nothing", "with feedback", "difference"),
    title="What feedback is worth",
)
def _worth(arms: Sequence[Arm]) -> Iterator[Row]:
    """Each arm with feedback beside the one without.

    Task success of the resampling arm, told nothing, and of an arm with feedback, on the same tasks and seeds
    after as many attempts; the difference is in points. In the first attempt both ask the same: what differs
    there is chance, and shows how much of it there is.
    """
    controls = {arm.experiment: arm for arm in arms if arm.experiment.feedback == "none"}
    for arm in arms:
        control = controls.get(arm.control)
        if control is None or control is arm:
            continue
        for number in range(1, arm.attempts + 1):
            one, other = _shared(control, arm, number)
            yield (
                (arm.name, number, Estimate.of(one), Estimate.of(other), Estimate.of_difference(one, other))
            )


@table_of(
    "mended",
    ("arm", "first answer", "tasks", "mended", "same", "another"),
    title="What became of first answers that failed",
)
def _mended(arms: Sequence[Arm]) -> Iterator[Row]:
    """The outcomes of tasks by that of the first answer.

    Tasks by what ended the first answer: how many were solved in the end, in percent, how many ended in the
    same way, and how many in another. What the resampling arm mends is chance.
    """
    for arm in arms:
        by_kind = grouped((outcome(after(record, 1)), record) for record in arm.records(arm.attempts))
        for kind in [kind for kind in AnswerOutcome if kind in by_kind and kind not in _RIGHT]:
            ended = Counter(outcome(record) for record in by_kind[kind])
            mended = [outcome(record) is AnswerOutcome.SUCCESS for record in by_kind[kind]]
            same, tried = ended[kind], len(mended)
            other = tried - same - ended[AnswerOutcome.SUCCESS]
            label = kind.value.replace("_", " ")
            yield (arm.name, label, tried, share_of(by_kind[kind], mended), same, other)


def _has_slipped(record: Record) -> bool:
    error = record.verdict.error
    return error is not None and error.kind is FaultKind.SLIP


def _shared(control: Arm, arm: Arm, attempts: int) -> tuple[list[Case], list[Case]]:
    """The cases of tasks that both have under a seed, in the same order."""
    pairs: list[tuple[Case, Case]] = []
    for seed in [seed for seed in arm.runs if seed in control.runs]:
        before = {case.task: case for case in _cases(control.runs[seed], SUCCESS, attempts)}
        after_it = _cases(arm.runs[seed], SUCCESS, attempts)
        pairs += [(before[case.task], case) for case in after_it if case.task in before]
    return [one for one, _ in pairs], [other for _, other in pairs]
