"""BEHAVIOR-1K as a benchmark, with and without the conventions told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial

from eai.abilities.notation.notation import Notation
from eai.abilities.protocol import Ability
from eai.benchmarks.behavior_1k import predicates as p
from eai.benchmarks.behavior_1k.conventions import conventions, describe_situation
from eai.benchmarks.behavior_1k.operators import declared
from eai.benchmarks.behavior_1k.tasks import open_tasks, subsets
from eai.benchmarks.benchmark import Benchmark, DataSet
from eai.tasks.english import English, english_of
from eai.tasks.operator_task import TransitionTask, declared_tasks
from eai.tasks.source import OpenTasks, Source, TaskSet, once_per_store
from eai.tasks.task import Category, Task
from eai.tasks.wording import Wording

NAME, UNTOLD = "behavior-1k", "behavior-1k-untold"
CHALLENGE, OF_100 = "behavior-1k-challenge-2025", "behavior-1k-behavior-100"


_UNCHANGING = tuple([each.name for each in p.VOCABULARY.predicates if each.static and not each.visible])


@cache
def _english() -> English:
    return english_of("eai.benchmarks.behavior_1k")


def _wording(told: Callable[[Task], str], ability: Ability) -> Wording:
    """Return the words, with hidden facts for abilities that take plans."""
    plain = Wording(declared(), p.GOAL_PREDICATES)
    acts = ability in (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION)
    return replace(plain, conventions=told, unchanging=_UNCHANGING) if acts else plain


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
    return _variant(NAME, "BEHAVIOR-1K")


def _variant(
    name: str,
    title: str,
    open_activities: OpenTasks[Task] = _activities,
    told: Callable[[Task], str] = conventions,
) -> Benchmark:
    wordings, operators = partial(_wording, told), {Ability.TRANSITION_MODELING: _operators}
    return Benchmark(
        name,
        declared(),
        open_activities,
        Notation(wordings=wordings, also_observed=("held", "robot_on"), english=_english()),
        DataSet(title, own_tasks=operators, planner_seconds=200),
    )


def untold() -> Benchmark:
    """Return BEHAVIOR-1K with prompts that do not explain tools, heat and recipes."""
    return _variant(UNTOLD, "BEHAVIOR-1K, conventions untold", told=describe_situation)


def challenge_2025() -> Benchmark:
    """The 50 activities of the 2025 BEHAVIOR challenge, in its order."""
    return _variant(CHALLENGE, "BEHAVIOR-1K, 2025 challenge", partial(_listed, "challenge_2025"))


def of_behavior_100() -> Benchmark:
    """The 65 activities that BEHAVIOR-100 has by the same name."""
    return _variant(OF_100, "BEHAVIOR-1K, also in BEHAVIOR-100", partial(_listed, "behavior_100"))
