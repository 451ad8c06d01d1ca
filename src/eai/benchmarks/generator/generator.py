"""Generate any number of tasks.

A specification and a seed determine a task, or the reason for rejecting the seed.
"""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import NamedTuple

import eai.logic.formula as f
from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.base.grouping import group_pairs
from eai.base.json_value import Json
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.copied_answers import SimilarTaskTable
from eai.benchmarks.generator import sets
from eai.benchmarks.generator.census import DomainLimitedToActionsSeenInPlans, learn_usual_goals_from_tasks
from eai.benchmarks.generator.composed_scene import (
    add_static_facts_comparing_objects,
    compose_scene_from_tasks,
    list_mentioned_objects_by_category,
)
from eai.benchmarks.generator.goals import GoalSampler, is_usual_goal
from eai.benchmarks.generator.growing_plan import (
    GoalByGoalPlan,
    TemporalGoalGenerator,
    find_min_plan_length,
    make_shortened_plan,
)
from eai.benchmarks.generator.hazards import add_hazard_avoidance_goals, find_hazard_goals, may_hazard_occur
from eai.benchmarks.generator.measures import TaskMeasure, get_difficulty_model, measure_task
from eai.benchmarks.generator.scene import (
    MIN_OBJECTS,
    add_objects_of_other_tasks,
    add_portable_objects_similar_to_existing,
    hide_object,
    make_function_listing_ways_to_hide_objects,
    make_state_with_subset_of_objects,
)
from eai.benchmarks.generator.seeds import TaskSeedOutcome, select_tasks
from eai.benchmarks.generator.spec import (
    CANARY,
    LENGTHS,
    SHUT_LAST,
    GeneratedTask,
    GenerationOutcome,
    PlanLengthTier,
    SeedRejectionReason,
    TaskKind,
    TaskSpecification,
    TaskSplit,
    get_tier_of_length,
)
from eai.benchmarks.generator.twins import (
    ImpossibleMinusPossibleTasks,
    PossibleImpossiblePairChooser,
    make_possible_impossible_pair_chooser,
    make_unambiguous_task_paired_with_ambiguous,
)
from eai.benchmarks.generator.usual_goals import (
    LiteralPattern,
    UsualGoalsOfDataSet,
    UsualGoalsOfTaskTitle,
    do_goals_clash,
    find_goal_subjects,
    is_goal_pointless_without_missing_goal,
)
from eai.benchmarks.generator.words import InstructionWriter
from eai.logic.traversal import find_object_names
from eai.planning.planner import Planner
from eai.tasks.goal_test import GoalTest, solves_task
from eai.tasks.goal_text import make_task
from eai.tasks.source import Source
from eai.tasks.task import Task, goal
from eai.tasks.task_lines import convert_plan_to_word_lists
from eai.world.domain import Domain
from eai.world.relation import iterate_bits
from eai.world.state import State

_PROPOSALS_PER_GOAL = 12
"""Number of random goals tried for each goal of a new task; ten times as many for tiers in `_RICH_TIERS`."""

_MAX_FAILURES_IN_A_ROW = 5
"""Number of failed searches in a row for a plan to a goal, after which a scene gets no more goals."""

_MAX_THEMES = 3
"""Maximum number of titles of published tasks whose goals a new task combines.

The maximum does not apply to the tiers (ranges of plan lengths) in `_RICH_TIERS`.
"""

_MIN_COMPOSED_OBJECTS = 6
"""Minimum number of objects to which a scene can be limited if it is composed from several tasks."""

_MIN_KEPT_SHARE = 2 / 3
"""Minimum share of the objects of its base task that a composed scene keeps."""

_RICH_TIERS = (PlanLengthTier.L, PlanLengthTier.XL, PlanLengthTier.XXL)
"""Tiers (ranges of plan lengths) whose scenes have more objects than the data set's scenes."""

_SHORTEST_RANGE = 3, 8
"""The lowest range of plan lengths for new tasks: minimum and maximum number of steps.

The tier `DATA` computes a range from the length of a published plan. Neither of its limits may be lower than
here.
"""

_USUAL_STEPS = 5
"""Assumed number of steps of a plan, if the data set has no plans."""

