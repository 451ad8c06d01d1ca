"""The arm of an experiment: what sets runs of ``eai run`` apart from single answers to plain questions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from eai.abilities.protocol import FOUR, Ability, place_of
from eai.benchmark.prompt_library import Library
from eai.benchmark.suite import Suite
from eai.cli.first_stage import FirstStage, stage_two
from eai.cli.order import Order, obtain_and_score
from eai.cli.scene_stage import Scenes
from eai.errors import InputError
from eai.prompts.prompt import Prompt
from eai.run.spec import RunSpec
from eai.scoring.trials import Trials, open_trials
from eai.studies.attempts.study import Attempts
from eai.studies.perception.scenes import scene_abilities
from eai.studies.perception.study import Perception, Scene
from eai.studies.pipeline.study import Pipeline


@dataclass(frozen=True, slots=True)
class Arm:
    """How questions are asked and answers carried out, where it is not as in a plain run.

    Attributes:
        spec: the specification of the run.
    """

    spec: RunSpec

    def wanted(self, abilities: Sequence[Ability] | None) -> list[Ability]:
        """The abilities that are asked for, in order: in an experiment those that it can be made with.

        Raises:
            InputError: one that is named is none of them.
        """
        scene = self.spec.of(Perception).scene
        if self.spec.of(Pipeline).goals is not None:
            return stage_two(abilities)
        if scene is not Scene.TEXT:
            return scene_abilities(abilities, scene)
        if self.spec.of(Attempts).experiment is None:
            return sorted(set(abilities or FOUR), key=place_of)
        for each in abilities or ():
            if each is not Ability.ACTION_SEQUENCING:
                raise InputError(f"--ability {each.value}: only plans are carried out, attempt by attempt")
        return [Ability.ACTION_SEQUENCING]

    def title(self, suite: Suite) -> str:
        """What stands above the results of a suite."""
        title = f"{suite.domain}, {suite.ability.value}, protocol {suite.protocol.value}"
        experiment, goals, shown = (
            self.spec.of(Attempts).experiment,
            self.spec.of(Pipeline).goals,
            self.spec.of(Perception),
        )
        if experiment is not None:
            title += f"\n{experiment.label}"
        if goals is not None:
            title += f"\ngoals: {goals}"
        return title if shown.scene is Scene.TEXT else f"{title}\nscene: {shown.label}"

    def trials(self, library: Library, suite: Suite, prompts: Mapping[str, Prompt]) -> Trials | None:
        """How answers are carried out, in several attempts or where actions slip."""
        experiment = self.spec.of(Attempts).experiment
        if experiment is None:
            return None
        asker = library.asker(suite.benchmark, suite.ability, prompts)
        return open_trials(suite, experiment, asker, prompts)

    def first(
        self, library: Library, order: Order, chosen: Sequence[tuple[Suite, Mapping[str, Prompt]]]
    ) -> FirstStage | Scenes | None:
        """What comes before the questions, if anything does: goals are interpreted, or scenes are seen."""
        wanted: dict[str, set[str]] = {}
        for suite, asked in chosen:
            wanted.setdefault(suite.domain, set()).update(asked)
        shown, goals = self.spec.of(Perception), self.spec.of(Pipeline).goals
        if shown.scene is not Scene.TEXT:
            return Scenes(shown, self.spec.captioner, library, partial(obtain_and_score, order), wanted)
        if goals is not None:
            return FirstStage(goals, library, partial(obtain_and_score, order), wanted)
        return None
