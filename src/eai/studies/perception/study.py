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
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

from pydantic import BeforeValidator, Field, model_validator
from typing_extensions import Self

from eai.abilities.options import Arguments, Options
from eai.abilities.protocol import Ability
from eai.abilities.record import Perceived, Record
from eai.abilities.responses import file_name
from eai.abilities.verdict import Share
from eai.data.grouping import grouped
from eai.errors import InputError
from eai.pictures.picture import Clutter
from eai.results.certainty import Case, Cases
from eai.results.plots import ACCENT, COLUMN, MUTED, RULE, sheet
from eai.results.plots import cases_of as tasks_in
from eai.results.rate import Rate
from eai.results.summary import cases_of
from eai.results.table import Estimate, Row, Table, table_of
from eai.studies.perception.declaration import perception_shares
from eai.studies.perception.noise import Noise, noise_of
from eai.studies.perception.steps import mean_steps
from eai.studies.records import Records, by_place
from eai.studies.study import Analysis, Figures, Study, metric_of, of_run
from eai.studies.variation import Ask, Stage, Variation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from eai.benchmark.prompt_library import Library
    from eai.scoring.runs import RunKey


_NAME = "perception"


Showing: TypeAlias = Literal["text", "image", "both", "predicted", "noisy", "rendered", "numbered", "pointed"]
"""How a question shows the scene (paper, appendix on vision models: experiments 0, 1, 2 and 5).

``text``: as a list of what holds. ``image``: in pictures alone. ``both``: in both. ``predicted``: as the list
that a second model made from pictures. ``noisy``: as a list with seeded errors. Ours are ``rendered``: in
pictures of things with bodies; ``numbered``: in these, with a number at each thing; and ``pointed``: in these
as they are, and a pixel of each thing with its name.
"""

PICTURED = ("image", "rendered", "numbered", "pointed")
"""The ways to show it in pictures alone."""


def _noise(given: object) -> object:
    """Noise as a table of rates, or as texts such as ``missing=0.1``."""
    if isinstance(given, Mapping):
        given = [f"{name}={rate}" for name, rate in given.items()]
    elif isinstance(given, str):
        given = [given]
    return noise_of([str(each) for each in given]) if isinstance(given, list | tuple) else given


