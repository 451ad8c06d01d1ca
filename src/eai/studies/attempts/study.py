"""Replanning and actions that fail: what further attempts are worth, and how much of that is feedback.

Whoever is asked more often succeeds more often. So every arm, a way to ask again, is set beside its control:
the same number of attempts in the same world, without feedback. Attempts at one task depend on each other,
and so do those at near copies; the unit of every interval is the name of the task, whatever its seeds and
attempts.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import fmean
from typing import TYPE_CHECKING, get_args

from pydantic import Field, model_validator
from typing_extensions import Self

from eai.abilities.attempt_options import (
    AttemptOptions,
    AttemptStart,
    EndCondition,
    FeedbackForm,
    FeedbackLevel,
)
from eai.abilities.declaration import COLUMNS, GRAMMAR, RUNTIME, AnswerOutcome
from eai.abilities.experiment import Experiment, StudyChoice
from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.base.files import to_file_name
from eai.base.grouping import group_pairs
from eai.benchmarks.protocols import preset_attempts
from eai.results.certainty import Case
from eai.results.paper_tables import PaperTable, read_paper_table
from eai.results.plots import LINES, MUTED, RULE, clip_label, draw_line, make_figure
from eai.results.rate import rate_of
from eai.results.record import Record
from eai.results.runs import RunKey, count_errors_as_paper
from eai.results.summary import cases_of, keep_attempts, outcome_of, share_of
from eai.results.table import Estimate, Row, Table, make_table
from eai.studies.records import Records, by_place
from eai.studies.study import Analysis, Figures, Study, of_run, paper_remarks
from eai.studies.variation import Variation
from eai.tasks.options import Options
from eai.world.fault import FaultKind, Notice

if TYPE_CHECKING:
    from matplotlib.figure import Figure


SUCCESS, EXECUTION = "task_success", "execution_success"
_ERRORS = tuple([column.metric for column in COLUMNS if column.group in (GRAMMAR, RUNTIME)])
_RIGHT = (AnswerOutcome.SUCCESS, AnswerOutcome.EXCLUDED, AnswerOutcome.NOT_ANSWERED)


@dataclass(frozen=True, slots=True)
class _Arm:
    """One way to ask again, under one or several seeds of slips.

    Attributes:
        experiment: what it is, without the seed.
        runs: the records under each seed, by seed.
    """

    experiment: Experiment
    runs: Mapping[int | None, Sequence[Record]]

    @property
    def options(self) -> AttemptOptions:
        """The options of its attempts."""
        return AttemptOptions.from_experiment(self.experiment) or AttemptOptions()

    @property
    def name(self) -> str:
        """Its label, in which there is no seed."""
        return self.experiment.label

    @property
    def attempts(self) -> int:
        """How many a task may have."""
        return self.options.replans + 1

    @property
    def control(self) -> Experiment:
        """The same without a word."""
        return self.experiment.replace_choices(
            replace(self.options, feedback="none", form="prompt").experiment
        )

    def records(self, attempts: int) -> list[Record]:
        """Those of all seeds, as they would be after so many attempts."""
        return [keep_attempts(record, attempts) for records in self.runs.values() for record in records]

    def cases(self, metric: str, attempts: int) -> list[Case]:
        """The cases that tasks add to a metric after so many attempts, one seed after the other."""
        return [case for records in self.runs.values() for case in _cases(records, metric, attempts)]


def _cases(records: Sequence[Record], metric: str, attempts: int) -> list[Case]:
    """The cases that a run adds to a metric after so many attempts."""
    stopped = [keep_attempts(record, attempts) for record in records]
    return cases_of(stopped, stopped[0].ability).get(metric, [])


def arms_of(runs: Sequence[Sequence[Record]]) -> list[_Arm]:
    """The arms of some runs of one model and suite, those without feedback first; other runs are none."""
    found = group_pairs(
        (
            experiment.replace_choices(replace(options, slip_seed=None).experiment),
            (options.slip_seed, records),
        )
        for records in runs
        if (experiment := records[0].experiment) is not None
        and (options := AttemptOptions.from_experiment(experiment)) is not None
    )
    arms = [
        _Arm(experiment, dict(sorted(by_seed, key=lambda each: str(each[0]))))
        for experiment, by_seed in found.items()
    ]
    order = [*get_args(FeedbackLevel)]
    return sorted(arms, key=lambda arm: (arm.options.slip, order.index(arm.options.feedback), arm.name))


def tables(arms: Sequence[_Arm]) -> list[Table]:
    """All tables."""
    return [_by_attempt(arms), _worth(arms), _mended(arms)]


def remarks(arms: Sequence[_Arm]) -> list[str]:
    """Remarks for readers: which arms have no control, and which were run once."""
    known = {arm.experiment for arm in arms}
    alone = [arm.name for arm in arms if arm.attempts > 1 and arm.control not in known]
    found = []
    if alone:
        found.append(
            f"No resampling arm stands beside {', '.join(alone)}: what feedback is worth is not known. "
            "`eai run` with the same options and `attempts.feedback=none` makes it."
        )
    once = [arm.name for arm in arms if arm.options.slip and len(arm.runs) == 1]
    if once:
        found.append(
            f"One seed of slips: {', '.join(once)}. Its intervals are of other tasks, not of other luck; run "
            "more with `attempts.slip_seed`."
        )
    return found


def success_by_attempt(arm: _Arm) -> list[Estimate]:
    """Task success after 1, 2, ... attempts."""
    return [Estimate.from_cases(arm.cases(SUCCESS, number)) for number in range(1, arm.attempts + 1)]


@make_table(
    "attempts",
    (
        *("arm", "attempts", "seeds", "task success", "execution success"),
        *(kind.replace("_", " ") for kind in _ERRORS),
        *("slip", "attempts used", "tokens"),
    ),
)
def _by_attempt(arms: Sequence[_Arm]) -> Iterator[Row]:
    """By the number of attempts.

    What each arm would have come to after so many attempts, in percent, with 95 % intervals whose units are
    the names of tasks. Errors are those of the last attempt made; a slip is no error of the model's. Success
    cannot fall, since a success ends the attempts: a rise from one row to the next is no finding by itself.
    Attempts used and tokens are means a task, up to that attempt.
    """
    for arm, number in ((each, number) for each in arms for number in range(1, each.attempts + 1)):
        records = [record for record in arm.records(number) if record.verdict.excluded is None]
        slipped = [r.verdict.error is not None and r.verdict.error.kind is FaultKind.SLIP for r in records]
        cases = [arm.cases(metric, number) for metric in _ERRORS]
        errors = [rate_of(case.share for case in each).percent for each in cases]
        tokens = [
            sum([each.usage.tokens or 0 for each in record.attempts if each.usage]) for record in records
        ]
        yield (
            arm.name,
            number,
            len(arm.runs),
            Estimate.from_cases(arm.cases(SUCCESS, number)),
            Estimate.from_cases(arm.cases(EXECUTION, number)),
            *errors,
            share_of(records, slipped).value,
            fmean([len(record.attempts) for record in records]) if records else None,
            fmean(tokens) if any(tokens) else None,
        )


@make_table(
    "worth",
    ("arm", "attempts", "told nothing", "with feedback", "difference"),
    title="What feedback is worth",
)
def _worth(arms: Sequence[_Arm]) -> Iterator[Row]:
    """Each arm with feedback beside the one without.

    Task success of the resampling arm, told nothing, and of an arm with feedback, on the same tasks and seeds
    after as many attempts; the difference is in points. In the first attempt both ask the same: what differs
    there is chance, and shows how much of it there is.
    """
    controls = {arm.experiment: arm for arm in arms if arm.options.feedback == "none"}
    for arm in arms:
        control = controls.get(arm.control)
        if control is None or control is arm:
            continue
        for number in range(1, arm.attempts + 1):
            one, other = _shared(control, arm, number)
            estimates = (
                Estimate.from_cases(one),
                Estimate.from_cases(other),
                Estimate.from_difference(one, other),
            )
            yield (arm.name, number, *estimates)


@make_table(
    "mended",
    ("arm", "first answer", "tasks", "mended", "same", "another"),
    title="What became of first answers that failed",
)
def _mended(arms: Sequence[_Arm]) -> Iterator[Row]:
    """The outcomes of tasks by that of the first answer.

    Tasks by what ended the first answer: how many were solved in the end, in percent, how many ended in the
    same way, and how many in another. What the resampling arm mends is chance.
    """
    for arm in arms:
        by_kind = group_pairs(
            (outcome_of(keep_attempts(record, 1)), record) for record in arm.records(arm.attempts)
        )
        for kind in [kind for kind in AnswerOutcome if kind in by_kind and kind not in _RIGHT]:
            ended = Counter(outcome_of(record) for record in by_kind[kind])
            mended = [outcome_of(record) is AnswerOutcome.SUCCESS for record in by_kind[kind]]
            same, tried = ended[kind], len(mended)
            other = tried - same - ended[AnswerOutcome.SUCCESS]
            label = kind.value.replace("_", " ")
            yield (arm.name, label, tried, share_of(by_kind[kind], mended), same, other)


def _shared(control: _Arm, arm: _Arm, attempts: int) -> tuple[list[Case], list[Case]]:
    """The cases of tasks that both have under a seed, in the same order."""
    pairs: list[tuple[Case, Case]] = []
    for seed in [seed for seed in arm.runs if seed in control.runs]:
        before = {case.task: case for case in _cases(control.runs[seed], SUCCESS, attempts)}
        after_it = _cases(arm.runs[seed], SUCCESS, attempts)
        pairs += [(before[case.task], case) for case in after_it if case.task in before]
    return [one for one, _ in pairs], [other for _, other in pairs]


_PAPER = ("replanning", "replanning_prose", "replanning_stochastic")
_FIGURES = ("task_success", "execution_success", "missing_step", "additional_step")
_SHOWN = (
    *("arm", "attempts", "task success", "execution success"),
    *("told nothing", "with feedback", "difference"),
)
"""The columns that are shown on the screen."""


class _Attempts(Variation):
    """How often plans are tried, and how reliable actions are.

    Raises:
        InputError: choices contradict each other.

    Attributes:
        replans: Further attempts at a task that fails.
        world: Where further attempts begin: restart (in the initial state), or continue (where the one before
            ended).
        feedback: What a model is told of failures: explained (if not given), kind, state, or none: the same
            question.
        feedback_form: Where it is told: prompt (at the end of the question), or chat (as turns of a
            conversation).
        slip: The probability that a possible action does not work.
        slip_seed: The seed of the slips.
        slip_notice: Whether a slip is noticed: detected, or silent.
        until: An attempt ends with its plan (done), or in the first state with all goals (goal; if not given,
            where the world continues).
        preset: A protocol: slips as its published script has them, three replans, the state told.
    """

    replans: int = Field(default=0, ge=0)
    world: AttemptStart = "restart"
    feedback: FeedbackLevel | None = None
    feedback_form: FeedbackForm = "prompt"
    slip: float = Field(default=0.0, ge=0, le=1)
    slip_seed: int = 0
    slip_notice: Notice = "detected"
    until: EndCondition | None = None
    preset: str = ""

    @model_validator(mode="after")
    def _without_contradictions(self) -> Self:
        _ = self.attempts
        return self

    @property
    def choice(self) -> str:
        """Several attempts, or actions that fail."""
        return "attempts.replans, slip or until" if self.attempts else ""

    @property
    def heading(self) -> str:
        """The label of the attempts."""
        return self.attempts.label if self.attempts else ""

    def abilities(self, named: Collection[Ability]) -> list[Ability]:
        """Action sequencing.

        Raises:
            InputError: another ability is named.
        """
        for each in named:
            if each is not Ability.ACTION_SEQUENCING:
                raise InputError(f"--ability {each.value}: only plans are carried out, attempt by attempt")
        return [Ability.ACTION_SEQUENCING]

    @property
    def attempts(self) -> AttemptOptions | None:
        """The attempts, in which choices that do not matter are as in a plain run; None for a plain run.

        Feedback explains, and an attempt in a world that continues ends with the goal, where nothing is
        chosen.
        """
        scripted = preset_attempts(self.preset, self.slip, self.slip_seed, self.replans)
        if scripted is not None:
            return scripted
        feedback = self.feedback or ("explained" if self.replans else "none")
        if feedback != "none" and not self.replans:
            raise InputError(f"attempts.feedback {feedback}: there is none without attempts.replans")
        continues = self.world == "continue" and bool(self.replans)
        options = AttemptOptions(
            self.replans,
            "continue" if continues else "restart",
            feedback,
            "prompt" if feedback == "none" else self.feedback_form,
            self.slip,
            self.slip_seed if self.slip else None,
            self.slip_notice if self.slip else "detected",
            self.until or ("goal" if continues else "done"),
        )
        return options if options.uses_episodes else None

    def recorded(self, study: str) -> StudyChoice | None:
        """Return the attempts as records have them."""
        return None if self.attempts is None else self.attempts.experiment.study[study]


class _Choices(Options):
    """How attempts are counted.

    Attributes:
        published_counts: Count as the published script did: an error only where the last attempt was used up.
    """

    published_counts: bool = False


def _analyze(records: Records, chosen: _Choices) -> Iterator[Analysis]:
    """Runs of one model, domain, ability and protocol belong together.

    Those are the runs with feedback, and the one with attempts.feedback=none, without which nobody knows what
    feedback is worth.

    Raises:
        InputError: there are no such runs.
    """
    acting = (run for run in records.runs() if AttemptOptions.from_experiment(run.key.experiment) is not None)
    groups = list(by_place(acting).values())
    if not groups:
        raise InputError(
            "expected records of replanning or slips, found none; eai run --with attempts.replans=3 does"
        )
    for group in groups:
        key = group[0].key
        place = f"{key.domain}-{key.protocol.value}-{to_file_name(key.model)}"
        counted = map(count_errors_as_paper, group) if chosen.published_counts else group
        arms = arms_of([run.records for run in counted])
        made, notes = _tables(arms, key)
        first = replace(made[0], title=f"{key.model}, {key.domain}, protocol {key.protocol.value}")
        yield Analysis(
            made,
            _figures(arms, key),
            [*remarks(arms), *notes],
            place if len(groups) > 1 else "",
            [first.select(_SHOWN), made[1].select(_SHOWN)],
        )


def _tables(arms: Sequence[_Arm], key: RunKey) -> tuple[list[Table], list[str]]:
    """The tables, the paper's among them, and what must be said of that."""
    papers = [
        paper for paper in map(read_paper_table, _PAPER) if any(c.domain == key.domain for c in paper.columns)
    ]
    if not papers:
        return tables(arms), []
    return [*tables(arms), _paper(papers, key.domain)], paper_remarks(papers, key.protocol)


