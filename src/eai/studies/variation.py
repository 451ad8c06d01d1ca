"""Vary runs: a study changes what questions state, asks a model before them, or retries failed answers."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from itertools import permutations
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from pydantic import SerializeAsAny

from eai.abilities.experiment import SEPARATOR, StudySettings, make_option_label
from eai.abilities.protocol import PAPER_ABILITIES, Ability, get_ability_sort_key
from eai.abilities.replanning_options import ReplanningOptions
from eai.base.errors import InputError
from eai.base.json_value import Json
from eai.tasks.options import Options

if TYPE_CHECKING:
    from eai.benchmarks.prompt_library import PromptLibrary
    from eai.benchmarks.suite import Suite
    from eai.results.epochs import GoalsAndScenesStatedInPrompts, SuiteResult
    from eai.tasks.prompts.prompt import Prompt


@dataclass(frozen=True, slots=True)
class ModelEndpoint:
    """A model, and the server and arguments by which it is called.

    Attributes:
        model: an Inspect model name, built-in ones included (``eai/oracle``).
        arguments: arguments of the model's provider.
        base_url: address of an OpenAI-compatible server; None for the provider's own.
    """

    model: str
    arguments: Mapping[str, Json] = field(default_factory=dict)
    base_url: str | None = None


AskModel: TypeAlias = "Callable[..., SuiteResult]"
"""Function that asks a model the questions of a suite, and returns the scored answers.

Its arguments are the model (see `ModelEndpoint`), the prompts by task id, and the suite. Optional
arguments are ``first``, the `StageThatObtainsGoalsOrScenes` that obtains goals or scenes for the
prompts, and ``epochs``, the number of answers per task.
"""


@dataclass
class StageThatObtainsGoalsOrScenes:
    """A stage of a run, before the run's questions, that obtains goals or scenes for these questions.

    Example: a model first interprets the goals of tasks, and the run's questions then state these goals. Such
    goals and scenes are called beliefs, because they may be wrong.

    Attributes:
        library: source of the prompts.
        task_ids: the ids of the run's tasks, by domain.
        ask: function that asks a model.
        believe: obtains the beliefs, which the questions then state. It raises InputError if it obtains no
            beliefs, or if the questions cannot state the beliefs.
        previous: the stage before this stage; None for the first stage. Questions state the beliefs of all
            stages.
        results: the results of this stage's own questions to models.
        found_beliefs: cache of results of ``believe``, so that each set of beliefs is obtained only once.
    """

    library: PromptLibrary
    task_ids: Mapping[str, Collection[str]]
    ask: AskModel
    believe: Callable[[StageThatObtainsGoalsOrScenes, ModelEndpoint, Suite], GoalsAndScenesStatedInPrompts]
    previous: StageThatObtainsGoalsOrScenes | None = None
    results: list[SuiteResult] = field(default_factory=list, init=False)
    found_beliefs: dict[tuple[str, ...], GoalsAndScenesStatedInPrompts] = field(
        default_factory=dict, init=False
    )

    def make_prompts_with_goals_and_scenes(
        self, endpoint: ModelEndpoint, task_ids: Collection[str], suite: Suite
    ) -> tuple[Mapping[str, Prompt], GoalsAndScenesStatedInPrompts]:
        """Return prompts for a model by task id, and the beliefs (goals or scenes) that the prompts state.

        The beliefs are from this stage and all earlier stages. Tasks without a belief are left out.

        Raises:
            InputError: a stage obtained no beliefs, or the prompts cannot state the beliefs.
        """
        beliefs = self.collect_goals_and_scenes_up_to_this_stage(endpoint, suite)
        return beliefs.make_prompts_stating_goals_and_scenes(self.library, suite, task_ids), beliefs

    def collect_goals_and_scenes_up_to_this_stage(
        self, endpoint: ModelEndpoint, suite: Suite
    ) -> GoalsAndScenesStatedInPrompts:
        """Return a model's beliefs from this stage and all earlier stages of the run.

        Beliefs are goals and scenes. The run's questions state the beliefs instead of the true goals and
        scenes.

        Raises:
            InputError: a stage obtained no beliefs, or the questions cannot state the beliefs.
        """
        if self.previous is None:
            return self.believe(self, endpoint, suite)
        earlier = self.previous.collect_goals_and_scenes_up_to_this_stage(endpoint, suite)
        return earlier.combine_own_scenes_with_goals_of(self.believe(self, endpoint, suite))

    @property
    def first_stage_of_run(self) -> StageThatObtainsGoalsOrScenes:
        """The first stage of the run. It is this stage if no stage comes before this stage (`previous`)."""
        return self if self.previous is None else self.previous.first_stage_of_run

    @property
    def all_results(self) -> list[SuiteResult]:
        """The results of the questions of this stage and of all stages before it."""
        return [*(() if self.previous is None else self.previous.all_results), *self.results]

    def ask_for_answers(
        self, endpoint: ModelEndpoint, prompts: Mapping[str, Prompt], suite: Suite, **further_arguments: Any
    ) -> dict[str, str]:
        """Ask a model, add its scored answers to the attribute `results`, and return the answers by task id.

        Unanswered tasks are left out. ``further_arguments`` are arguments of `AskModel`, such as the number
        of answers per task.
        """
        outcome = self.ask(endpoint, prompts, suite, **further_arguments)
        self.results.append(outcome)
        return {record.task_id: record.response for record in outcome.records if record.unanswered is None}


class VariationOptions(Options):
    """The options of a study that varies runs. With the default values, a run is unchanged.

    If `option_that_enables_study` is empty, the study does not vary the run, and the other properties and
    methods are not used.
    """

    @property
    def option_that_enables_study(self) -> str:
        """Option by which the user added this study to a run, for messages; empty without this study."""
        return ""

    @property
    def results_heading(self) -> str:
        """Heading that describes the chosen options above a run's results; empty if no options are chosen."""
        return ""

    @property
    def changed_task_part(self) -> Literal["", "scene", "goals"]:
        """Name of the part of a task that this study changes in questions; empty if it changes none."""
        return ""

    def explain_conflict(self, other: VariationOptions) -> str:
        """Return why a run cannot combine these options with another study's options; empty if it can."""
        if self.changed_task_part and self.changed_task_part == other.changed_task_part:
            return f"both change the {self.changed_task_part} that questions state"
        if self.replanning is not None and other.replanning is not None:
            return "both say how answers are carried out"
        return ""

    @property
    def replanning(self) -> ReplanningOptions | None:
        """The options of replanning and slips; None for a plain run (one attempt, and every action works)."""
        return None

    def make_study_settings_to_store_in_records(self, study_name: str) -> StudySettings | None:
        """Return the options of the study that differ from their defaults, for the records of a run.

        A study returns None if it has nothing to record. It also returns None if records get its options
        together with goals or scenes (`GoalsAndScenesStatedInPrompts.experiment`).
        """
        options = self.model_dump(mode="json", exclude_defaults=True)
        label = SEPARATOR.join([make_option_label(name, str(value)) for name, value in options.items()])
        return StudySettings(label or study_name, options)

    @property
    def captioning_model(self) -> str | None:
        """Name of a second model that sees the pictures and lists the scene for the asked model, or None."""
        return None

    def select_abilities(self, requested: Collection[Ability]) -> list[Ability]:
        """Return the abilities of the run in order: the named ones, or all that the study supports.

        Raises:
            InputError: the study does not support a named ability.
        """
        return sorted(set(requested or PAPER_ABILITIES), key=get_ability_sort_key)

    def make_stage_that_obtains_goals_or_scenes(
        self, library: PromptLibrary, task_ids_by_domain: Mapping[str, Collection[str]], ask: AskModel
    ) -> StageThatObtainsGoalsOrScenes | None:
        """Return the stage that obtains goals or scenes (beliefs) for a run's questions, or None.

        The result is None if the study does not change the goals or scenes in questions.

        Args:
            library: source of the prompts.
            task_ids_by_domain: the ids of the run's tasks, by domain.
            ask: function that asks a model.
        """
        return None


