"""The benchmark BEHAVIOR-1K, and its variants.

In some variants, prompts explain how the simulated household works, such as which tool removes a stain.
Others test whether a model knows this.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

from eai.abilities.notation.notation import Notation
from eai.abilities.protocol import Ability
from eai.benchmarks.behavior_1k import predicates as p
from eai.benchmarks.behavior_1k.challenge import load_activities_of_challenge_2026
from eai.benchmarks.behavior_1k.checkout import read_activity_definitions
from eai.benchmarks.behavior_1k.conventions import (
    describe_floors_and_substance_sources,
    describe_unobservable_facts,
)
from eai.benchmarks.behavior_1k.operators import build_domain
from eai.benchmarks.behavior_1k.tasks import load_activity_subsets, open_tasks
from eai.benchmarks.benchmark import Benchmark, DataSet, read_texts_for_short_prompts
from eai.tasks.english import EnglishWords, read_english_words
from eai.tasks.operator_task import TransitionTask, make_transition_tasks
from eai.tasks.source import OpenTasks, Source, TaskSet, cache_opened_tasks_per_data_folder
from eai.tasks.task import PredicateCategory, Task
from eai.tasks.wording import PromptAndAnswerWording

NAME, UNTOLD = "behavior-1k", "behavior-1k-untold"
CHALLENGE, OF_100 = "behavior-1k-challenge-2025", "behavior-1k-behavior-100"
CHALLENGE_2026 = "behavior-1k-challenge-2026"
CHECKOUT = "behavior-1k-checkout"
"""Name of the benchmark whose activities come from a user's checkout of the BEHAVIOR-1K repository.

Definitions in a checkout can differ from those of bddl 3.6.0.
"""


_UNCHANGING = tuple(
    [predicate.name for predicate in p.VOCABULARY.predicates if predicate.static and not predicate.visible]
)


@cache
def _load_english() -> EnglishWords:
    return read_english_words("eai.benchmarks.behavior_1k")


def _make_prompt_wording(
    describe_hidden_facts: Callable[[Task], str], ability: Ability
) -> PromptAndAnswerWording:
    """Return the names of objects and predicates in the prompts for an ability.

    For plans and subgoals, the result also has a function that describes hidden facts, such as recipes.
    """
    plain = PromptAndAnswerWording(build_domain(), p.GOAL_PREDICATES, hands=("held",))
    takes_plans = ability in (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION)
    return replace(plain, conventions=describe_hidden_facts, unchanging=_UNCHANGING) if takes_plans else plain


@cache_opened_tasks_per_data_folder
def _open_activities(source: Source) -> TaskSet[Task]:
    return open_tasks(_load_english(), source)


def _open_subset(subset: str, source: Source) -> TaskSet[Task]:
    tasks = _open_activities(source)
    return TaskSet(load_activity_subsets()[subset], tasks.__getitem__, tasks.sha256)


@cache_opened_tasks_per_data_folder
def _open_operator_tasks(source: Source) -> TaskSet[TransitionTask]:
    return _make_operator_tasks(_open_activities(source))


def _make_operator_tasks(tasks: TaskSet[Task]) -> TaskSet[TransitionTask]:
    """Return the tasks of transition modeling.

    The planning problems of these tasks list the facts that operators check, such as recipes, but no rooms.
    """
    vocabulary = build_domain().vocabulary
    shown = tuple(
        [replace(predicate, visible=predicate is not p.by_floor) for predicate in vocabulary.predicates]
    )
    domain = replace(build_domain(), vocabulary=replace(vocabulary, predicates=shown))
    rules = {rule.name: PredicateCategory.NON_SPATIAL_RELATIONS for rule in p.RULES}
    operator_tasks = make_transition_tasks(domain, tasks, rules)
    return TaskSet(operator_tasks, operator_tasks.__getitem__, tasks.sha256)


GOAL_LABELS: Mapping[str, str] = {
    "inside": "transport",
    "ontop": "transport",
    "under": "transport relational-goal",
    "nextto": "transport relational-goal",
    "touching": "transport relational-goal",
    "open": "articulated",
    "attached": "precision-fit",
    "filled": "fluid-granular",
    "contains": "fluid-granular",
    "toggled_on": "device-operation",
    "cooked": "thermal irreversible",
    "frozen": "thermal",
    "on_fire": "thermal irreversible",
    "covered": "surface-treatment",
    "real": "irreversible",
    "real half": "cutting irreversible",
    "real diced": "cutting irreversible",
}
"""Predicate of a goal -> labels of tasks with such a goal, such as ``transport``, separated by spaces.