def _figures(arms: Sequence[_Arm], key: RunKey) -> Figures:
    yield of_run(key, "success_by_attempt", draw(arms))


@make_table("paper", ("table", "model", *(metric.replace("_", " ") for metric in _FIGURES)))
def _paper(papers: Sequence[PaperTable], domain: str) -> Iterator[Row]:
    """The paper's figures.

    Percent, as printed. Read the notes at the head of this page before comparing them.
    """
    for paper in papers:
        columns = {column.metric: column for column in paper.columns if column.domain == domain}
        for name in paper.rows:
            figures = [paper.figure(name, columns[m]) if m in columns else None for m in _FIGURES]
            yield (paper.title, name, *figures)


_SIZE = (3.5, 2.8)
"""A column of a page, in inches."""
_LEGEND_ROW = 0.17
_APART = 0.05
"""How far arms stand beside each other, so that their intervals can be distinguished."""


def draw(arms: Sequence[_Arm]) -> Figure | None:
    """Success with its 95 % intervals; None if no task had more than one attempt."""
    shown = [arm for arm in arms if arm.attempts > 1]
    if not shown:
        return None
    figure = make_figure(_SIZE[0], _SIZE[1] + _LEGEND_ROW * len(shown))
    panel = figure.subplots()
    for number, arm in enumerate(shown):
        estimates = success_by_attempt(arm)
        places = [k + _APART * (number - (len(shown) - 1) / 2) for k in range(1, arm.attempts + 1)]
        has_feedback = arm.options.feedback != "none"
        color, style = (LINES[number % len(LINES)], "o-") if has_feedback else (MUTED, "o--")
        label = f"{clip_label(arm.name)}, n = {estimates[0].denominator:,.0f}"
        draw_line(panel, places, estimates, color, style, label=label)
    ticks = range(1, max(arm.attempts for arm in shown) + 1)
    panel.set(xlabel="attempts", xticks=ticks, ylabel="task success in percent", ylim=(0, 100))
    panel.grid(axis="y", color=RULE, linewidth=0.6)
    figure.legend(loc="outside lower center", ncols=1, frameon=False, fontsize=7)
    return figure


REPLANNING = Study(
    "replanning",
    "Replanning and actions that fail (action sequencing).",
    _Attempts,
    section="attempts",
    choices=_Choices,
    analyze=_analyze,
)
