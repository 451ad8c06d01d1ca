"""Makes training data: prompts for reinforcement learning, labelled or verified answers, and answer pairs.

A row is a JSON object. ``prompt``, ``completion``, ``chosen`` and ``rejected`` are lists of messages, as in
TRL; ``task`` is the reference of the task for `eai.reward`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from operator import itemgetter
from typing import Any, TypeAlias

from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.explanation import EXECUTED
from eai.abilities.notation.plan_form import WrittenPlan
from eai.abilities.plan_distance import StepLabeler, make_labeler_of_step_distances_to_goals
from eai.abilities.verdict import ErrorReport
from eai.benchmarks.suite import Suite
from eai.results.batch import Scoring
from eai.results.record import Record
from eai.results.reward import Reward
from eai.tasks.prompts.prompt import Prompt

TrainingRow: TypeAlias = dict[str, Any]


def make_prompt_rows(reward: Reward, prompts: Mapping[str, Prompt]) -> Iterator[TrainingRow]:
    """Yield a row for each task that has a reward, in the order of the data set.

    Further columns name the task for verl (``data_source``, ``reward_model``) and SkyRL (``env_class``,
    ``reward_spec``).
    """
    suite = reward.suite
    for task_id in suite.task_ids:
        if reward(task_id, "") is None:
            continue
        task = suite.reference(task_id)
        yield {
            "prompt": _make_messages(prompts[task_id]),
            "task": task,
            "data_source": f"{suite.domain}/{suite.ability.value}",
            "reward_model": {"style": "rule", "ground_truth": task},
            "env_class": "eai",
            "reward_spec": {"method": "rule", "ground_truth": task},
        }


NO_ANSWER = "without an answer, or with nothing to earn"
EXPERIMENT = "of experiments, which ask other questions"
_PROMPTS = "prompts"
"""Name of the study that rewords questions, as records store it in the options of their run."""

ASKED_OTHERWISE = "answering another prompt than is exported"
NOT_PAID = "of an ability whose verdicts do not say what an answer has earned"
"""Reason why a record gives no training data: its ability (kind of question) has no rewards."""
NO_STEPS = "without a plan of actions that can be read"

AddColumns: TypeAlias = Callable[[Record], "TrainingRow | None"]
"""Function that returns further columns of training data for a record, or None to leave the record out."""


def make_reward_rows(
    records: Iterable[Record],
    reward: Reward,
    prompts: Mapping[str, Prompt],
    left_out: Counter[str],
    add_columns: AddColumns = lambda record: {},
    scoring: Scoring | None = None,
) -> Iterator[TrainingRow]:
    """Yield a row for each answer in records of one ability in a benchmark, with its prompt and its reward.

    The numbers of records without a row are added to ``left_out``, by reason. The processes of ``scoring``
    compute the rewards; if ``scoring`` is None, this process computes them.
    """
    records = list(records)
    answers = [
        (record.task_id, record.response)
        for record in records
        if record.unanswered is None and not _has_unknown_prompt(record)
    ]
    rewards = (scoring or Scoring()).compute_rewards(reward, answers)
    for record in records:
        prompt_sha256 = None if record.origin is None else record.origin.prompt_sha256
        if _has_unknown_prompt(record):
            left_out[EXPERIMENT] += 1
            continue
        value = None if record.unanswered is not None else next(rewards)
        if value is None:
            left_out[NO_ANSWER] += 1
            continue
        prompt = prompts[record.task_id]
        if prompt_sha256 not in (None, prompt.sha256):
            left_out[ASKED_OTHERWISE] += 1
            continue
        columns = add_columns(record)
        if columns is None:
            left_out[NO_STEPS] += 1
            continue
        yield {
            "prompt": _make_messages(prompt),
            "completion": [{"role": "assistant", "content": record.response}],
            "task": reward.suite.reference(record.task_id),
            "model": record.model,
            "reward": value,
            **columns,
        }


def _has_unknown_prompt(record: Record) -> bool:
    """Whether the options of a record's run changed its question, so that the prompt cannot be rebuilt."""
    settings = record.experiment
    if settings is not None and record.origin is not None and record.origin.prompt_sha256 is not None:
        settings = settings.drop_options_of_study(_PROMPTS)  # the digest already identifies the prompt
    return settings is not None and not settings.has_standard_rules_and_no_study_options


def make_function_adding_goal_distance_and_steps(
    suite: Suite, search_effort: int, step_counts: Counter[str]
) -> AddColumns:
    """Return a function that makes the additional columns ``distance`` and ``steps`` of a record.

    Args:
        suite: the suite of the records.
        search_effort: the approximate limit of the search for each state, as in
            `make_labeler_of_step_distances_to_goals`.
        step_counts: counter to which the function adds the number of executed steps (``executed``), and the
            number of them whose change of the distance to the goal is known (``exact``).
    """
    labelers: dict[str, StepLabeler] = {}

    def make_goal_distance_and_step_columns(record: Record) -> TrainingRow | None:
        scorer = suite.scorer(record.task_id)
        plan = scorer.read(record.response) if isinstance(scorer, ActionSequencingScorer) else None
        if not isinstance(scorer, ActionSequencingScorer) or not isinstance(plan, WrittenPlan):
            return None
        if isinstance(actions := scorer.resolve_names(plan), ErrorReport):
            return None
        if record.task_id not in labelers:
            labelers[record.task_id] = make_labeler_of_step_distances_to_goals(scorer.repairer, search_effort)
        distance, labels = labelers[record.task_id](actions)
        executed = [label for label in labels if label.outcome == EXECUTED]
        step_counts["executed"] += len(executed)
        step_counts["exact"] += sum(label.change is not None for label in executed)
        return {"distance": distance, "steps": [label._asdict() for label in labels]}

    return make_goal_distance_and_step_columns


def select_verified_rows(rows: Iterable[TrainingRow], min_reward: float) -> Iterator[TrainingRow]:
    """Yield the rows of answers with at least a minimum reward, without repeated answers to a task."""
    seen: set[tuple[str, str]] = set()
    for row in rows:
        key = (row["task"], _get_completion_text(row))
        if row["reward"] >= min_reward and key not in seen:
            seen.add(key)
            yield row


def make_preference_rows(rows: Iterable[TrainingRow], margin: float) -> Iterator[TrainingRow]:
    """Yield pairs of answers to one task: the best answer, and an answer with a lower reward.

    Of several best answers, the first one is used.

    Args:
        rows: the rows of answers.
        margin: the difference between the two rewards of a pair must be larger than this number.
    """
    by_task: dict[str, dict[str, TrainingRow]] = {}
    for row in rows:
        by_task.setdefault(row["task"], {}).setdefault(_get_completion_text(row), row)
    for task, distinct in by_task.items():
        best = max(distinct.values(), key=itemgetter("reward"))
        for other in distinct.values():
            difference = best["reward"] - other["reward"]
            if difference > margin:
                yield {
                    "prompt": best["prompt"],
                    "chosen": best["completion"],
                    "rejected": other["completion"],
                    "task": task,
                    "margin": difference,
                }


def _get_completion_text(row: TrainingRow) -> str:
    text: str = row["completion"][0]["content"]
    return text


def _make_messages(prompt: Prompt) -> list[TrainingRow]:
    system: list[TrainingRow] = (
        [] if prompt.system is None else [{"role": "system", "content": prompt.system}]
    )
    return [*system, {"role": "user", "content": prompt.user}]
