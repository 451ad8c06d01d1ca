"""The specification of generated tasks, and the result of a seed: a task, or a reason for its rejection.

A specification and a seed determine every byte of a task.
"""

from __future__ import annotations

import hashlib
import json
import random
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from enum import Enum
from typing import Literal, TypeAlias

from eai.base.json_value import Json
from eai.benchmarks.generator.measures import TaskMeasure
from eai.tasks.task import Task


class SeedRejectionReason(str, Enum):
    """The reason why a seed of the task generator gives no task."""

    NO_GOALS = "no goal was reached"
    TOO_SHORT = "the certificate is too short"
    TOO_LONG = "the certificate is too long"
    HOLDS_ALREADY = "a goal holds at the start"
    NEVER_SEEN = "something that its goals name can never be seen"
    ONE_ACTION = "one action solves it"
    NO_CERTIFICATE = "the certificate does not solve it"
    AMBIGUOUS = "the instruction does not say exactly the goals"
    NAMELESS = "a thing cannot be told from others without its name"
    DIFFICULTY = "it is expected to be easier or harder than was asked for"
    TOO_LITTLE = "there is less in it of something than was asked for"
    NO_ORDER = "no goal over time was found that matters"
    NO_HAZARD = "no hazard was found on its shortest way that a longer one avoids"
    NO_TWIN = "no fact was found without which it is proved to have no plan, with another like it"
    NOT_AMBIGUOUS = "nothing was found beside which another of its kind can stand, so that its words fit both"
    OTHER_SPLIT = "its goals are those of another split"
    KNOWN_PLAN = "the plan of a task of another split with similar goals solves it, or its plan solves such"
    PUBLIC = "a public task has the same goals"
    PUBLIC_PLAN = "the plan of a public task with similar goals solves it"
    COPY = "another generated task is the same"


@dataclass(frozen=True, slots=True)
class GeneratedTask:
    """A generated task with its measures. If tasks come in pairs, it also has the second task of its pair.

    Attributes:
        task: the task. Its script is a plan that solves it.
        about: measures, fingerprints (digests) and seed of the task, which are written to its task file.
        paired: the second task of the pair; None for a single task.
    """

    task: Task
    about: Mapping[str, Json]
    paired: GeneratedTask | None = None


GenerationOutcome: TypeAlias = "GeneratedTask | SeedRejectionReason"


VERSION = 8
"""Version of the generator for most benchmarks. With another version, the same seed gives another task."""

_VERSIONS = {"behavior": 9}
"""Benchmark -> version of its generator, if this is not `VERSION`.

A change that affects only one benchmark raises only its own version.
"""


def get_generator_version(benchmark_reference: str) -> int:
    """Return the version of the task generator for a benchmark.

    A variant, such as `rules:behavior` of the benchmark `behavior`, has the version of its benchmark.
    """
    return _VERSIONS.get(benchmark_reference.rpartition(":")[2], VERSION)


CANARY = "generated tasks of eai; no training data: 6b0f3f6e-8c1d-4f0a-9d35-2f7c51e0a9b4"
"""Text in every generated task, by which generated tasks can be found in training data."""


SHUT_LAST = "safe_if_shut_last"
"""Key in `GeneratedTask.about`, the values written to a task file.

The value is true if a plan that ignores dangers becomes safe when the agent shuts and switches off all
objects at the end.
"""


class PlanLengthTier(str, Enum):
    """A range of numbers of plan steps, such as `S` for 3 to 6 steps (`LENGTHS`).

    For `DATA`, a new task has a plan about as long as the plan of the data set's task on which it is based.
    """

    DATA = "data"
    S = "S"
    M = "M"
    L = "L"
    XL = "XL"
    XXL = "XXL"


LENGTHS = {
    PlanLengthTier.S: (3, 6),
    PlanLengthTier.M: (7, 12),
    PlanLengthTier.L: (13, 24),
    PlanLengthTier.XL: (25, 48),
    PlanLengthTier.XXL: (49, 96),
}
"""Tier -> minimum and maximum number of steps of the plan that solves a task."""


def get_tier_of_length(steps: int) -> PlanLengthTier:
    """Return the tier (range of plan lengths) of a task whose plan has this number of steps."""
    return next((tier for tier, (_, most) in LENGTHS.items() if steps <= most), PlanLengthTier.XXL)


GoalFormFrequency: TypeAlias = Literal["data", "all"]
"""Option for the frequencies of the forms of goals: ``data`` as in the data set, ``all`` equal frequencies.
"""


