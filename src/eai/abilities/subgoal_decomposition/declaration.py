"""Subgoal decomposition as a registered ability: how it is asked and counted, and its verdicts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from typing import TYPE_CHECKING

from typing_extensions import Self

from eai.abilities.declaration import (
    COLUMNS,
    AskedWorld,
    Form,
    MetricColumn,
    SingleTurn,
    goal_shares,
    on_trajectories,
    times,
    times_additional,
)
from eai.abilities.protocol import Ability
from eai.abilities.verdict import Merit, PlanVerdict, Share, of_all
from eai.world.fault import FaultKind

if TYPE_CHECKING:
    from eai.abilities.scorer import Scorer
    from eai.abilities.task import Task


class SubgoalCategory(str, Enum):
    """The outcomes of subgoal decomposition (reference: ``subgoal_eval_utils.py``)."""

    CORRECT = "correct"
    RUNTIME = "runtime"
    GOAL_UNREACHABLE = "goal_unreachable"
    HALLUCINATION = "hallucination"
    NOT_PARSEABLE = "not_parseable"


@dataclass(frozen=True, slots=True)
class SubgoalVerdict(PlanVerdict):
    """The verdict on a sequence of subgoals.

    Attributes:
        category: the outcome.
        goals_elsewhere: whether the goals are those of another way to carry the subgoals out than the
            reported one, which reaches fewer.
        errors: the kinds of all errors of the reported way to carry them out, in order.
        offences: what is wrong with names, each kind once.
        search: why the search for a way ended, or None if there was none.
        tried_actions: number of actions that the search tried.
        refined: for how many subgoals actions were executed, on the reported way.
        added_actions: how many more actions than one for each of them.
    """

    category: SubgoalCategory | None = None
    goals_elsewhere: bool = False
    errors: tuple[FaultKind, ...] = ()
    offences: tuple[str, ...] = ()
    search: str | None = None
    tried_actions: int | None = None
    refined: int | None = None
    added_actions: int | None = None

    def faults(self) -> Mapping[FaultKind, int]:
        """All errors of the way that is reported, or else those of any plan."""
        return Counter(self.errors) or PlanVerdict.faults(self)

    def merit(self, at_start: Sequence[bool]) -> Merit | None:
        """As of any plan, with what the search added."""
        earned = PlanVerdict.merit(self, at_start)
        return None if earned is None else replace(earned, added=self.added_actions or 0)

    def without_answer(self) -> Self:
        """As of any plan; there is no outcome."""
        unanswered = PlanVerdict.without_answer(self)
        return unanswered if self.excluded is not None else replace(unanswered, category=None)


_RUNTIME_FAULTS = (FaultKind.WRONG_ORDER, FaultKind.MISSING_STEP, FaultKind.AFFORDANCE)
_EXECUTED = (SubgoalCategory.CORRECT, SubgoalCategory.GOAL_UNREACHABLE)


def contributions(verdict: SubgoalVerdict) -> dict[str, Share]:
    """The contributions of one answer to each rate.

    What cannot be carried out counts by its category, and as a wrong number of arguments where that is the
    error; what goes wrong on the way counts as the verdict says, or as `Counted`. ``granularity`` is how many
    actions had to be added to one for each subgoal that actions were executed for.
    """
    category = verdict.category
    wrong_arity = verdict.error is not None and verdict.error.kind is FaultKind.ARGUMENT_NUMBER
    unknown = category is SubgoalCategory.HALLUCINATION and not wrong_arity
    return {
        "task_success": of_all(category is SubgoalCategory.CORRECT),
        "execution_success": of_all(category in _EXECUTED),
        "parsing": of_all(category is SubgoalCategory.NOT_PARSEABLE),
        "hallucination": of_all(unknown),
        "argument_number": of_all(wrong_arity),
        **{kind.value: of_all(times(verdict, kind)) for kind in _RUNTIME_FAULTS},
        "additional_step": of_all(times_additional(verdict)),
        "goal_unreachable": of_all(category is SubgoalCategory.GOAL_UNREACHABLE),
        "granularity": Share(verdict.added_actions or 0, verdict.refined or 0),
        **goal_shares(verdict),
    }


def _scorers(world: AskedWorld) -> Callable[[Task], Scorer]:
    """The maker of scorers, imported where it is needed, so that reports load no search."""
    from eai.abilities.subgoal_decomposition.refinement import Refinement
    from eai.abilities.subgoal_decomposition.scorer import SubgoalDecomposition

    domain = world.subgoal_domain()
    return partial(
        SubgoalDecomposition, domain=domain, notation=world.subgoals, refinement=Refinement(domain)
    )


def _form(world: AskedWorld, task: Task | None) -> tuple[Sequence[str], Form]:
    from eai.abilities.notation.subgoals import SubgoalNotation

    subgoals = world.subgoals or SubgoalNotation(world.domain)
    return (), lambda words: subgoals.schema()


SUBGOAL_DECOMPOSITION = replace(
    on_trajectories(
        Ability.SUBGOAL_DECOMPOSITION,
        SingleTurn(_scorers, form=_form, bare=None),
        "Subgoal decomposition",
        "subgoals",
        SubgoalVerdict,
        contributions,
    ),
    columns=(*COLUMNS, MetricColumn("granularity", "Added by search", "Granularity", False)),
)
