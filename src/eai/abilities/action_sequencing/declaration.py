"""Action sequencing as a registered ability: how it is asked, judged and counted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from eai.abilities.declaration import (
    ENDING_FAULTS,
    Asked,
    AskedWorld,
    Form,
    goal_shares,
    on_trajectories,
    times,
    times_additional,
)
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict, of_all
from eai.tasks.share import Share

if TYPE_CHECKING:
    from eai.abilities.scorer import Scorer
    from eai.tasks.task import Task


def contributions(verdict: PlanVerdict) -> dict[str, Share]:
    """The contributions of one plan to each rate; it counts as its verdict says, or as `Counted` does."""
    counted = verdict.counted
    return {
        "task_success": of_all(verdict.success if counted is None else counted.success),
        "execution_success": of_all(verdict.executable),
        **{name: of_all(times(verdict, kind)) for name, kind in ENDING_FAULTS.items()},
        "additional_step": of_all(times_additional(verdict)),
        **goal_shares(verdict),
    }


def _scorers(world: AskedWorld) -> Callable[[Task], Scorer]:
    """The maker of scorers, imported where it is needed, so that reports load no engine."""
    from eai.abilities.action_sequencing.scorer import ActionSequencing

    return partial(ActionSequencing, domain=world.domain, notation=world.plans)


def _form(world: AskedWorld, task: Task | None) -> tuple[Sequence[str], Form]:
    """The names of a task's objects, and the form of a plan; none where an answer may be no plan."""
    if task is not None and task.missing is not None:
        return world.plans.words(task), lambda words: None
    words = () if task is None else world.plans.words(task)
    return words, lambda words: world.plans.schema(world.domain, words)


ACTION_SEQUENCING = on_trajectories(
    Ability.ACTION_SEQUENCING,
    Asked(_scorers, form=_form, keys_in_order=True, bare=None),
    "Action sequencing",
    "actions",
    PlanVerdict,
    contributions,
)
