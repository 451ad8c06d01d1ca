"""Compare success on public tasks, whose answers a model may know, with success on fresh tasks.

Only similar tasks are compared. A stratum contains tasks with about equal plan length, number of goals and
kinds of goals. Fresh tasks are weighted so that each stratum weighs as much as in the public set
(post-stratification). A stratum with tasks of one set only is left out.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterator, Sequence
from typing import TypeAlias

from eai.abilities.declaration import get_declaration
from eai.abilities.verdict import PlanVerdict, make_rate_contribution_of_answer
from eai.base.errors import InputError
from eai.benchmarks.names import remove_prompt_variant_endings
from eai.benchmarks.registry import list_benchmarks
from eai.results.certainty import TaskRateContribution
from eai.results.rate import compute_rate
from eai.results.record import Record
from eai.results.runs import Run
from eai.results.table import Estimate, Row, collect_rows_in_table
from eai.studies.records import StudyRecords
from eai.studies.study import Analysis, Study
from eai.tasks.options import Options
from eai.tasks.share import Share

STEP_BOUNDS = (4, 8, 12, 20)
"""Upper bounds, in steps, of the groups of tasks with similar plan lengths.

A task's length is that of its plan in the data set, or of the plan that proves a generated task solvable.
"""

GOAL_BOUNDS = (1, 2, 4, 8)
"""Upper bounds of the groups of tasks with a similar number of goals."""

_REMARKS = (
    "A difference below zero means that fresh tasks are harder than public tasks with equally long plans, "
    "equally many goals and goals of equal kinds. Known answers are one reason. Other reasons are unmatched "
    "properties: combinations of goals, the objects in scenes, the wording of instructions.",
    "A model that knows no answers (eai/planner, or a model trained before the tasks were published) shows "
    "how much of the difference comes from unmatched properties. Compare other models with it.",
    "A difference of zero does not prove that the model knows no answers: memory may not help.",
)


StratifiedCase: TypeAlias = tuple[TaskRateContribution, Hashable]
"""The contribution of one task to a rate, and the task's stratum (group of similar tasks)."""


def keep_and_weight_tasks_of_shared_strata(
    first: Sequence[StratifiedCase], second: Sequence[StratifiedCase]
) -> tuple[list[TaskRateContribution], list[TaskRateContribution]]:
    """Return the tasks of two sets, without the strata (groups of similar tasks) that only one set has.

    Weights make each stratum of the second set as heavy as in the first set. Names of tasks get a prefix, so
    that no name is in both sets. Strata reduce the variance of the difference between the sets. Confidence
    intervals do not use this, so they are too wide rather than too narrow.
    """
    sizes, others = (Counter(stratum for _, stratum in cases) for cases in (first, second))
    return (
        [
            _weight_contribution_and_prefix_task_names(case, "first")
            for case, stratum in first
            if stratum in others
        ],
        [
            _weight_contribution_and_prefix_task_names(case, "second", sizes[stratum] / others[stratum])
            for case, stratum in second
            if sizes[stratum]
        ],
    )


def _weight_contribution_and_prefix_task_names(
    contribution: TaskRateContribution, prefix: str, weight: float = 1
) -> TaskRateContribution:
    share = Share(weight * contribution.share.numerator, weight * contribution.share.denominator)
    return TaskRateContribution(f"{prefix} {contribution.task}", f"{prefix} {contribution.name}", share)


RunPair: TypeAlias = tuple[str, str, Sequence[Record], Sequence[Record]]
"""A model, the name of a benchmark and ability, and the verdicts on its answers to public and fresh tasks."""