class Perception(Variation):
    """How the questions of a run show the scene.

    Raises:
        InputError: it makes no sense; the message names the option.

    Attributes:
        scene: How questions show the scene: text, image, both, predicted (as a second model lists it), noisy
            (with seeded errors), rendered (with bodies), numbered (with a number at each thing) or pointed
            (with a pixel of each thing).
        context: How much else a list of facts tells of the scene, with text or both: none, some or many other
            objects, and states that do not hold.
        images: A folder with pictures of your own: files that begin with the id of their task. Schematic ones
            if not given.
        clutter: How much else is in schematic pictures: none, some or many.
        noise: The rates of errors in a noisy scene, such as noise.missing=0.1: missing, misplaced,
            unnecessary, invented, unseen; and noise.seed.
        scene_model: The model that lists a predicted scene from pictures; eai/captioner: built in, errs now
            and then.
        scene_args: Arguments of that model, such as scene_args.rate=0.2.
        scene_base_url: The address of its server.
    """

    scene: Showing = "text"
    context: Clutter | None = None
    images: Path | None = None
    clutter: Clutter | None = None
    noise: Annotated[Noise | None, BeforeValidator(_noise)] = None
    scene_model: str | None = None
    scene_args: Arguments = Field(default={})
    scene_base_url: str | None = None

    @model_validator(mode="after")
    def _without_contradictions(self) -> Self:
        how = f"perception.scene {self.scene}"
        pictured = self.scene in ("image", "both", "predicted")
        for name, given, fits in (
            ("context", self.context, self.scene in ("text", "both")),
            ("images", self.images, pictured),
            ("clutter", self.clutter, pictured),
            ("scene_model", self.scene_model, self.scene == "predicted"),
            ("noise", self.noise, self.scene == "noisy"),
        ):
            if given is not None and not fits:
                raise InputError(f"perception.{name}: means nothing with {how}")
        if self.images is not None and self.clutter is not None:
            raise InputError("perception.clutter: is of schematic pictures, not of perception.images")
        if self.scene == "predicted" and self.scene_model is None:
            raise InputError(f"{how}: expected perception.scene_model, who sees; eai/captioner is built in")
        if self.scene == "noisy" and self.noise is None:
            raise InputError(f"{how}: expected rates of errors, such as perception.noise.missing=0.1")
        if self.scene_model is None and (self.scene_args or self.scene_base_url is not None):
            raise InputError("perception.scene_args, scene_base_url: expected perception.scene_model")
        return self

    @property
    def choice(self) -> str:
        """The scene, if questions do not list it as it is, or the context that they tell besides."""
        if self.scene != "text":
            return f"perception.scene {self.scene}"
        return f"perception.context {self.context}" if self._context else ""

    @property
    def heading(self) -> str:
        """How the scene is shown."""
        return f"scene: {self.label}"

    @property
    def captioner(self) -> str | None:
        """The model that lists a predicted scene."""
        return self.scene_model

    @property
    def states(self) -> Literal["", "scene", "goals"]:
        """The scene."""
        return "scene"

    def contradiction(self, other: Variation) -> str:
        """Return why scenes cannot be shown so in the other study, whose world may change."""
        acted = other.experiment
        if acted is not None and acted.world == "continue" and acted.feedback != "none":
            if not self.can_look_again:
                return "the scene is seen at the start alone, and feedback tells of a world that has changed"
            if self.scene in ("image", "both") and acted.form == "chat":
                return "pictures of a world that has changed have no place in a chat"
        return super().contradiction(other)

    @property
    def can_look_again(self) -> bool:
        """Whether a scene that has changed can be shown: no model and no files of the user's show it."""
        return self.scene in ("text", "noisy", "image", "both") and self.images is None

    def abilities(self, named: Collection[Ability]) -> list[Ability]:
        """Those whose questions tell of a scene.

        Raises:
            InputError: those of one that is named tell of none.
        """
        from eai.studies.perception.scenes import scene_abilities

        return scene_abilities(named, self.scene)

    def stage(self, library: Library, wanted: Mapping[str, Collection[str]], ask: Ask) -> Stage:
        """The scenes."""
        from eai.studies.perception.scenes import scenes

        return Stage(library, wanted, ask, partial(scenes, self))

    @property
    def label(self) -> str:
        """A short text that tells it from other ways to show the scene."""
        if self.noise is not None:
            return f"{self.scene}-{self.noise.label}"
        who = "" if self.scene_model is None else f"-{file_name(self.scene_model)}"
        return f"{self.scene}{who}{self._pictures}{self._context}"

    def of_pictures(self) -> Self:
        """The way to show the same pictures alone, as a captioner sees them."""
        return type(self)(scene="image", images=self.images, clutter=self.clutter)

    @property
    def _context(self) -> str:
        """A short text that tells how much else is told."""
        return "" if self.context in (None, "none") else f"-context-{self.context}"

    @property
    def _pictures(self) -> str:
        """A short text that tells its pictures from others."""
        if self.images is not None:
            return "-own"
        return "" if self.clutter in (None, "none") else f"-{self.clutter}"


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
            _Seen(record.perceived, cases[record.task_id])
            for record in self.runs[name]
            if record.perceived is not None and record.task_id in cases
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
            return (len(cases), Estimate.of(cases), Estimate(None), Estimate(None))
        cost = Estimate.of_difference(cases, without)
        return (len(cases), Estimate.of(cases), Estimate.of(without), cost)


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
    experiment = records[0].experiment
    return PLAIN if experiment is None or experiment.scene is None else experiment.scene


@table_of("perception_runs", ("scene", *_RATES, "steps", "value"))
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
        yield (name, *rates[name], mean_steps(runs.runs[name]), Estimate.of(runs.cases(name)))


def _rates(seen: Group) -> list[Estimate]:
    """The error rates of a run; their intervals are of tasks that differ in how much can be missed."""
    if not seen:
        return [Estimate(None)] * len(_RATES)
    shares = [(each, perception_shares(each.perceived)) for each in seen]
    return [Estimate.of([each.with_share(of_task[name]) for each, of_task in shares]) for name in _RATES]


@table_of("perception_rates", ("above", "up_to", *_COSTS))
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


@table_of("perception_kinds", ("kind", *_COSTS))
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


@table_of("perception_predicates", ("predicate", "lost", "all_cases", *_COSTS))
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
    lost_share = Estimate.of([each.with_share(share) for each, share in zip(having, shares, strict=True)])
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
        for label, group in grouped((_besides(run.key), run) for run in runs).items()
        if any(record.perceived for run in group for record in run.records)
    ]
    if not groups:
        raise InputError(_NONE_SEEN)
    for label, group in groups:
        key = group[0].key
        metric = metric_of(key.ability, chosen.metric)
        tables = perception_tables([run.records for run in group], metric)
        folder = f"{key.suite.file_name}-{file_name(label)}" if len(groups) > 1 else ""
        yield Analysis(tables, _figures(tables[0], metric, key._replace(model=label)), folder=folder)


def _besides(key: RunKey) -> str:
    """The name of a run without how it shows the scene: runs of one name are compared."""
    rest = None if key.experiment is None else key.experiment.without("scene")
    return key._replace(experiment=rest).name


def _figures(by_run: Table, metric: str, key: RunKey) -> Figures:
    yield of_run(key, "success_by_error_rate", draw(by_run, metric))


def draw(by_run: Table, metric: str) -> Figure | None:
    """The points of all runs of which it is known what was perceived; the plain run is at 0, hollow."""
    figure = sheet(COLUMN, 2.6)
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


PERCEPTION = Study(
    _NAME,
    "How questions show the scene (with prompts.set eai).",
    Perception,
    choices=_Choices,
    analyze=_analyze,
)
