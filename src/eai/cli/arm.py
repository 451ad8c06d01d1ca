"""The arm of an experiment: what sets runs of ``eai run`` apart from single answers to plain questions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from eai.abilities.experiment import Experiment
from eai.abilities.protocol import Ability
from eai.benchmark.prompt_library import Library
from eai.benchmark.suite import Suite
from eai.cli.first_stage import FirstStage, stage_two
from eai.cli.order import Order, ask_for_scene_graphs, obtain_and_score
from eai.cli.scene_stage import Scenes
from eai.errors import InputError
from eai.prompts.prompt import Prompt
from eai.run.job import Endpoint
from eai.scoring.trials import Trials, open_trials
from eai.studies.perception.showing import Scene, SceneChoice, refuse_besides, scene_abilities


@dataclass(frozen=True, slots=True)
class Arm:
    """How questions are asked and answers carried out, where it is not as in a plain run.

    Attributes:
        experiment: attempts and slips.
        goals: whose interpreted goals the questions state.
        adaptive: until what standard error tasks are chosen.
        scene: how the questions show the scene.
        eyes: the model that sees for others.

    Raises:
        InputError: these cannot be combined.
    """

    experiment: Experiment | None
    goals: str | None
    adaptive: float | None
    scene: SceneChoice
    eyes: Endpoint | None

    def __post_init__(self) -> None:
        if self.goals is not None and self.experiment is not None:
            raise InputError("--goals: not with attempts or slips; feedback would tell the goals of the task")
        if self.adaptive is not None and (self.goals is not None or self.experiment is not None):
            raise InputError(
                "--adaptive: not with --goals, attempts or slips, which make tasks harder or easier"
            )
        besides = {
            "--goals": self.goals,
            "--replans, --slip, --until": self.experiment,
            "--adaptive": self.adaptive,
        }
        refuse_besides(self.scene, besides)

    def wanted(self, abilities: Sequence[Ability] | None) -> list[Ability]:
        """The abilities that are asked for, in order: in an experiment those that it can be made with.

        Raises:
            InputError: one that is named is none of them.
        """
        if self.goals is not None:
            return stage_two(abilities)
        if self.scene.scene is not Scene.TEXT:
            return scene_abilities(abilities, self.scene.scene)
        if self.experiment is None:
            return [each for each in Ability if not abilities or each in abilities]
        for each in abilities or ():
            if each is not Ability.ACTION_SEQUENCING:
                raise InputError(f"--ability {each.value}: only plans are carried out, attempt by attempt")
        return [Ability.ACTION_SEQUENCING]

    def title(self, suite: Suite) -> str:
        """What stands above the results of a suite."""
        title = f"{suite.domain}, {suite.ability.value}, protocol {suite.protocol.value}"
        if self.experiment is not None:
            title += f"\n{self.experiment.label}"
        if self.goals is not None:
            title += f"\ngoals: {self.goals}"
        return title if self.scene.scene is Scene.TEXT else f"{title}\nscene: {self.scene.label}"

    def trials(self, library: Library, suite: Suite, prompts: Mapping[str, Prompt]) -> Trials | None:
        """How answers are carried out, in several attempts or where actions slip."""
        if self.experiment is None:
            return None
        asker = library.asker(suite.benchmark, suite.ability, prompts)
        return open_trials(suite, self.experiment, asker, prompts)

    def first(
        self, library: Library, order: Order, chosen: Sequence[tuple[Suite, Mapping[str, Prompt]]]
    ) -> FirstStage | Scenes | None:
        """What comes before the questions, if anything does: goals are interpreted, or scenes are seen."""
        wanted: dict[str, set[str]] = {}
        for suite, asked in chosen:
            wanted.setdefault(suite.domain, set()).update(asked)
        if self.scene.scene is not Scene.TEXT:
            ask = partial(ask_for_scene_graphs, order)
            return Scenes(self.scene, self.eyes, library, ask, wanted, order.out)
        if self.goals is not None:
            return FirstStage(self.goals, library, partial(obtain_and_score, order), wanted)
        return None