@collect_rows_in_table(
    "contamination",
    (
        "answers_of",
        "fresh_suite",
        "public",
        "fresh",
        "public_alike",
        "fresh_alike",
        "difference",
        "public_tasks",
        "fresh_tasks",
    ),
)
def make_contamination_table(pairs: Sequence[RunPair]) -> Iterator[Row]:
    """Public and fresh tasks.

    Fresh tasks are generated, and their answers are not public. public, fresh: success in percent of all
    public and of all fresh tasks. public_alike, fresh_alike: success on similar tasks only, which have about
    equal plan lengths, numbers and kinds of goals. Fresh tasks get weights, so that each group of similar
    tasks weighs as much as its public tasks. difference: fresh_alike minus public_alike in percentage points,
    with 95 % intervals. For the intervals, all tasks with one name count as one unit.
    """
    for model, suite, public, fresh in pairs:
        placed = [list(_assign_strata(records)) for records in (public, fresh)]
        rates = [Estimate.from_task_rate_contributions([case for case, _ in each]) for each in placed]
        ones, others = keep_and_weight_tasks_of_shared_strata(*placed)
        percents = [compute_rate(case.share for case in cases).percent for cases in (ones, others)]
        difference = Estimate.estimate_rate_difference(ones, others)
        yield (model, suite, *rates, *percents, difference, len(ones), len(others))


def _assign_strata(records: Sequence[Record]) -> Iterator[StratifiedCase]:
    """Yield each scored task's contribution to the success rate, and its stratum (group of similar tasks)."""
    for record in records:
        verdict, task = record.verdict, record.task
        if isinstance(verdict, PlanVerdict) and verdict.excluded is None and task is not None:
            kinds = () if verdict.goals is None else tuple([share.denominator > 0 for share in verdict.goals])
            steps = None if task.annotated_steps is None else _find_bin(task.annotated_steps, STEP_BOUNDS)
            case = TaskRateContribution(
                record.task_id, task.name, make_rate_contribution_of_answer(verdict.success)
            )
            yield case, (steps, _find_bin(task.goals, GOAL_BOUNDS), kinds)


def _find_bin(number: int, bounds: Sequence[int]) -> int:
    return sum([number > bound for bound in bounds])


def _analyze_contamination(records: StudyRecords, chosen: Options) -> Iterator[Analysis]:
    """Compare each run on a benchmark with the same model's runs on generated tasks of the same world.

    A model may know answers to the benchmark's public tasks, but not to generated tasks. Files of generated
    tasks are named after their benchmark: `lamps-tasks` after `lamps`.

    Raises:
        InputError: no model has runs on a benchmark and on such a task file.
    """
    pairs = list(_pair_public_with_fresh_runs(list(records.read_runs())))
    if not pairs:
        raise InputError(
            "contamination needs runs of one model on a benchmark, such as lamps, and on a file of generated "
            "tasks whose name begins with the benchmark's name, such as lamps-tasks; generate tasks with "
            "eai generate, and run the model on both"
        )
    yield Analysis([make_contamination_table(pairs)], remarks=_REMARKS)


def _pair_public_with_fresh_runs(runs: Sequence[Run]) -> Iterator[RunPair]:
    for public in runs:
        for fresh in runs:
            one, other = public.key, fresh.key
            alike = (
                one._replace(domain=other.domain) == other and get_declaration(one.ability).answers_are_plans
            )
            if alike and _is_name_of_fresh_tasks(one.domain, other.domain):
                suite = f"{other.domain} {one.ability.value}"
                yield one.name, suite, public.records, fresh.records


def _is_name_of_fresh_tasks(public: str, fresh: str) -> bool:
    """Whether the second benchmark has tasks generated from the first, to judge by the two names.

    The prompts of both have the same kind.
    """
    world, plain = remove_prompt_variant_endings(public), remove_prompt_variant_endings(fresh)
    worlds = [name for name in (*list_benchmarks(), world) if f"{plain}-".startswith(f"{name}-")]
    has_equal_prompts = public.removeprefix(world) == fresh.removeprefix(plain)
    return has_equal_prompts and plain != world and max(worlds, key=len, default="") == world


CONTAMINATION = Study(
    "contamination",
    "Success on public tasks and on fresh tasks, and the difference on similar tasks.",
    analyze=_analyze_contamination,
)
