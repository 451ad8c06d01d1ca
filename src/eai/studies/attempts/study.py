"""Replanning and actions that fail: what further attempts are worth, and how much of that is feedback."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from pydantic import Field, model_validator
from typing_extensions import Self

from eai.abilities.experiment import Experiment, Feedback, FeedbackForm, Until, World
from eai.abilities.options import Options
from eai.abilities.protocol import Ability
from eai.abilities.responses import file_name
from eai.benchmark.protocols import preset_experiment
from eai.errors import InputError
from eai.results.paper_tables import PaperTable, paper_table
from eai.results.plots import LINES, MUTED, RULE, clipped, draw_line, sheet
from eai.results.table import Row, Table, table_of
from eai.scoring.runs import RunKey, as_counted_in_paper
from eai.studies.attempts.analysis import Arm, arms_of, remarks, success_by_attempt, tables
from eai.studies.records import Records, by_place
from eai.studies.study import Analysis, Figures, Study, of_run, paper_remarks
from eai.studies.variation import Variation
from eai.world.fault import Notice

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
    world: World = "restart"
    feedback: Feedback | None = None
    feedback_form: FeedbackForm = "prompt"
    slip: float = Field(default=0.0, ge=0, le=1)
    slip_seed: int = 0
    slip_notice: Notice = "detected"
    until: Until | None = None
    preset: str = ""

    @model_validator(mode="after")
    def _without_contradictions(self) -> Self:
        _ = self.experiment
        return self

    @property
    def choice(self) -> str:
        """Several attempts, or actions that fail."""
        return "attempts.replans, slip or until" if self.experiment else ""

    @property
    def heading(self) -> str:
        """The experiment."""
        return self.experiment.label if self.experiment else ""

    def abilities(self, named: Collection[Ability]) -> list[Ability]:
        """Action sequencing.

        Raises:
            InputError: another ability is named.
        """
        if not self.experiment:
            return super().abilities(named)
        for each in named:
            if each is not Ability.ACTION_SEQUENCING:
                raise InputError(f"--ability {each.value}: only plans are carried out, attempt by attempt")
        return [Ability.ACTION_SEQUENCING]

    @property
    def experiment(self) -> Experiment | None:
        """The experiment, in which choices that do not matter are as in a plain run; None for a plain run.

        Feedback explains, and an attempt in a world that continues ends with the goal, where nothing is
        chosen.
        """
        scripted = preset_experiment(self.preset, self.slip, self.slip_seed, self.replans)
        if scripted is not None:
            return scripted
        feedback = self.feedback or ("explained" if self.replans else "none")
        if feedback != "none" and not self.replans:
            raise InputError(f"attempts.feedback {feedback}: there is none without attempts.replans")
        continues = self.world == "continue" and bool(self.replans)
        experiment = Experiment(
            self.replans,
            "continue" if continues else "restart",
            feedback,
            "prompt" if feedback == "none" else self.feedback_form,
            self.slip,
            self.slip_seed if self.slip else None,
            self.slip_notice if self.slip else "detected",
            self.until or ("goal" if continues else "done"),
        )
        return experiment if experiment.acts else None


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
    acting = (run for run in records.runs() if run.key.experiment is not None and run.key.experiment.acts)
    groups = list(by_place(acting).values())
    if not groups:
        raise InputError(
            "expected records of replanning or slips, found none; eai run --with attempts.replans=3 does"
        )
    for group in groups:
        key = group[0].key
        place = f"{key.domain}-{key.protocol.value}-{file_name(key.model)}"
        counted = map(as_counted_in_paper, group) if chosen.published_counts else group
        arms = arms_of([run.records for run in counted])
        made, notes = _tables(arms, key)
        first = replace(made[0], title=f"{key.model}, {key.domain}, protocol {key.protocol.value}")
        yield Analysis(
            made,
            _figures(arms, key),
            [*remarks(arms), *notes],
            place if len(groups) > 1 else "",
            [first.only(_SHOWN), made[1].only(_SHOWN)],
        )


def _tables(arms: Sequence[Arm], key: RunKey) -> tuple[list[Table], list[str]]:
    """The tables, the paper's among them, and what must be said of that."""
    papers = [
        paper for paper in map(paper_table, _PAPER) if any(c.domain == key.domain for c in paper.columns)
    ]
    if not papers:
        return tables(arms), []
    return [*tables(arms), _paper(papers, key.domain)], paper_remarks(papers, key.protocol)


def _figures(arms: Sequence[Arm], key: RunKey) -> Figures:
    yield of_run(key, "success_by_attempt", draw(arms))


@table_of("paper", ("table", "model", *(metric.replace("_", " ") for metric in _FIGURES)))
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


def draw(arms: Sequence[Arm]) -> Figure | None:
    """Success with its 95 % intervals; None if no task had more than one attempt."""
    shown = [arm for arm in arms if arm.attempts > 1]
    if not shown:
        return None
    figure = sheet(_SIZE[0], _SIZE[1] + _LEGEND_ROW * len(shown))
    panel = figure.subplots()
    for number, arm in enumerate(shown):
        estimates = success_by_attempt(arm)
        places = [k + _APART * (number - (len(shown) - 1) / 2) for k in range(1, arm.attempts + 1)]
        has_feedback = arm.experiment.feedback != "none"
        color, style = (LINES[number % len(LINES)], "o-") if has_feedback else (MUTED, "o--")
        label = f"{clipped(arm.name)}, n = {estimates[0].denominator:,.0f}"
        draw_line(panel, places, estimates, color, style, label=label)
    panel.set_xticks(range(1, max(arm.attempts for arm in shown) + 1))
    panel.set_xlabel("attempts")
    panel.set_ylabel("task success in percent")
    panel.set_ylim(0, 100)
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