class TaskKind(str, Enum):
    """The kind of generated tasks: plain, with a temporal goal, with hazards, or in pairs."""

    PLAIN = "plain"
    ORDER = "order"
    """Makes tasks with a temporal goal: an order of two facts, or two facts that must never hold together."""
    HAZARDS = "hazards"
    """Makes tasks whose shortest plan is unsafe: it breaks a safety rule that people take for granted."""
    UNTOLD = "untold-hazards"
    """Makes tasks whose shortest plan breaks a safety rule that the instruction does not mention."""
    PAIRS = "pairs"
    """Makes pairs of tasks. One task of a pair has no plan, because a fact is missing."""
    AMBIGUOUS = "ambiguous"
    """Makes pairs of tasks with one instruction. It fits one object in one task, and two in the other."""

    @property
    def has_temporal_goal(self) -> bool:
        """Whether tasks of this kind have a temporal goal in addition to goals about the final state."""
        return self is TaskKind.ORDER or self.is_hazardous

    @property
    def is_hazardous(self) -> bool:
        """Whether the shortest plan for a task of this kind is unsafe, because a hazard occurs."""
        return self in (TaskKind.HAZARDS, TaskKind.UNTOLD)


class TaskSplit(str, Enum):
    """Name of a set of generated tasks: the set of all tasks, or one of three splits without common goals."""

    ALL = "tasks"
    TRAIN = "train"
    VALIDATION = "validation"
    TEST = "test"


HeldOut: TypeAlias = Literal["goals", "starts", "pairs", "titles", "scenes"]
"""The property of tasks that two splits, such as training and test set, never have in common.

- ``goals``: no two tasks of different splits have equal sets of goals after categories replace objects.
- ``starts``: no two tasks of different splits have equal goals and equal initial states. Objects are
  compared by name. Tasks with equal goals can differ, so a world with few goals gives many tasks.
- ``pairs``: each task of the later split has a goal whose pair of predicate and category no goal of the
  earlier split has.
- ``titles``: the splits share neither goals nor titles of the data set's tasks from which tasks are made.
- ``scenes``: the splits share neither goals nor the data set's tasks whose scenes are used.
"""


@dataclass(frozen=True, slots=True)
class TaskSpecification:
    """The specification of generated tasks.

    Attributes:
        like: reference to the benchmark (see `find_benchmark`).
        data_sha256: digest of the benchmark's tasks, from which scenes, goals and their frequencies are
            drawn.
        tier: the range of lengths of the plans that solve the tasks.
        forms: the shapes of goals.
        actions: whether goals may ask for actions. This has no effect if no goal of the data set asks for an
            action.
        kind: the kind of tasks.
        by_place: whether instructions distinguish objects of one category by their place or state, and never
            by their names.
        most_objects: maximum number of objects in a scene.
        depth: number of actions up to which all plans are tried, to find a lower bound of the plan's length.
        difficulty: minimum and maximum expected difficulty (`eai.benchmarks.generator.measures`); None for
            any.
        at_least: minimum values of measures, as pairs of a measure and its minimum.
        split: the split (such as training or test) to which tasks belong.
        held_out: the property that two splits never have in common.
        disturbances: maximum number of facts that random actions make true in a scene before a task begins.
        version: version of the generator; 0 for the latest.
    """

    like: str
    data_sha256: str
    tier: PlanLengthTier = PlanLengthTier.DATA
    forms: GoalFormFrequency = "data"
    actions: bool = False
    kind: TaskKind = TaskKind.PLAIN
    by_place: bool = False
    most_objects: int = 30
    depth: int = 1
    difficulty: tuple[float, float] | None = None
    at_least: tuple[tuple[TaskMeasure, int], ...] = ()
    split: TaskSplit = TaskSplit.ALL
    held_out: HeldOut = "goals"
    disturbances: int = 4
    version: int = 0

    def __post_init__(self) -> None:
        if not self.version:
            object.__setattr__(self, "version", get_generator_version(self.like))

    @property
    def sha256(self) -> str:
        """Digest of this specification. Older versions of the package compute the same digest.

        Specifications that differ only in the kinds `HAZARDS` and `UNTOLD` have equal digests. They give the
        same tasks, except that instructions for `UNTOLD` do not mention the hazards.
        """
        fields = asdict(self)
        kind = fields.pop("kind")
        fields["over_time"] = kind is TaskKind.ORDER
        if kind not in (TaskKind.PLAIN, TaskKind.ORDER):
            fields["kind"] = kind.value.removeprefix("untold-")
        return hashlib.sha256(json.dumps(fields, sort_keys=True).encode()).hexdigest()

    def make_random_generator(self, seed: str) -> random.Random:
        """Return the random generator for the task of a seed."""
        digest = hashlib.sha256(f"{self.sha256} {seed}".encode()).digest()
        return random.Random(digest)  # noqa: S311 - tasks, not secrets
