"""The specification of generated tasks, which decides with a seed every byte of one; and what a seed gives.

That is a task, or a reason why there is none.
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
from eai.benchmarks.generator.measures import Measure
from eai.tasks.task import Task


class Reason(str, Enum):
    """Why a seed gives no task."""

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
class Generated:
    """A task with its certificate, which is its script, and what is known of it; of pairs the twin, too."""

    task: Task
    about: Mapping[str, Json]
    twin: Generated | None = None


Outcome: TypeAlias = "Generated | Reason"


VERSION, HAZARDS_VERSION = 6, 7
"""Of the generator, and of it for tasks with hazards: in another version, a seed makes other tasks."""

CANARY = "generated tasks of eai; no training data: 6b0f3f6e-8c1d-4f0a-9d35-2f7c51e0a9b4"
"""In every generated task, so that a corpus that holds some can be told."""


SHUT_LAST = "safe_if_shut_last"
"""Key in `about` of a task with hazards: whether it is safe to shut and switch off everything at the end."""


class Tier(str, Enum):
    """How long certificates are; `DATA` draws their length from the data set's own plans."""

    DATA = "data"
    S = "S"
    M = "M"
    L = "L"
    XL = "XL"
    XXL = "XXL"


LENGTHS = {Tier.S: (3, 6), Tier.M: (7, 12), Tier.L: (13, 24), Tier.XL: (25, 48), Tier.XXL: (49, 96)}
"""The least and greatest number of steps of a certificate."""


def tier_of(steps: int) -> Tier:
    """The tier of a certificate of so many steps."""
    return next((tier for tier, (_, most) in LENGTHS.items() if steps <= most), Tier.XXL)


Forms: TypeAlias = Literal["data", "all"]
"""Which shapes goals have: those of the data set, as often as there, or all, equally often."""


class TaskKind(str, Enum):
    """A special kind of tasks."""

    PLAIN = "plain"
    ORDER = "order"
    """A goal over time is asked for besides: an order, or what must never be."""
    HAZARDS = "hazards"
    """The shortest way is not safe: it breaks a constraint that a person takes for granted."""
    UNTOLD = "untold-hazards"
    """The same tasks, in which nothing is said of the constraint."""
    PAIRS = "pairs"
    """Two versions of a task, of which one has no plan, for want of a fact."""
    AMBIGUOUS = "ambiguous"
    """Two versions of a task, of which the instruction of one fits two things."""

    @property
    def is_over_time(self) -> bool:
        """Whether goals over time are asked for besides."""
        return self is TaskKind.ORDER or self.is_hazardous

    @property
    def is_hazardous(self) -> bool:
        """Whether the shortest way is not safe."""
        return self in (TaskKind.HAZARDS, TaskKind.UNTOLD)


class Split(str, Enum):
    """Which tasks are wanted: all that come, or those of one of three parts that share no goals."""

    ALL = "tasks"
    TRAIN = "train"
    VALIDATION = "validation"
    TEST = "test"


HeldOut: TypeAlias = Literal["goals", "pairs", "titles", "scenes"]
"""The property that splits do not share.

``goals``: all goals of a task together, objects known by kind. ``pairs``: a predicate with a kind of thing;
each task of a later split asks for one that no earlier split has. ``titles``: goals, and the titles of public
tasks, that is, what belongs together. ``scenes``: goals, and the public tasks from whose scenes those of new
ones are made.
"""


@dataclass(frozen=True, slots=True)
class Spec:
    """The specification of tasks to be generated.

    Attributes:
        like: the benchmark, as `find_benchmark` takes it.
        data_sha256: digest of its tasks, from which scenes, goals and their frequencies are drawn.
        tier: how long certificates are.
        forms: which shapes goals have.
        actions: whether goals may ask for actions, where the data set's do.
        kind: what is special about them.
        by_place: whether instructions tell things of one kind by where they are, or what is so of them, and
            never by their names.
        most_objects: how many objects a scene has at most.
        depth: all plans of so many actions are tried, to bound the length of a plan from below.
        difficulty: between which expected difficulties tasks are (`eai.benchmarks.generator.measures`); None
            for any.
        at_least: measures, and how much of each a task has at least.
        split: which part of them.
        held_out: what the parts have nothing of in common.
        disturbances: how many things are brought about at most in a scene before the task begins.
        version: of the generator.
    """

    like: str
    data_sha256: str
    tier: Tier = Tier.DATA
    forms: Forms = "data"
    actions: bool = False
    kind: TaskKind = TaskKind.PLAIN
    by_place: bool = False
    most_objects: int = 30
    depth: int = 1
    difficulty: tuple[float, float] | None = None
    at_least: tuple[tuple[Measure, int], ...] = ()
    split: Split = Split.ALL
    held_out: HeldOut = "goals"
    disturbances: int = 4
    version: int = VERSION

    def __post_init__(self) -> None:
        if self.kind in (TaskKind.HAZARDS, TaskKind.UNTOLD) and self.version == VERSION:
            object.__setattr__(self, "version", HAZARDS_VERSION)

    @property
    def sha256(self) -> str:
        """Digest of all that tasks depend on, with those of older versions; what is told is no part of it."""
        said = asdict(self)
        kind = said.pop("kind")
        said["over_time"] = kind is TaskKind.ORDER
        if kind not in (TaskKind.PLAIN, TaskKind.ORDER):
            said["kind"] = kind.value.removeprefix("untold-")
        return hashlib.sha256(json.dumps(said, sort_keys=True).encode()).hexdigest()

    def rng(self, seed: str) -> random.Random:
        """The source of all that is random in the task of a seed."""
        digest = hashlib.sha256(f"{self.sha256} {seed}".encode()).digest()
        return random.Random(digest)  # noqa: S311 - tasks, not secrets
