"""Variations of a run: what a study has models told or asked first, and how it carries answers out."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from itertools import permutations
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from pydantic import SerializeAsAny

from eai.abilities.attempt_options import AttemptOptions
from eai.abilities.experiment import SEPARATOR, StudyChoice, name_label
from eai.abilities.protocol import PAPER_ABILITIES, Ability, ability_rank
from eai.base.errors import InputError
from eai.base.json_value import Json
from eai.tasks.options import Options

if TYPE_CHECKING:
    from eai.benchmarks.prompt_library import Library
    from eai.benchmarks.suite import Suite
    from eai.results.epochs import BeliefSet, SuiteResult
    from eai.tasks.prompts.prompt import Prompt


@dataclass(frozen=True, slots=True)
class Endpoint:
    """A model and how to reach it.

    Attributes:
        model: an Inspect model name, built-in ones included (``eai/oracle``).
        arguments: arguments of the model's provider.
        base_url: where an OpenAI-compatible server listens; None for the provider's own.
    """

    model: str
    arguments: Mapping[str, Json] = field(default_factory=dict)
    base_url: str | None = None


Ask: TypeAlias = "Callable[..., SuiteResult]"
"""Asks a model, an `Endpoint`, questions by task of a suite, and scores its answers.

It also takes ``first``, a `Stage` before them, and ``epochs``, if there are to be as many as the run has.
"""


@dataclass
class Stage:
    """A stage before the questions of a run, which state what comes of it instead of the facts.

    Attributes:
        library: where prompts come from.
        wanted: the tasks that the run is about, by domain.
        ask: asks a model.
        believe: finds the beliefs that questions to a model state; InputError if they cannot state them, or
            there is nothing.
        before: the stage whose beliefs hold in this one too; None if it is the first.
        outcomes: the results of the questions that were asked in this stage.
        known: the beliefs that were found, for ``believe`` to find each once.
    """

    library: Library
    wanted: Mapping[str, Collection[str]]
    ask: Ask
    believe: Callable[[Stage, Endpoint, Suite], BeliefSet]
    before: Stage | None = None
    outcomes: list[SuiteResult] = field(default_factory=list, init=False)
    known: dict[tuple[str, ...], BeliefSet] = field(default_factory=dict, init=False)

    def second(
        self, endpoint: Endpoint, task_ids: Collection[str], suite: Suite
    ) -> tuple[Mapping[str, Prompt], BeliefSet]:
        """The questions to a model, and what they state; tasks for which there is nothing are left out.

        Raises:
            InputError: as of `believe`.
        """
        believed = self.believed(endpoint, suite)
        return believed.prompts(self.library, suite, task_ids), believed

    def believed(self, endpoint: Endpoint, suite: Suite) -> BeliefSet:
        """Return what questions to a model state, by this stage and all before it.

        Raises:
            InputError: as of `believe`.
        """
        if self.before is None:
            return self.believe(self, endpoint, suite)
        earlier = self.before.believed(endpoint, suite)
        return earlier.combine(self.believe(self, endpoint, suite))

    @property
    def begin(self) -> Stage:
        """The first of this stage and all before it."""
        return self if self.before is None else self.before.begin

    @property
    def all_outcomes(self) -> list[SuiteResult]:
        """The results of the questions of this stage and of all before it."""
        return [*(() if self.before is None else self.before.all_outcomes), *self.outcomes]

    def answers(
        self, endpoint: Endpoint, prompts: Mapping[str, Prompt], suite: Suite, **more: Any
    ) -> dict[str, str]:
        """The answers of a model that is asked in this stage, by task; ``more`` goes to who asks."""
        outcome = self.ask(endpoint, prompts, suite, **more)
        self.outcomes.append(outcome)
        return {each.task_id: each.response for each in outcome.records if each.unanswered is None}


class Variation(Options):
    """The options of a study of runs; without a choice a run is as it is without the study.

    All but `choice` is asked of the options that have one, or of none at all.
    """

    @property
    def choice(self) -> str:
        """The choice that makes a run one of the study, as messages name it; empty if there is none."""
        return ""

    @property
    def heading(self) -> str:
        """A line about the choice."""
        return ""

    @property
    def states(self) -> Literal["", "scene", "goals"]:
        """The part of a task that questions state otherwise; empty if none."""
        return ""

    def contradiction(self, other: Variation) -> str:
        """Return why a run cannot combine the choice with that of another study; empty if it can."""
        if self.states and self.states == other.states:
            return f"both change the {self.states} that questions state"
        if self.attempts is not None and other.attempts is not None:
            return "both say how answers are carried out"
        return ""

    @property
    def attempts(self) -> AttemptOptions | None:
        """How answers are carried out, if not once in a world where every action works."""
        return None

    def recorded(self, study: str) -> StudyChoice | None:
        """Return the choice as records have it: the options that differ from their defaults.

        A study whose stage states its choice returns None (`BeliefSet.experiment`).
        """
        options = self.model_dump(mode="json", exclude_defaults=True)
        label = SEPARATOR.join([name_label(name, str(value)) for name, value in options.items()])
        return StudyChoice(label or study, options)

    @property
    def captioner(self) -> str | None:
        """The model that lists what is in pictures for the one who is asked; None if there is none."""
        return None

    def abilities(self, named: Collection[Ability]) -> list[Ability]:
        """The abilities that are asked for, in order, of those that are named if any are.

        Raises:
            InputError: one that is named cannot be varied so.
        """
        return sorted(set(named or PAPER_ABILITIES), key=ability_rank)

    def stage(self, library: Library, wanted: Mapping[str, Collection[str]], ask: Ask) -> Stage | None:
        """The stage before the questions, if there is one.

        Args:
            library: where prompts come from.
            wanted: the tasks that the run is about, by domain.
            ask: asks a model.
        """
        return None


def combine(variations: Iterable[Variation]) -> Variation:
    """Return the options of all studies that a run combines as one; of a plain run, those without a choice.

    Raises:
        InputError: two of them contradict each other.
    """
    chosen = [each for each in variations if each.choice]
    for one, other in permutations(chosen, 2):
        reason = one.contradiction(other)
        if reason:
            raise InputError(f"{one.choice}: not with {other.choice}; {reason}")
    return chosen[0] if len(chosen) == 1 else _Combination(chosen=tuple(chosen))


class _Combination(Variation):
    """The options of several studies, or of none.

    Attributes:
        chosen: The options of each study with a choice.
    """

    chosen: tuple[SerializeAsAny[Variation], ...] = ()

    @property
    def choice(self) -> str:
        """The choices."""
        return " and ".join([each.choice for each in self.chosen])

    @property
    def heading(self) -> str:
        """A line about the choices."""
        return "; ".join([each.heading for each in self.chosen if each.heading])

    @property
    def attempts(self) -> AttemptOptions | None:
        """How answers are carried out, if not once in a world where every action works."""
        return next((each.attempts for each in self.chosen if each.attempts is not None), None)

    @property
    def captioner(self) -> str | None:
        """The model that lists what is in pictures; None if there is none."""
        return next((each.captioner for each in self.chosen if each.captioner is not None), None)

    def abilities(self, named: Collection[Ability]) -> list[Ability]:
        """Return the abilities that all studies can vary, in order; those of `named` if any are.

        Raises:
            InputError: a study cannot vary an ability that is named, or no ability is left.
        """
        if not self.chosen:
            return super().abilities(named)
        first, *others = [each.abilities(named) for each in self.chosen]
        shared = [ability for ability in first if all(ability in each for each in others)]
        if not shared:
            raise InputError(f"{self.choice}: no ability can be varied by all of them")
        return shared

    def stage(self, library: Library, wanted: Mapping[str, Collection[str]], ask: Ask) -> Stage | None:
        """Return the last stage before the questions, or None; scenes are seen before goals are asked for."""
        last: Stage | None = None
        for each in sorted(self.chosen, key=lambda each: each.states != "scene"):
            stage = each.stage(library, wanted, ask)
            if stage is not None:
                stage.begin.before, last = last, stage
        return last