_MAX_EXTRA_STEPS = 6
"""Maximum number of steps that a temporal goal (such as an order) adds to the plan that solves a task."""

_PROPOSALS_FOR_HIDDEN = 40
"""Maximum number of random goals that are tried to find a first goal about a hidden object."""

_OFFER_WEIGHT = 2
"""Number added to the weight of a published task, for drawing the base task of a new task.

The number is added once for each condition that holds:

- An object of the task can be hidden.
- Tasks with its title need or mention a category of portable objects, and some task has several objects of
  this category.
"""

_HIDING_PROBABILITY = 0.7
"""Probability of hiding an object, if the task allows this and the data set has no quantified goals."""

_TASKS_PER_PLANNER = 200
"""Number of tasks after which planners are replaced, because planners keep every formula in memory."""


class _SceneLimits(NamedTuple):
    """Limits of the numbers of objects in a scene, which has objects of a task `base` and of other tasks.

    Attributes:
        least_of_base: minimum number of objects from `base`.
        most_of_base: maximum number of objects from `base`.
        most_objects: maximum number of all objects.
        counts: category -> maximum number of its objects. It limits the objects that bring a new 3D model
            into the scene. Even so, a category may always get its first object.
    """

    least_of_base: int
    most_of_base: int
    most_objects: int
    counts: Mapping[str, int]


class _TaskRejectionReasonFinder:
    """Finds reasons to reject a new task, such as an inexact instruction, or the goals of a published task.

    Args:
        domain: the domain of the tasks.
        public: the benchmark's own tasks.
        spec: the specification of the tasks.
    """

    def __init__(self, domain: Domain, public: Sequence[Task], spec: TaskSpecification) -> None:
        self._domain, self._by_place, self._held_out = domain, spec.by_place, spec.held_out
        self._public = set(map(self._get_digests_for_finding_public_copies, public))
        self._table = SimilarTaskTable(public, domain)

    def find_rejection_reason(
        self, task: Task, words: InstructionWriter, min_steps: int, max_steps: int
    ) -> SeedRejectionReason | None:
        """Return the reason to reject a task, or None for a good task.

        Args:
            task: the task.
            words: writes and reads instructions for the task.
            min_steps: minimum number of steps of the task's plan.
            max_steps: maximum number of steps of the task's plan.
        """
        if len(task.script) < min_steps:
            return SeedRejectionReason.TOO_SHORT
        if len(task.script) > max_steps:
            return SeedRejectionReason.TOO_LONG
        reached = zip(task.goals, GoalTest(task).evaluate_each_goal(task.initial, ()), strict=True)
        if any(holds for task_goal, holds in reached if not task_goal.is_temporal):
            return SeedRejectionReason.HOLDS_ALREADY
        if not solves_task(self._domain, task, task.script):
            return SeedRejectionReason.NO_CERTIFICATE
        if (reason := self._find_instruction_problem(task, words)) is not None:
            return reason
        if self._get_digests_for_finding_public_copies(task) in self._public:
            return SeedRejectionReason.PUBLIC
        if self._table.solves_by_adapted_plan(task):
            return SeedRejectionReason.PUBLIC_PLAN
        return None

    def _get_digests_for_finding_public_copies(self, task: Task) -> tuple[str, ...]:
        """Return digests of a task. A new task with the digests of a public task is rejected as its copy.

        Usually the digest of the goals decides alone. If training and test may share goals, the digest of the
        initial state must be equal, too.
        """
        fingerprint = sets.fingerprint_task(task, self._held_out)
        return fingerprint if self._held_out == "starts" else fingerprint[:1]

    def _find_instruction_problem(self, task: Task, words: InstructionWriter) -> SeedRejectionReason | None:
        """Return the reason to reject a task's instruction, or None for a good instruction.

        An instruction is rejected if its words can describe an object only by the object's name. It is also
        rejected if reading the instruction does not give exactly the goals.
        """
        goals = tuple([goal.formula for goal in task.goals])
        named = (name for goal in goals for name in find_object_names(goal))
        if self._by_place and not all(map(words.can_object_be_described_without_name, named)):
            return SeedRejectionReason.NAMELESS
        has_hazards = len(task.goals_not_about_hazards) < len(
            goals
        )  # sentences about hazards cannot be read back into goals
        says = words.does_instruction_state_exactly_goals(task.instruction, goals) or has_hazards
        return None if says else SeedRejectionReason.AMBIGUOUS


