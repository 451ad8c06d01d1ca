"""Perception: how questions show the scene, as options of the study."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

from pydantic import BeforeValidator, Field, model_validator
from typing_extensions import Self

from eai.abilities.options import Arguments, Options
from eai.abilities.protocol import Ability
from eai.abilities.responses import file_name
from eai.errors import InputError
from eai.pictures.picture import Clutter
from eai.results.plots import ACCENT, COLUMN, MUTED, RULE, cases_of, sheet
from eai.results.table import Estimate
from eai.studies.perception.noise import Noise, noise_of
from eai.studies.study import Analysis, Figures, Study, metric_of, of_run
from eai.studies.variation import Ask, Stage, Variation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from eai.benchmark.prompt_library import Library
    from eai.results.table import Table
    from eai.scoring.runs import RunKey
    from eai.studies.records import Records


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
        """The scene, if questions do not list it as it is."""
        return "" if self.scene == "text" else f"perception.scene {self.scene}"

    @property
    def heading(self) -> str:
        """How the scene is shown."""
        return f"scene: {self.label}"

    @property
    def captioner(self) -> str | None:
        """The model that lists a predicted scene."""
        return self.scene_model

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
        return f"{self.scene}{who}{self._pictures}"

    def of_pictures(self) -> Self:
        """The way to show the same pictures alone, as a captioner sees them."""
        return type(self)(scene="image", images=self.images, clutter=self.clutter)

    @property
    def _pictures(self) -> str:
        """A short text that tells its pictures from others."""
        if self.images is not None:
            return "-own"
        return "" if self.clutter in (None, "none") else f"-{self.clutter}"


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
    from eai.studies.perception.analysis import perception_tables
    from eai.studies.records import by_place

    shown = (run for run in records.runs() if run.key.experiment is None or run.key.experiment.name == _NAME)
    groups = [
        group
        for group in by_place(shown).values()
        if any(record.perceived for run in group for record in run.records)
    ]
    if not groups:
        raise InputError(
            "expected records that say what was perceived; eai run --with perception.scene=noisy does"
        )
    for group in groups:
        key = group[0].key
        metric = metric_of(key.ability, chosen.metric)
        tables = perception_tables([run.records for run in group], metric)
        folder = f"{key.suite.file_name}-{file_name(key.model)}" if len(groups) > 1 else ""
        yield Analysis(tables, _figures(tables[0], metric, key), folder=folder)


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
        if not is_seen and row[0] != "text":
            continue
        cases.add(cases_of(value))
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