The labels are defined in `eai.benchmarks.labels`.
"""


def behavior_1k() -> Benchmark:
    """Return BEHAVIOR-1K with prompts that list the tools, heat sources and recipes relevant for a task."""
    return _make_variant(NAME, "BEHAVIOR-1K")


def _make_variant(
    name: str,
    title: str,
    open_activities: OpenTasks[Task] = _open_activities,
    describe_hidden_facts: Callable[[Task], str] = describe_unobservable_facts,
    open_operators: OpenTasks[TransitionTask] = _open_operator_tasks,
) -> Benchmark:
    wordings = partial(_make_prompt_wording, describe_hidden_facts)
    operators = {Ability.TRANSITION_MODELING: open_operators}
    return Benchmark(
        name,
        build_domain(),
        open_activities,
        Notation(
            short_texts=read_texts_for_short_prompts("eai.benchmarks.behavior_1k"),
            wordings=wordings,
            also_observed=("held", "robot_on"),
            english=_load_english(),
        ),
        DataSet(title, own_tasks=operators, planner_seconds=200, labels=GOAL_LABELS),
    )


def open_benchmark_of_checkout(folder: str) -> Benchmark:
    """Return the benchmark of the activity definitions in a checkout of BEHAVIOR-1K's repository.

    Objects and rules are those of bddl 3.6.0.

    Raises:
        InputError: the folder has no definition, or a definition is damaged.
    """
    definitions = read_activity_definitions(Path(folder))

    @cache_opened_tasks_per_data_folder
    def open_tasks_defined_in_checkout(source: Source) -> TaskSet[Task]:
        return open_tasks(_load_english(), source, definitions)

    return _make_variant(
        CHECKOUT,
        "BEHAVIOR-1K, checkout",
        open_tasks_defined_in_checkout,
        open_operators=lambda source: _make_operator_tasks(open_tasks_defined_in_checkout(source)),
    )


def behavior_1k_untold() -> Benchmark:
    """Return BEHAVIOR-1K with prompts that explain neither tools nor heat nor recipes."""
    return _make_variant(
        UNTOLD, "BEHAVIOR-1K, conventions untold", describe_hidden_facts=describe_floors_and_substance_sources
    )


def behavior_1k_challenge_2025() -> Benchmark:
    """Return the benchmark with the 50 activities of the BEHAVIOR challenge of 2025, in its order."""
    return _make_variant(CHALLENGE, "BEHAVIOR-1K, 2025 challenge", partial(_open_subset, "challenge_2025"))


@cache_opened_tasks_per_data_folder
def _open_challenge_2026(source: Source) -> TaskSet[Task]:
    return open_tasks(_load_english(), source, *load_activities_of_challenge_2026(source))


def behavior_1k_challenge_2026() -> Benchmark:
    """Return the benchmark with the 100 activities of the BEHAVIOR challenge of 2026, in its order.

    Definitions that changed after bddl 3.6.0 are amended.
    """
    return _make_variant(
        CHALLENGE_2026,
        "BEHAVIOR-1K, 2026 challenge",
        _open_challenge_2026,
        open_operators=lambda source: _make_operator_tasks(_open_challenge_2026(source)),
    )


def behavior_1k_in_behavior_100() -> Benchmark:
    """Return the benchmark of the 65 activities that BEHAVIOR-100 also has, under the same names."""
    return _make_variant(OF_100, "BEHAVIOR-1K, also in BEHAVIOR-100", partial(_open_subset, "behavior_100"))