@dataclass
class TaskGenerator:
    """Generates tasks in the world of a benchmark.

    Args:
        benchmark: the benchmark whose domain and scenes the tasks use.
        spec: the specification of the tasks.
        source: the source of the benchmark's data.
        is_given_away: function that tells whether a task shares a plan with a task of another split, such as
            the test set (`eai.benchmarks.generator.sets.make_shared_plan_detector`). Such a task is rejected.
        reopen: makes an equal generator, for example in another process.

    Raises:
        InputError: the specification limits the difficulty, but no difficulties are known for this benchmark.
    """

    benchmark: Benchmark
    spec: TaskSpecification
    source: Source
    is_given_away: Callable[[Task], bool] | None = None
    reopen: Callable[[], TaskGenerator] | None = None

    def __reduce__(self) -> tuple[Callable[[], TaskGenerator], tuple[()]]:
        """Pickle a generator as a call that makes an equal one; functions of domains cannot be pickled."""
        if self.reopen is None:
            raise InputError(
                f"{self.spec.like}: only a generator from open_generator can be pickled; use open_generator"
            )
        return self.reopen, ()

    def __post_init__(self) -> None:
        self._made = 0
        self._difficulty = get_difficulty_model(self.benchmark.name)
        if self._difficulty is None and self.spec.difficulty is not None:
            raise InputError(
                f"difficulty: the difficulty of tasks of {self.benchmark.name} is not known; "
                "leave out the option `difficulty`"
            )
        self._tasks = list(self.benchmark.tasks(self.source).values())
        self.usual_goals: UsualGoalsOfDataSet = learn_usual_goals_from_tasks(self.benchmark, self._tasks)
        self._bases = sets.select_public_tasks_of_split(self._tasks, self.spec.split, self.spec.held_out)
        if not self._bases:
            raise InputError(
                f"{self.benchmark.name}: the split {self.spec.split.value} (held out: {self.spec.held_out}) "
                "contains no public task; choose another split"
            )
        self._tasks_by_title = group_pairs((task.title, task) for task in self._bases)
        self._compare_objects = self.benchmark.data.compare_objects
        self._is_composed = bool(self.usual_goals.countable_categories) or self._compare_objects is not None
        self._donors = list_mentioned_objects_by_category(self._bases)
        self._title_weights = {
            title: 1
            + sum(
                is_usual_goal(p, self.usual_goals)
                for p in chain(*self.usual_goals.themes[title].patterns.values())
            )
            for title in self._tasks_by_title
        }
        self._objections = _TaskRejectionReasonFinder(self.benchmark.domain, self._tasks, self.spec)
        self._usage = DomainLimitedToActionsSeenInPlans(self.benchmark.domain, self.usual_goals)
        self._hiding = make_function_listing_ways_to_hide_objects(self.benchmark.domain, self.usual_goals)
        self._weights = list(self._compute_draw_weights_of_public_tasks())
        self._replace_planners_to_free_memory()
        self._listings = self.benchmark.wording(Ability.ACTION_SEQUENCING).fact_listers_of_goal_predicates

    def _replace_planners_to_free_memory(self) -> None:
        """Replace the planners by new planners, because planners keep all formulas in memory."""
        self._planner = Planner(self._usage.domain)
        self._free_planner = Planner(self.benchmark.domain)

    def _compute_draw_weights_of_public_tasks(self) -> Iterator[float]:
        """Yield the weight of each published task, for drawing the base task of a new task.

        If no category is countable (`UsualGoalsOfDataSet.countable_categories`), all weights are 1.
        Otherwise, tasks with the same title share one weight, so that titles with many tasks are not drawn
        more often. Some tasks weigh more (`_OFFER_WEIGHT`).
        """
        several = self.usual_goals.countable_categories & self.usual_goals.taken_categories
        numbers = Counter([task.title for task in self._bases])
        for task in self._bases:
            offers = not several.isdisjoint(self.usual_goals.themes[task.title].categories)
            more = _OFFER_WEIGHT * (offers + bool(self._hiding(task)))
            yield (1 + more) / numbers[task.title] if self.usual_goals.countable_categories else 1.0

    def _draw_order_of_task_titles(self, first_title: str, rng: random.Random) -> list[str]:
        """Return the titles of the data set's tasks in random order after a given first title.

        Titles whose tasks have many plausible goals tend to come early.
        """
        keys = {title: rng.random() ** (1 / weight) for title, weight in self._title_weights.items()}
        return sorted(keys, key={**keys, first_title: 1.0}.__getitem__, reverse=True)

    def generate_task(
        self, seed: str, known_fingerprints: Collection[tuple[str, str]] = ()
    ) -> GenerationOutcome:
        """Return the task that a seed determines, or the reason to reject the seed.

        The result is equal on every machine. A task is rejected as a copy if its
        fingerprints (digests of goals and scene) are in ``known_fingerprints``.
        """
        return self.make_task_from_seed(seed, known_fingerprints).decide_outcome_given_earlier_tasks(
            known_fingerprints, ImpossibleMinusPossibleTasks()
        )

    def make_task_from_seed(
        self, seed: str, known_fingerprints: Collection[tuple[str, str]] = ()
    ) -> TaskSeedOutcome:
        """Return the task of a seed, or the reason to reject it, and fingerprints for finding copies.

        ``known_fingerprints`` may be empty. If it has the fingerprints of earlier tasks, copies are rejected
        sooner.
        """
        compared: list[tuple[str, str]] = []

        def is_copy_of_earlier_task(fingerprint: tuple[str, str]) -> bool:
            compared.append(fingerprint)
            return fingerprint in known_fingerprints

        outcome = self._generate_task_or_make_task_pair_chooser(seed, is_copy_of_earlier_task)
        return TaskSeedOutcome(outcome, compared[0] if compared else None)

    def _generate_task_or_make_task_pair_chooser(
        self, seed: str, is_copy_of_earlier_task: Callable[[tuple[str, str]], bool]
    ) -> GenerationOutcome | PossibleImpossiblePairChooser:
        self._made += 1
        if self._made % _TASKS_PER_PLANNER == 0:
            self._replace_planners_to_free_memory()
        rng = self.spec.make_random_generator(seed)
        base = rng.choices(self._bases, self._weights)[0]
        titles = self._draw_order_of_task_titles(base.title, rng)
        initial, hidden, goal_titles = self._make_scene(base, titles, rng)
        if self.spec.kind.is_hazardous and not may_hazard_occur(
            self.benchmark.notation.english.hazards, initial.scene
        ):
            return SeedRejectionReason.NO_HAZARD
        least, most = self._get_plan_length_range(base)
        growing_plan = self._make_plan_for_random_usual_goals(goal_titles, initial, hidden, rng, least, most)
        if not growing_plan.goals:
            return SeedRejectionReason.NO_GOALS
        goals, start = list(growing_plan.goals), self._usage.convert_state_to_original_domain(initial)
        held_out, is_over_time = self.spec.held_out, self.spec.kind.has_temporal_goal
        split = sets.choose_split_of_goals(goals, start, held_out)
        is_known = not is_over_time and is_copy_of_earlier_task(
            sets.fingerprint_goals_and_scene(goals, start, held_out)
        )
        if self.spec.split not in (TaskSplit.ALL, split):
            return SeedRejectionReason.OTHER_SPLIT
        if is_known:
            return SeedRejectionReason.COPY
        words = InstructionWriter.make_writer_for_benchmark(
            self.benchmark, start, distinguishes_objects_by_place=self.spec.by_place
        )
        name = f"{self.benchmark.name}-{self.spec.sha256[:6]}-{seed}"
        unsolved = make_task(name, words.make_instruction(goals, rng), start, *goals)
        task = replace(unsolved, script=tuple(make_shortened_plan(growing_plan)))
        about: dict[str, Json] = {"split": split.value}
        reason = self._objections.find_rejection_reason(task, words, least, most)
        if reason is None and is_over_time:
            proposals = self._make_goal_sampler(initial, self.usual_goals.themes[base.title])
            timed = self._add_temporal_goals(task, initial, proposals, words, rng)
            if isinstance(timed, SeedRejectionReason):
                return timed
            task = timed.task
            about |= timed.about
            reason = self._objections.find_rejection_reason(task, words, least, most + _MAX_EXTRA_STEPS)
            if reason is None and is_copy_of_earlier_task(sets.fingerprint_task(task, held_out)):
                reason = SeedRejectionReason.COPY
        if reason is None and self.is_given_away is not None and self.is_given_away(task):
            reason = SeedRejectionReason.KNOWN_PLAN
        if reason is None and not self._can_goal_objects_be_seen(task):
            reason = SeedRejectionReason.NEVER_SEEN
        outcome = self._measure_or_reject_task(task, seed, about) if reason is None else reason
        if isinstance(outcome, SeedRejectionReason):
            return outcome
        return self._make_task_pair_if_specified(outcome, rng)

    def _make_task_pair_if_specified(
        self, generated: GeneratedTask, rng: random.Random
    ) -> GenerationOutcome | PossibleImpossiblePairChooser:
        """Return the task, or a pair of tasks made from it if the specification asks for pairs.

        For pairs of a possible and an impossible task, return a function that makes the pair
        (`PossibleImpossiblePairChooser`).
        """
        planner = self._free_planner
        if self.spec.kind is TaskKind.PAIRS:
            may_lack = self.benchmark.notation.english.may_lack
            return make_possible_impossible_pair_chooser(generated, planner, may_lack, rng)
        if self.spec.kind is TaskKind.AMBIGUOUS:
            return (
                make_unambiguous_task_paired_with_ambiguous(
                    generated, self.benchmark, self.usual_goals, planner, rng
                )
                or SeedRejectionReason.NOT_AMBIGUOUS
            )
        return generated

    def _add_temporal_goals(
        self,
        task: Task,
        initial: State,
        proposals: GoalSampler,
        words: InstructionWriter,
        rng: random.Random,
    ) -> GenerationOutcome:
        """Return a task with additional temporal goals (orders, hazards), or the reason why there are none.

        The returned task also has a temptation: a plan that reaches only the other goals.
        """
        tempting = {"temptation": convert_plan_to_word_lists(task)}
        if self.spec.kind is TaskKind.ORDER:
            begin, listings = partial(GoalByGoalPlan, self._planner, initial), self._listings
            temporal = TemporalGoalGenerator(
                task, self.benchmark.domain, listings, proposals, rng, begin
            ).find_temporal_goal()
            if temporal is None:
                return SeedRejectionReason.NO_ORDER
            instruction = words.make_instruction(
                [*(task_goal.formula for task_goal in task.goals), temporal.goal], rng
            )
            goals, plan = (*task.goals, goal(temporal.goal)), tuple(temporal.plan)
            tempting = {
                "temptation": convert_plan_to_word_lists(replace(task, script=tuple(temporal.temptation)))
            }
            return GeneratedTask(replace(task, goals=goals, script=plan, instruction=instruction), tempting)
        guards = list(
            find_hazard_goals(self.benchmark.notation.english.hazards, self.benchmark.domain, words)
        )
        safe = add_hazard_avoidance_goals(
            task,
            initial,
            guards,
            self._free_planner,
            self._planner,
            rng,
            untold=self.spec.kind is TaskKind.UNTOLD,
        )
        if safe is None:
            return SeedRejectionReason.NO_HAZARD
        return GeneratedTask(safe.task, {**tempting, SHUT_LAST: safe.is_safe_if_shut_last})

    def _can_goal_objects_be_seen(self, task: Task) -> bool:
        """Whether each object of the goals is visible at the start, or becomes visible by a relaxed plan."""
        domain, start, scene = self.benchmark.domain, task.initial, task.scene
        return domain.visible is None or all(
            domain.visible_object_filter(start, 1 << i)
            or self._free_planner.looks_reachable(start, domain.visible, range(len(scene.objects)), x=i)
            for i in sorted(task.find_objects_named_in_goals(task.goals))
        )

    def _measure_or_reject_task(self, task: Task, seed: str, about: dict[str, Json]) -> GenerationOutcome:
        """Return the task with its measures, or the reason to reject it.

        A task is rejected if it is too easy, too difficult or too small.
        """
        measures = measure_task(task, self.benchmark.domain)
        if any(measures[measure] < number for measure, number in self.spec.at_least):
            return SeedRejectionReason.TOO_LITTLE
        if (
            self._difficulty is not None
            and (expected := self._difficulty.estimate_difficulty(task)) is not None
        ):
            about["difficulty"] = {"expected": expected, "error": self._difficulty.error}
            low, high = self.spec.difficulty or (-math.inf, math.inf)
            if not low <= expected <= high:
                return SeedRejectionReason.DIFFICULTY
        about["lower_bound"] = least = find_min_plan_length(task, self.benchmark.domain, self.spec.depth)
        if least == 1:
            return SeedRejectionReason.ONE_ACTION
        return GeneratedTask(task, {**self._describe_task(task, seed, measures), **about})

    def _describe_task(self, task: Task, seed: str, measured: Mapping[TaskMeasure, int]) -> dict[str, Json]:
        of_goals, of_scene = sets.fingerprint_task(task)
        return {
            "tier": get_tier_of_length(len(task.script)).value,
            **{measure.value: number for measure, number in measured.items()},
            "goals_fingerprint": of_goals,
            "scene_fingerprint": of_scene,
            "spec": self.spec.sha256[:16],
            "seed": seed,
            "canary": CANARY,
        }

    def _make_scene(
        self, base_task: Task, task_titles: Sequence[str], rng: random.Random
    ) -> tuple[State, frozenset[int], Sequence[str]]:
        """Return a scene after random actions, the indices of hidden objects, and titles of published tasks.

        New goals resemble the goals of published tasks with these titles. The objects come from the data
        set's task `base_task`. A composed scene also has objects of one random task for each further title
        in `task_titles`. Random actions are undone if the agent then holds an object that it did not hold
        before.
        """
        rich = self.spec.tier in _RICH_TIERS
        limits = self._draw_scene_limits(base_task, rng)
        most = limits.most_objects
        place, pair = self._draw_hiding_pattern_and_its_objects(base_task, rng)
        scene = make_state_with_subset_of_objects(
            base_task,
            self.usual_goals,
            rng,
            limits.most_of_base,
            leaves_room_for_other_tasks=rich,
            only_relevant=self._is_composed,
            required_objects=[*pair, *self._find_objects_with_unique_states(base_task)],
            min_objects=limits.least_of_base,
        )
        origins = {
            thing.name: (base_task, base_task.scene.index[thing.name]) for thing in scene.scene.objects
        }
        if self._is_composed:
            kinds = self.usual_goals.themes[base_task.title].categories
            scene = add_portable_objects_similar_to_existing(
                scene, self.usual_goals, rng, most, kinds, origins
            )
            guests = (rng.choice(self._tasks_by_title[title]) for title in task_titles[1:])
            model_of = self.benchmark.data.model_of
            scene = compose_scene_from_tasks(
                scene, guests, self._donors, self.usual_goals, rng, most, origins, model_of, limits.counts
            )
        if rich:
            scene = add_objects_of_other_tasks(scene, self._bases, self.usual_goals, rng, most, origins)
        if self._compare_objects is not None:
            scene = add_static_facts_comparing_objects(scene, origins, self._compare_objects)
            present = {task.title for task, _ in origins.values()}
            task_titles = [title for title in task_titles if title in present]
        closed = self._usage.make_state(scene.scene, scene.facts())
        proposals = self._make_goal_sampler(closed)
        growing_plan = GoalByGoalPlan(self._planner, closed)
        for _ in range(rng.randint(0, self.spec.disturbances)):
            wanted, before = proposals.draw_literal(rng, relation_probability=0.5), growing_plan.state
            if wanted is not None:
                growing_plan.reach_goal(wanted)
                growing_plan.conditions.clear()
            if self._find_held_objects(growing_plan.state) - self._find_held_objects(before):
                growing_plan.state = before
        last, hidden = growing_plan.state, frozenset[int]()
        if place is not None:
            names = [base_task.scene.objects[i].name for i in pair]
            start = self._usage.convert_state_to_original_domain(last)
            after = hide_object(self._free_planner, start, place.predicate, *names)
            if after is not None:
                last, hidden = after, frozenset({after.scene.index[names[0]]})
        return self._usage.make_state(last.scene, last.facts()), hidden, task_titles

    def _draw_scene_limits(self, base: Task, rng: random.Random) -> _SceneLimits:
        """Return the limits of a scene that is made from the published task `base`.

        - If the data set has no function `compare_objects`, only the specification and `MIN_OBJECTS` count.
        - Otherwise, a random published task limits the number of objects of each category.
        - Except in `_RICH_TIERS`, that task and `base` then limit the number of all objects, too.
        """
        most, number = self.spec.most_objects, len(base.scene.objects)
        if self._compare_objects is None:
            return _SceneLimits(MIN_OBJECTS, most, most, {})
        counts = Counter([thing.category for thing in rng.choice(self._bases).scene.objects])
        if self.spec.tier in _RICH_TIERS:
            return _SceneLimits(MIN_OBJECTS, most, most, counts)
        most = min(most, max(number, counts.total(), _MIN_COMPOSED_OBJECTS))
        return _SceneLimits(round(number * _MIN_KEPT_SHARE), min(number, most), most, counts)

    def _find_objects_with_unique_states(self, task: Task) -> Iterator[int]:
        for predicate in sorted(self.usual_goals.unique_states):
            yield from iterate_bits(task.initial.mask(predicate))

    def _draw_hiding_pattern_and_its_objects(
        self, base_task: Task, rng: random.Random
    ) -> tuple[LiteralPattern | None, Sequence[int]]:
        """Return a random way to hide an object: a relation between two categories, and two objects for it.

        If no object is to be hidden, return None and no objects.
        """
        places = (
            self._hiding(base_task)
            if self.usual_goals.countable_categories and rng.random() < _HIDING_PROBABILITY
            else ()
        )
        if not places:
            return None, ()
        place = rng.choice(places)
        return place, [
            rng.choice(list(iterate_bits(base_task.scene.get_category_mask(kind))))
            for kind in place.categories
        ]

    def _find_held_objects(self, state: State) -> set[int]:
        return {
            fact.arguments[-1]
            for fact in state.facts()
            if fact.predicate in self.usual_goals.holding_predicate_names
        }

    def _get_plan_length_range(self, base: Task) -> tuple[int, int]:
        """Return the minimum and maximum number of plan steps for a new task that is based on `base`."""
        if self.spec.tier is not PlanLengthTier.DATA:
            return LENGTHS[self.spec.tier]
        length = len(base.script) or _USUAL_STEPS
        least, most = _SHORTEST_RANGE
        return max(least, round(0.5 * length)), max(most, round(1.4 * length))

    def _make_goal_sampler(self, state: State, theme: UsualGoalsOfTaskTitle | None = None) -> GoalSampler:
        spec = self.spec
        return GoalSampler.make_goal_sampler_for_scene(
            state.scene, self.usual_goals, spec.forms, actions=spec.actions, theme=theme
        )

    def _make_plan_for_random_usual_goals(
        self,
        task_titles: Sequence[str],
        initial: State,
        hidden_objects: frozenset[int],
        rng: random.Random,
        min_steps: int,
        max_steps: int,
    ) -> GoalByGoalPlan:
        """Return a sequence of about `min_steps` to `max_steps` actions, with the goals that it reaches.

        For one title of published tasks after the other, goals are drawn that resemble the goals of tasks
        with this title. This ends when the sequence is long enough, or when goals of enough titles are
        reached (`_MAX_THEMES`). In a composed scene, the first title is used twice: first for a random number
        of steps, and again after all other titles. If possible, the first goal is about a hidden object.
        """
        growing_plan = GoalByGoalPlan(self._planner, initial)
        is_rich = self.spec.tier in _RICH_TIERS
        wanted = rng.randint((min_steps + max_steps) // 2, max_steps)
        # number of actions from which on no goals of a further title are added
        enough = wanted if is_rich else (min_steps + max_steps) // 2
        max_themes = len(task_titles) if is_rich else _MAX_THEMES
        ending: list[f.Formula] = []
        if self._is_composed:
            theme = self.usual_goals.themes[task_titles[0]]
            ending = self._make_goal_sampler(initial, theme).draw_goals_about_agent(theme, rng)
        occasions = 0
        for title in (*task_titles, task_titles[0]) if self._is_composed else task_titles:
            theme = self.usual_goals.themes[title]
            proposals = self._make_goal_sampler(initial, theme)
            if len(growing_plan.trail) >= enough or occasions == max_themes:
                break
            if proposals.patterns:
                reached = len(growing_plan.goals)
                last = ending if self._is_composed else proposals.draw_goals_about_agent(theme, rng)
                length = rng.randint(1, wanted) if self._is_composed and not occasions else wanted
                self._extend_action_sequence(growing_plan, proposals, last, rng, length, hidden_objects)
                if len(growing_plan.goals) > reached or not reached:
                    occasions += len(growing_plan.goals) > reached
                    ending = last if is_rich or self._is_composed or occasions < 2 else []
        for wish in ending:  # goals about the agent come last, because it moves to reach other goals
            if not growing_plan.goal_holds(wish, initial):
                growing_plan.reach_goal(wish)
        return growing_plan

    def _extend_action_sequence(
        self,
        growing_plan: GoalByGoalPlan,
        proposals: GoalSampler,
        final_goals: Sequence[f.Formula],
        rng: random.Random,
        wanted_length: int,
        hidden_objects: frozenset[int],
    ) -> None:
        """Add actions that reach random goals, which `proposals` draws.

        Stop when the sequence is long enough, or when too many goals in a row cannot be reached.
        """
        scene, initial = growing_plan.state.scene, growing_plan.start
        tried: set[f.Formula] = set()
        failures = 0  # in a row
        tries = _PROPOSALS_PER_GOAL * (10 if self.spec.tier in _RICH_TIERS else 1)
        sought = proposals.restrict_first_object_to_categories(
            {scene.objects[i].category for i in hidden_objects}
        )
        searched = 0 if growing_plan.goals or not sought.patterns else _PROPOSALS_FOR_HIDDEN
        for _ in range(searched + tries * max(2, wanted_length // 3)):
            if len(growing_plan.trail) >= wanted_length or failures == max(
                _MAX_FAILURES_IN_A_ROW, wanted_length // 3
            ):
                break
            searched -= 1
            is_search = searched >= 0 and not growing_plan.goals
            wish = (sought if is_search else proposals).draw_goal(rng)
            if (
                wish is None
                or wish in tried
                or is_goal_pointless_without_missing_goal(wish, growing_plan.goals, scene, self.usual_goals)
            ):
                continue
            if is_search and find_goal_subjects(wish, scene).isdisjoint(hidden_objects):
                continue
            tried.add(wish)
            others = (*growing_plan.goals, *final_goals)
            if any(do_goals_clash(wish, other, scene, self.usual_goals) for other in others):
                continue
            if not growing_plan.goal_holds(wish, initial):
                reached = self._reach_goal_holding_no_goal_object_at_end(growing_plan, wish)
                failures = 0 if reached else failures + 1

    def _reach_goal_holding_no_goal_object_at_end(
        self, growing_plan: GoalByGoalPlan, goal: f.Formula
    ) -> bool:
        """Append actions that reach one more goal, after which the agent holds no object of the goal.

        Return whether this was possible. If not, the plan stays as it was.
        """
        subjects = find_goal_subjects(goal, growing_plan.state.scene)
        before = growing_plan.get_plan_checkpoint()
        if not growing_plan.reach_goal(goal):
            return False
        if subjects.isdisjoint(self._find_held_objects(growing_plan.state)):
            return True
        growing_plan.go_back_to(before)
        return False


def generate_from_seeds(
    generator: TaskGenerator,
    seeds: Iterator[str],
    number: int,
    known_fingerprints: set[tuple[str, str]],
    fingerprint_log: list[tuple[str, str]] | None = None,
) -> Iterator[GenerationOutcome]:
    """Yield the task of each seed, or the reason to reject it, until there are `number` tasks.

    This process does all the work.

    Args:
        generator: the generator.
        seeds: endless seeds.
        number: number of tasks.
        known_fingerprints: fingerprints of earlier tasks. Those of the generated tasks are added.
        fingerprint_log: list to which the fingerprints of tasks and rejected duplicates are added in order.

    Raises:
        InputError: too many seeds in a row give no task.
    """
    judged = (generator.make_task_from_seed(seed, known_fingerprints) for seed in seeds)
    return select_tasks(judged, generator.spec, number, known_fingerprints, fingerprint_log)
