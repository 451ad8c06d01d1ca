"""What becomes of a seed: a task, or a reason why there is none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import TypeAlias

from eai.abilities.task import Task
from eai.abilities.verdict import Json


class Reason(str, Enum):
    """Why a seed gives no task."""

    NO_GOALS = "no goal was reached"
    TOO_SHORT = "the certificate is too short"
    TOO_LONG = "the certificate is too long"
    HOLDS_ALREADY = "a goal holds at the start"
    ONE_ACTION = "one action solves it"
    NO_CERTIFICATE = "the certificate does not solve it"
    AMBIGUOUS = "the instruction does not say exactly the goals"
    NAMELESS = "a thing cannot be told from others without its name"
    DIFFICULTY = "it is expected to be easier or harder than was asked for"
    TOO_LITTLE = "there is less in it of something than was asked for"
    NO_ORDER = "no goal over time was found that matters"
    OTHER_SPLIT = "its goals are those of another split"
    KNOWN_PLAN = "the plan of a task of another split with similar goals solves it, or its plan solves such"
    PUBLIC = "a public task has the same goals"
    PUBLIC_PLAN = "the plan of a public task with similar goals solves it"
    COPY = "another generated task is the same"


@dataclass(frozen=True, slots=True)
class Rejected:
    """No task, and why."""

    seed: str
    reason: Reason


@dataclass(frozen=True, slots=True)
class Generated:
    """A task with its certificate, which is its script, and what is known of it."""

    task: Task
    about: Mapping[str, Json]


Outcome: TypeAlias = "Generated | Rejected"
