"""Records: one scored answer, with what it is an answer to and where it comes from.

`Perceived` counts what was perceived of a scene against what there is to perceive.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from eai.abilities.attempt import Attempt, Usage
from eai.abilities.experiment import Experiment
from eai.abilities.explanation import Explanation
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.task_features import TaskFeatures
from eai.abilities.verdict import Confusion, Verdict
from eai.benchmarks.errata_use import ErrataUse
from eai.tasks.task import TaskExclusion


@dataclass(frozen=True, slots=True)
class Perceived:
    """How a scene graph differs from the scene (paper, appendix on vision models, which names four errors).

    What is described of a scene are the facts that a prompt states, without those that follow from others. A
    fact that holds without being described is no error.

    Attributes:
        facts: how many facts are described.
        relations: how many of them relate two objects.
        perceived: how many facts the scene graph has.
        missing: described facts that it lacks, other than the misplaced ones.
        misplaced: described relations for which it has the same of the same object and another one: spatial
            hallucinations.
        unnecessary: further facts of it that do not hold, of objects that exist.
        invented: facts of it with a name that the scene has not: object hallucinations.
        objects: how many objects there are to name.
        names: how many names the scene graph has.
        invented_names: how many of them the scene has not.
        unseen: how many of the objects it does not name.
        predicates: by predicate, facts that are right, that do not hold, and that it lacks.
        ill_formed: entries of the answer that are no facts: unknown predicates, wrong numbers of objects.
        unreadable: whether there is no scene graph in the answer, so that nothing is perceived.
    """

    facts: int
    relations: int
    perceived: int
    missing: int
    misplaced: int
    unnecessary: int
    invented: int
    objects: int
    names: int
    invented_names: int
    unseen: int
    predicates: Mapping[str, Confusion]
    ill_formed: int = 0
    unreadable: bool = False


NOT_ANSWERED = TaskExclusion("not answered")
"""The reason for excluding a task without an answer, if the user asks for it; the run is not ranked then."""


@dataclass(frozen=True, slots=True)
class Origin:
    """Where the answer of a run comes from; what a task without an answer was asked is known all the same.

    Attributes:
        prompt_sha256: digest of the prompt.
        stop_reason: why the answer ended: ``stop``, ``max_tokens``, ...
        truncated: whether a limit of length cut it off.
        usage: what it took.
        answer_repairs: names of what was done to the model's text before it was scored.
    """

    prompt_sha256: str | None = None
    stop_reason: str | None = None
    truncated: bool | None = None
    usage: Usage | None = None
    answer_repairs: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Stated:
    """The goals that a question stated in the place of the task's, where a pipeline asked it.

    Attributes:
        goals_sha256: digest of the answer that states them, which is `response_sha256` of its own record.
        goal_counts: how many of them are right, how many are not, and how many goals are missed, under the
            default protocol. Those that are ill-formed, or name what does not exist, are not right.
        stage_1_unreadable: whether that answer could not be read, so that the question stated no goals.
        stage_1_unknown: the names in it that mean nothing, which the question passed on as they are.
        stage_1_left_out: how many of its entries are ill-formed.
        subgoals_sha256: digest of the answer whose subgoals the question states; None if it states none.
        subgoals_success: whether that answer is right; None if the question states no subgoals.
    """

    goals_sha256: str
    goal_counts: Confusion
    stage_1_unreadable: bool = False
    stage_1_unknown: tuple[str, ...] = ()
    stage_1_left_out: int = 0
    subgoals_sha256: str | None = None
    subgoals_success: bool | None = None


@dataclass(frozen=True, slots=True)
class Record:
    """A verdict with what it is a verdict on.

    Attributes:
        domain: the name of the domain.
        model: who answered.
        task_id: the data set's id.
        response: the answer as it was scored; empty also where a record that was read does not have it.
        data_sha256: digest of the data it was scored against.
        verdict: of the class that the ability declares.
        errata: the errata of the data that it was made with; None if none were used.
        sample: its number, from 0, where a task has several answers that all count; None for the only one.
        explanation: what became of the answer in words, where that was asked for.
        origin: where the answer comes from, where a run knows it.
        task: what the task is like, where that is known.
        unanswered: why there is no answer; None if there is one, be it empty.
        suite_size: how many tasks the suite has, whose records together are a whole run; None if that is
            not known.
        experiment: how its run differs from asking each question once; None if it does not.
        stated: in a pipeline, the goals that the question stated; None where it was not asked.
        perceived: how the scene that the question described differs from the task's, where it may.
        attempts: every answer to the task, in order, where answers were carried out in an experiment. The
            verdict is that of the last.
    """

    protocol: Protocol
    domain: str
    ability: Ability
    model: str
    task_id: str
    response: str
    data_sha256: str
    verdict: Verdict
    explanation: Explanation | None = None
    origin: Origin | None = None
    task: TaskFeatures | None = None
    unanswered: str | None = None
    suite_size: int | None = None
    experiment: Experiment | None = None
    stated: Stated | None = None
    perceived: Perceived | None = None
    attempts: tuple[Attempt, ...] = ()
    errata: ErrataUse | None = None
    sample: int | None = None

    @property
    def repairs(self) -> tuple[str, ...]:
        """All repairs, those made before scoring first."""
        before = () if self.origin is None else self.origin.answer_repairs
        return (*before, *self.verdict.repairs)

    def varied(self, **choices: str | None) -> Record:
        """The same record as one of a run with these fields of its `Experiment`; None changes nothing."""
        chosen: dict[str, Any] = {name: choice for name, choice in choices.items() if choice is not None}
        if not chosen:
            return self
        return replace(self, experiment=replace(self.experiment or Experiment(), **chosen))

    def without_explanations(self) -> Record:
        """The same record without words, also on its attempts."""
        attempts = tuple([replace(attempt, explanation=None) for attempt in self.attempts])
        return replace(self, explanation=None, attempts=attempts)
