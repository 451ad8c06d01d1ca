"""BEHAVIOR-1K as a benchmark, with and without the conventions told."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial

from eai.abilities.operator_task import TransitionTask, declared_tasks
from eai.abilities.protocol import Ability
from eai.abilities.task import Category, Task
from eai.abilities.wording import Wording
from eai.benchmark.benchmark import Benchmark
from eai.english import English, english_of
from eai.households.behavior_1k import predicates as p
from eai.households.behavior_1k.conventions import conventions
from eai.households.behavior_1k.operators import declared
from eai.households.behavior_1k.tasks import open_tasks, subsets
from eai.tasks.source import Source, TaskSet, once_per_store

NAME, UNTOLD = "behavior-1k", "behavior-1k-untold"
CHALLENGE, OF_100 = "behavior-1k-challenge-2025", "behavior-1k-behavior-100"


@cache
def _english() -> English:
    return english_of("eai.households.behavior_1k")


def _plain(ability: Ability) -> Wording:
    return Wording(declared(), p.GOAL_PREDICATES)


def _with_conventions(ability: Ability) -> Wording:
    """The words, with the conventions where an ability takes plans; what an instruction asks for does not."""
    plain = _plain(ability)
    acts = ability in (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION)
    return replace(plain, conventions=conventions) if acts else plain


@once_per_store
def _activities(source: Source) -> TaskSet[Task]:
    return open_tasks(_english(), source)


def _listed(subset: str, source: Source) -> TaskSet[Task]:
    tasks = _activities(source)
    return TaskSet(subsets()[subset], tasks.__getitem__, tasks.sha256)


@once_per_store
def _operators(source: Source) -> TaskSet[TransitionTask]:
    """The tasks of transition modeling; problems tell the rules, which operators read, but not rooms."""
    tasks, vocabulary = _activities(source), declared().vocabulary
    told = tuple([replace(each, visible=each is not p.by_floor) for each in vocabulary.predicates])
    domain = replace(declared(), vocabulary=replace(vocabulary, predicates=told))
    rules = {each.name: Category.NON_SPATIAL_RELATIONS for each in p.RULES}
    asked = declared_tasks(domain, tasks, rules)
    return TaskSet(asked, asked.__getitem__, tasks.sha256)


def behavior_1k() -> Benchmark:
    """The benchmark: prompts tell the conventions that matter."""
    return Benchmark(
        name=NAME,
        title="BEHAVIOR-1K",
        domain=declared(),
        open_tasks=_activities,
        open_operators=_operators,
        wordings=_with_conventions,
        also_observed=("held", "robot_on"),
        english=_english(),
        role="a household robot",
        planner_seconds=200,
    )


def untold() -> Benchmark:
    """The same without: what a model knows of tools, heat and recipes counts."""
    return replace(behavior_1k(), name=UNTOLD, title="BEHAVIOR-1K, conventions untold", wordings=_plain)


def challenge_2025() -> Benchmark:
    """The 50 activities of the 2025 BEHAVIOR challenge, in its order."""
    chosen = partial(_listed, "challenge_2025")
    return replace(behavior_1k(), name=CHALLENGE, title="BEHAVIOR-1K, 2025 challenge", open_tasks=chosen)


def of_behavior_100() -> Benchmark:
    """The 65 activities that BEHAVIOR-100 has by the same name."""
    chosen = partial(_listed, "behavior_100")
    return replace(behavior_1k(), name=OF_100, title="BEHAVIOR-1K, also in BEHAVIOR-100", open_tasks=chosen)
