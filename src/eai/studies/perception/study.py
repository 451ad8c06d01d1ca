"""Perception: how questions show the scene, and what errors in the perceived scene cost.

Errors are told by their number, their kind and the facts lost. The horizontal axis is always the realised
rate, counted in what was perceived, never what a channel was asked for and never the outcome. Tasks recur in
runs, and near copies in tasks; the unit of every interval is the name of the task. The cost of errors stands
beside the same tasks without any, where there is such a run.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeAlias

from eai.base.errors import InputError
from eai.base.files import to_file_name
from eai.base.grouping import group_pairs
from eai.results.certainty import Case, Cases
from eai.results.codec import read_summary
from eai.results.plots import ACCENT, COLUMN, MUTED, RULE, make_figure
from eai.results.plots import denominator_of as tasks_in
from eai.results.rate import Rate
from eai.results.record import Record
from eai.results.summary import cases_of
from eai.results.table import Estimate, Row, Table, make_table
from eai.studies.perception.choice import STUDY, Perception
from eai.studies.perception.declaration import perception_shares
from eai.studies.perception.steps import mean_steps
from eai.studies.perception.verdict import Perceived
from eai.studies.records import Records, by_place
from eai.studies.study import Analysis, Figures, Study, metric_of, of_run
from eai.studies.variation import Ask, Stage
from eai.tasks.options import Options
from eai.tasks.share import Share

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from eai.base.json_value import Json
    from eai.benchmarks.prompt_library import Library
    from eai.benchmarks.suite import Suite
    from eai.results.runs import RunKey


class _StagedPerception(Perception):
    """How the questions of a run show the scene: the choice, and the stage that finds the scenes."""

    def stage(self, library: Library, wanted: Mapping[str, Collection[str]], ask: Ask) -> Stage:
        """Return the stage that finds the scenes, whose modules are imported only by a run."""
        from eai.studies.perception.scenes import scenes

        return Stage(library, wanted, ask, partial(scenes, self))


PLAIN = "text"
"""The name of a run whose questions tell of the scene as it is."""

BOUNDS = (0, 5, 10, 20, 40, 100)
"""The upper bounds of the groups of predicate error rates, in percent."""

_NONE_SEEN = "expected records that say what was perceived; eai run --with perception.scene=noisy does"

_RATES = ("predicate_error", "missing", "misplaced", "unnecessary", "object_error", "unseen")
_LAST = 1000.0
_COSTS = ("cases", "value", "without_errors", "cost")


@dataclass(frozen=True, slots=True)
class _Seen:
    """One task in one run: what was perceived, and what the answer adds to the metric."""

    perceived: Perceived
    case: Case

    @property
    def rate(self) -> float:
        """The predicate error rate in percent; 0 where nothing is described."""
        return Rate(*perception_shares(self.perceived)["predicate_error"]).percent or 0.0

    @property
    def kinds(self) -> frozenset[str]:
        """The kinds of error in it; that facts about unseen objects are missing is no kind of its own."""
        counts = {
            "missing": 0 if self.perceived.unseen else self.perceived.missing,
            "misplaced": self.perceived.misplaced,
            "unnecessary": self.perceived.unnecessary,
            "object hallucination": self.perceived.invented_names,
            "unseen object": self.perceived.unseen,
        }
        return frozenset([kind for kind, count in counts.items() if count])

    @property
    def lost(self) -> frozenset[str]:
        """The predicates of which described facts are lost or misplaced."""
        return frozenset([name for name, counts in self.perceived.predicates.items() if counts[2]])

    def with_share(self, share: Share) -> Case:
        """The case of the task in another rate."""
        return self.case._replace(share=share)


Group: TypeAlias = Sequence[_Seen]


@dataclass(frozen=True)
class _Runs:
    """The runs of one model on one suite that show the scene in several ways.

    Attributes:
        metric: one of the ability's.
        runs: the records of each way, by its name; `PLAIN` among them, where there is such a run.
    """

    metric: str
    runs: dict[str, Sequence[Record]]

    @cached_property
    def seen(self) -> list[_Seen]:
        """All tasks in all runs of which it is known what was perceived."""
        return [each for name in self.runs for each in self.of_run(name)]

    def of_run(self, name: str) -> list[_Seen]:
        """The tasks of a run of which it is known what was perceived."""
        cases = {case.task: case for case in self.cases(name)}
        return [
            _Seen(perceived, cases[record.task_id])
            for record in self.runs[name]
            if (perceived := read_summary(record, STUDY, Perceived)) is not None and record.task_id in cases
        ]

    def cases(self, name: str) -> Cases:
        """The cases that the tasks of a run add to the metric."""
        records = self.runs[name]
        return cases_of(records, records[0].ability).get(self.metric, ())

    @cached_property
    def plain(self) -> dict[str, Case]:
        """The case of each task where the question shows the scene as it is."""
        return {case.task: case for case in self.cases(PLAIN)} if PLAIN in self.runs else {}

    def costs(self, group: Group) -> Row:
        """The cells on a group of cases: `_COSTS`."""
        cases = [each.case for each in group]
        without = [self.plain[case.task] for case in cases if case.task in self.plain]
        if not without or len(without) < len(cases):
            return (len(cases), Estimate.from_cases(cases), Estimate(None), Estimate(None))
        cost = Estimate.from_difference(cases, without)
        return (len(cases), Estimate.from_cases(cases), Estimate.from_cases(without), cost)


def perception_tables(runs: Sequence[Sequence[Record]], metric: str) -> list[Table]:
    """The tables of the runs of one model and suite.

    Args:
        runs: the records of each.
        metric: one of the ability's.

    Raises:
        InputError: none of the runs says what was perceived.
    """
    found = _Runs(metric, {_name(records): records for records in runs})
    if not found.seen:
        raise InputError(_NONE_SEEN)
    return [_by_run(found), _by_rate(found), _by_kind(found), _by_predicate(found)]


def _name(records: Sequence[Record]) -> str:
    part = records[0].study.get(STUDY)
    return PLAIN if part is None else str(part.options["scene"])


@make_table("perception_runs", ("scene", *_RATES, "steps", "value"))
def _by_run(runs: _Runs) -> Iterator[Row]:
    """{runs.metric} by how the scene is shown.

    A row a run: realised error rates in percent, then {runs.metric}. `predicate_error`: facts missing or
    misplaced, of those described; `object_error`: names that the scene has not, of all names; `missing`,
    `misplaced`, `unnecessary`: facts of these kinds, of those described, of described relations, of perceived
    ones; `unseen`: objects not named, of all. Empty where a question does not tell of a scene graph. Sorted
    by `predicate_error`.
    """
    rates = {name: _rates(runs.of_run(name)) for name in runs.runs}
    places = {name: -1.0 if each[0].value is None else each[0].value for name, each in rates.items()}
    for name in sorted(rates, key=lambda name: (places[name], name)):
        yield (name, *rates[name], mean_steps(runs.runs[name]), Estimate.from_cases(runs.cases(name)))


def _rates(seen: Group) -> list[Estimate]:
    """The error rates of a run; their intervals are of tasks that differ in how much can be missed."""
    if not seen:
        return [Estimate(None)] * len(_RATES)
    shares = [(each, perception_shares(each.perceived)) for each in seen]
    return [
        Estimate.from_cases([each.with_share(of_task[name]) for each, of_task in shares]) for name in _RATES
    ]


@make_table("perception_rates", ("above", "up_to", *_COSTS))
def _by_rate(runs: _Runs) -> Iterator[Row]:
    """{runs.metric} by predicate error rate.

    A row a group of answers, of all runs, by the predicate error rate of their own scene graph: 0, or above
    the first bound up to the second, in percent. Tasks of few facts are more often in the outer groups:
    `without_errors` is {runs.metric} of the same tasks told as they are, and `cost` the difference in
    percentage points. `cases` counts a task once for each run. The group of 0 may have unnecessary facts and
    unseen objects that nothing is said of.
    """
    for low, high in [(0.0, 0.0), *pairwise(BOUNDS)]:
        group = [each for each in runs.seen if each.rate == high == 0 or low < each.rate <= high]
        if group:
            yield (low, high, *runs.costs(group))


@make_table("perception_kinds", ("kind", *_COSTS))
def _by_kind(runs: _Runs) -> Iterator[Row]:
    """{runs.metric} by kind of error.

    A row of answers whose scene graphs have errors of this kind and no other, however many. That facts about
    an unseen object are missing belongs to `unseen object`.
    """
    kinds = sorted({kind for each in runs.seen for kind in each.kinds})
    groups = {"none": [each for each in runs.seen if not each.kinds]}
    groups |= {kind: [each for each in runs.seen if each.kinds == {kind}] for kind in kinds}
    groups["several"] = [each for each in runs.seen if len(each.kinds) > 1]
    yield from [(kind, *runs.costs(group)) for kind, group in groups.items() if group]


@make_table("perception_predicates", ("predicate", "lost", "all_cases", *_COSTS))
def _by_predicate(runs: _Runs) -> Iterable[Row]:
    """Which facts cost most when they are lost.

    A row a predicate: of its described facts how many were lost or misplaced (`lost`, in percent), then
    {runs.metric} of the answers in which facts of this predicate and of no other are lost, and nothing else
    is wrong. `all_cases`: answers in which such facts are lost, whatever else is. Sorted by cost.
    """
    names = sorted({name for each in runs.seen for name in each.lost})
    return sorted([_predicate_row(name, runs) for name in names], key=_by_cost)


def _predicate_row(name: str, runs: _Runs) -> Row:
    having = [each for each in runs.seen if name in each.perceived.predicates]
    lost = [each for each in having if name in each.lost]
    alone = [each for each in lost if each.lost == {name} and each.kinds <= {"missing", "misplaced"}]
    counts = [each.perceived.predicates[name] for each in having]
    shares = [Share(gone, right + gone) for right, _, gone in counts]
    lost_share = Estimate.from_cases(
        [each.with_share(share) for each, share in zip(having, shares, strict=True)]
    )
    return (name, lost_share, len(lost), *runs.costs(alone))


def _by_cost(row: Row) -> tuple[float, str]:
    """The costliest first; then by value, where there is nothing to compare with; without any case last."""
    for place, sign in ((6, -1), (4, 1)):
        cell = row[place]
        if isinstance(cell, Estimate) and cell.value is not None:
            return (sign * cell.value, str(row[0]))
    return (_LAST, str(row[0]))


class _Choices(Options):
    """How runs are compared.

    Attributes:
        metric: Which metric of the ability's main table; its first if not given.
    """

    metric: str | None = None


def _analyze(records: Records, chosen: _Choices) -> Iterator[Analysis]:
    """Runs of one model, domain, ability and protocol belong together.

    A plain run among them, with the same prompts (--set eai), says what the tasks come to without errors.

    Raises:
        InputError: there are none that say what was perceived.
    """
    groups = [
        (label, group)
        for runs in by_place(records.runs()).values()
        for label, group in group_pairs((_besides(run.key), run) for run in runs).items()
        if any(STUDY in record.summaries for run in group for record in run.records)
    ]
    if not groups:
        raise InputError(_NONE_SEEN)
    for label, group in groups:
        key = group[0].key
        metric = metric_of(key.ability, chosen.metric)
        tables = perception_tables([run.records for run in group], metric)
        folder = f"{key.suite.file_name}-{to_file_name(label)}" if len(groups) > 1 else ""
        yield Analysis(tables, _figures(tables[0], metric, key._replace(model=label)), folder=folder)


def _besides(key: RunKey) -> str:
    """The name of a run without how it shows the scene: runs of one name are compared."""
    rest = None if key.experiment is None else key.experiment.drop_study(STUDY)
    return key._replace(experiment=rest).name


def _figures(by_run: Table, metric: str, key: RunKey) -> Figures:
    yield of_run(key, "success_by_error_rate", draw(by_run, metric))


def draw(by_run: Table, metric: str) -> Figure | None:
    """The points of all runs of which it is known what was perceived; the plain run is at 0, hollow."""
    figure = make_figure(COLUMN, 2.6)
    panel = figure.subplots()
    cases = set[int]()
    for row in by_run.rows:
        rate, value = row[1], row[-1]
        if not isinstance(rate, Estimate) or not isinstance(value, Estimate) or value.value is None:
            continue
        is_seen = rate.value is not None
        if not is_seen and row[0] != PLAIN:
            continue
        cases.add(tasks_in(value))
        place, color = rate.value or 0.0, ACCENT if is_seen else MUTED
        if value.low is not None and value.high is not None:
            panel.vlines(place, value.low, value.high, color=color, linewidth=1.0)
        if rate.low is not None and rate.high is not None:
            panel.hlines(value.value, rate.low, rate.high, color=color, linewidth=0.7)
        fill = color if is_seen else "white"
        panel.plot(place, value.value, "o", color=color, markerfacecolor=fill, markersize=4, zorder=3)
    of = " to ".join(f"{number:,}" for number in sorted({min(cases), max(cases)})) if cases else "0"
    panel.set(xlabel=f"facts missing or misplaced, percent (n = {of})", ylim=(0, 102), xlim=(-2, None))
    panel.set_ylabel(f"{metric.replace('_', ' ')} in percent")
    panel.grid(axis="y", color=RULE, linewidth=0.6)
    return figure


def _summarize(record: Record, suite: Suite, about: Mapping[str, Any]) -> Mapping[str, Json]:
    """Return the errors of the scene graph that a question stated."""
    from eai.studies.perception.scene_graph import SCENE
    from eai.studies.perception.scenes import listed_scenes

    if SCENE not in about:
        return {}
    scenes = {record.task_id: about[SCENE]}
    believed = listed_scenes(record.study[STUDY].options["scene"], suite, scenes)
    return believed.summaries[record.task_id][STUDY]


PERCEPTION = Study(
    STUDY,
    "How questions show the scene (with prompts.set eai).",
    _StagedPerception,
    choices=_Choices,
    analyze=_analyze,
    summarize=_summarize,
)