def combine_variations(variations: Iterable[VariationOptions]) -> VariationOptions:
    """Return the options of all studies that vary one run, as a single `VariationOptions`.

    A study varies a run if the user chose an option of this study (`option_that_enables_study`). If no study
    varies the run, the result changes nothing.

    Raises:
        InputError: two studies cannot be combined.
    """
    chosen = [variation for variation in variations if variation.option_that_enables_study]
    for one, other in permutations(chosen, 2):
        reason = one.explain_conflict(other)
        if reason:
            raise InputError(
                f"{one.option_that_enables_study}: cannot be combined with "
                f"{other.option_that_enables_study}; {reason}"
            )
    return chosen[0] if len(chosen) == 1 else _OptionsOfAllStudiesInOneRun(chosen=tuple(chosen))


class _OptionsOfAllStudiesInOneRun(VariationOptions):
    """The options of all studies that one run combines; there may be no study.

    Attributes:
        chosen: The options of each study for which the user chose options.
    """

    chosen: tuple[SerializeAsAny[VariationOptions], ...] = ()

    @property
    def option_that_enables_study(self) -> str:
        """The options by which the user added studies to the run, joined by "and"."""
        return " and ".join([variation.option_that_enables_study for variation in self.chosen])

    @property
    def results_heading(self) -> str:
        """Headings of all studies that vary the run, joined by semicolons."""
        return "; ".join(
            [variation.results_heading for variation in self.chosen if variation.results_heading]
        )

    @property
    def replanning(self) -> ReplanningOptions | None:
        """The options of replanning and slips; None for a plain run (one attempt, and every action works)."""
        return next((choice.replanning for choice in self.chosen if choice.replanning is not None), None)

    @property
    def captioning_model(self) -> str | None:
        """Name of a second model that sees the pictures and lists the scene for the asked model, or None."""
        return next(
            (choice.captioning_model for choice in self.chosen if choice.captioning_model is not None), None
        )

    def select_abilities(self, requested: Collection[Ability]) -> list[Ability]:
        """Return the abilities that all studies support, in order; if the user names abilities, only these.

        Raises:
            InputError: a study does not support a named ability, or no ability is left.
        """
        if not self.chosen:
            return super().select_abilities(requested)
        first, *others = [variation.select_abilities(requested) for variation in self.chosen]
        shared = [ability for ability in first if all(ability in abilities for abilities in others)]
        if not shared:
            raise InputError(
                f"{self.option_that_enables_study}: no ability supports all of these options together; "
                "choose only one of them"
            )
        return shared

    def make_stage_that_obtains_goals_or_scenes(
        self, library: PromptLibrary, task_ids_by_domain: Mapping[str, Collection[str]], ask: AskModel
    ) -> StageThatObtainsGoalsOrScenes | None:
        """Return the last stage before the run's questions, or None if no study needs a stage.

        Each stage obtains scenes or goals (beliefs) for the questions, and is linked to the stage before it
        (`previous`). Stages that obtain scenes come before stages that obtain goals.
        """
        last: StageThatObtainsGoalsOrScenes | None = None
        for variation in sorted(self.chosen, key=lambda variation: variation.changed_task_part != "scene"):
            stage = variation.make_stage_that_obtains_goals_or_scenes(library, task_ids_by_domain, ask)
            if stage is not None:
                stage.first_stage_of_run.previous, last = last, stage
        return last
