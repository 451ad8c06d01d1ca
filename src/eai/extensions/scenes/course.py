"""Compute the states and pictures along an answer: at the start and after each step.

Records of answers hold no states, so the executed steps of a record are executed again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import Protocol as Structure
from typing import runtime_checkable

from eai.abilities.explanation import EXECUTED, StepReport, VerdictExplanation
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.replanning_options import ReplanningOptions
from eai.benchmarks.registry import list_benchmarks
from eai.benchmarks.suite import Suite, open_suite
from eai.extensions.scenes.diagrams import make_words_for_picture_labels
from eai.extensions.scenes.tiles import make_object_rectangles
from eai.results.record import Record
from eai.studies.perception.scene_graph import SceneGraphVocabulary
from eai.studies.report.explorer import ObjectRectangle, SceneDiagrams
from eai.tasks.source import ErrataChoice, Source
from eai.tasks.task import Task
from eai.tasks.wording import list_objects_in_prompt
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.episode import Episode
from eai.world.state import Scene, State


@runtime_checkable
class _AnswerExecutingScorer(Structure):
    """A scorer that executes answers. It has the domain in which answers are executed, and the task."""

    domain: Domain
    task: Task


def make_scene_diagram_maker(source: Source) -> Callable[[Record], SceneDiagrams]:
    """Return a function from the record of an answer to diagrams of the scene along the answer.

    The function opens the suite (tasks with their scoring) of several records only once.
    """

    @cache
    def open_cached_suite(domain: str, ability: Ability, protocol: Protocol, *, errata: bool) -> Suite:
        choice = ErrataChoice.CURRENT if errata else ErrataChoice.NONE
        return open_suite(domain, ability, protocol, source=replace(source, errata=choice))

    def make_scene_diagrams(record: Record) -> SceneDiagrams:
        if record.domain not in list_benchmarks() or _get_steps(record.explanation) == ():
            return ()
        errata = record.errata is not None
        return make_scene_diagrams_after_each_step(
            record, open_cached_suite(record.domain, record.ability, record.protocol, errata=errata)
        )

    return make_scene_diagrams


def make_scene_diagrams_after_each_step(record: Record, suite: Suite) -> SceneDiagrams:
    """Return diagrams of the scene, at the start and after each step of an answer.

    Each diagram is a list of rectangles, one for each object. There are no diagrams if the answer cannot be
    replayed.
    """
    found = replay_record(record, suite)
    if found is None:
        return ()
    task, states = found
    named = [i for step in _get_steps(record.explanation) for i in _to_action(step, task.scene).arguments]
    shown = list(dict.fromkeys([*list_objects_in_prompt(task), *named]))
    words = make_words_for_picture_labels(suite.benchmark)
    return [_make_diagram_of_scene(task, words, state, shown) for state in states]


def replay_record(record: Record, suite: Suite) -> tuple[Task, list[State]] | None:
    """Return the task of an answer's record, and the states at the start and after each step of the answer.

    Returns:
        the task and the states, or None if the record was made with other data, or if its answer has no plan.
    """
    if suite.data_sha256 != record.data_sha256 or record.task_id not in suite.task_ids:
        return None
    scorer = suite.scorer(record.task_id)
    if not isinstance(scorer, _AnswerExecutingScorer):
        return None
    before = _list_steps_of_earlier_attempts(record)
    states = replay_steps(scorer.domain, scorer.task.initial, [*before, *_get_steps(record.explanation)])
    return None if states is None else (scorer.task, states[len(before) :])


def replay_steps(domain: Domain, initial: State, steps: Sequence[StepReport]) -> list[State] | None:
    """Return the states at the start and after each step, or None if a step cannot be executed again."""
    episode = Episode(domain, initial)
    states = [episode.state]
    for step in steps:
        if step.outcome == EXECUTED and step.call.name in domain.operator_arities:
            after = episode.act(_to_action(step, initial.scene))
            if not isinstance(after, State):
                return None
        states.append(episode.state)
    return states


def _make_diagram_of_scene(
    task: Task, words: SceneGraphVocabulary, state: State, shown_objects: Sequence[int]
) -> list[ObjectRectangle]:
    agent = task.scene.agent
    graph = words.make_true_graph(replace(task, initial=state), shown_objects)
    return make_object_rectangles(
        graph, words, None if agent is None else words.list_object_names(task)[agent]
    )


def _to_action(step: StepReport, scene: Scene) -> Action:
    named = step.call.arguments or ()
    return Action(step.call.name, tuple([scene.index[name] for name in named if name in scene.index]))


def _list_steps_of_earlier_attempts(record: Record) -> list[StepReport]:
    """Return the steps before the last attempt if each attempt continues in the state of the previous one.

    If each attempt begins in the initial state, return an empty list.
    """
    options = ReplanningOptions.from_experiment(record.experiment)
    if options is None or options.world != "continue":
        return []
    return [step for attempt in record.attempts[:-1] for step in _get_steps(attempt.explanation)]


def _get_steps(explanation: VerdictExplanation | None) -> tuple[StepReport, ...]:
    return () if explanation is None else explanation.steps
