"""Reward functions for training libraries, for single answers or step by step, without importing a library.

Every row of a training data set names its task as `Suite.reference` does; ``eai export prompts`` writes such
rows. So one data set may mix benchmarks and abilities. Rewards are those of `eai.Reward`.
``docs/training.md`` explains how each library is configured.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain, groupby
from operator import itemgetter
from typing import Any, TypeAlias

from eai.abilities.reasoning import split_answer_and_reasoning
from eai.agents.game import Game
from eai.agents.reference import find_setup
from eai.agents.rules import TRAINING, GameRules
from eai.base.errors import find_enum_member
from eai.benchmarks.names import TaskReference
from eai.results.reward import METRICS, Grade, Shaping, open_reward, require_equal_lengths
from eai.results.workers import WorkerPool

Completion: TypeAlias = str | list[Mapping[str, Any]] | tuple[Mapping[str, Any], ...]
"""The output of a policy (a model in training): a text, or messages that end with the answer."""

PROMPT_NOT_FOUND = "prompt_not_found"
"""Name of the metric that is 1 if the answer cannot be separated from its prompt, else 0."""

_POLICY_ROLE = "assistant"
"""Role of messages that the policy wrote. A last message with another role is no answer."""

_SPECIAL_TOKENS = re.compile(r"(?<!\s)(?:\s*(?:<\|[^<>|]*\|>|</s>|<eos>|<pad>|<end_of_turn>))+\s*\Z")
"""Pattern of the special tokens of tokenizers at the end of a decoded text."""


def extract_answer(completion: Completion) -> str:
    """Return the answer in the output of a policy: its last message without reasoning.

    The content of a message is a text or a list of parts, in which only parts of the type ``text`` count.
    If the output is None, the answer is empty.

    Raises:
        TypeError: the output is neither a text nor a list of messages, or the content of the last message is
            neither a text nor a list.
    """
    if isinstance(completion, str):
        return split_answer_and_reasoning(completion)[0]
    if completion is not None and not isinstance(completion, list | tuple):
        raise TypeError(f"expected an output as text or list of messages, not {type(completion).__name__}")
    last = completion[-1] if completion else {}
    if not isinstance(last, Mapping):
        raise TypeError(f"expected a message as a mapping with role and content, not {type(last).__name__}")
    if last.get("role", _POLICY_ROLE) != _POLICY_ROLE:
        return ""
    return split_answer_and_reasoning(_extract_text(last.get("content")))[0]


def _extract_text(content: object) -> str:
    """Return the text of a message's content; empty if a message calls tools without a text."""
    if content is None or isinstance(content, str):
        return content or ""
    if not isinstance(content, list | tuple):
        raise TypeError(f"expected the content of a message as text or parts, not {type(content).__name__}")
    texts = [part if isinstance(part, str) else part.get("text") for part in content if _is_text_part(part)]
    return "".join([text for text in texts if isinstance(text, str)])


def _is_text_part(part: object) -> bool:
    return isinstance(part, str) or (isinstance(part, Mapping) and part.get("type", "text") == "text")


def grade_answer(task: str, text: str, shaping: Shaping | str = Shaping.SUCCESS) -> Grade:
    """Return the reward of an answer to a task, with metrics and errors that explain the reward.

    Args:
        task: the task, as ``BENCHMARK/ABILITY/TASK``.
        text: the answer.
        shaping: the definition of the reward.

    Raises:
        InputError: the task or the shaping does not exist.
    """
    reference = TaskReference.parse(task)
    return open_reward(reference, shaping).grade(reference.task_id, text)


@dataclass(frozen=True)
class TrlReward:
    """A reward function of TRL: ``GRPOTrainer(reward_funcs=TrlReward("progress"), ...)``.

    The data set has a column ``task``. The reward is None if nothing can be earned; TRL leaves such rewards
    out. Metrics are logged as ``eai/NAME``, the mean over a batch.

    Attributes:
        shaping: the definition of the reward.
        pool: processes that compute rewards, such as ``eai.Scoring(workers=8)``; None for this process.
    """

    shaping: Shaping | str = Shaping.SUCCESS
    pool: WorkerPool | None = None

    @property
    def __name__(self) -> str:
        """The name under which TRL logs the reward."""
        return f"eai_{find_enum_member(Shaping, self.shaping, 'shaping').value}"

    def __call__(
        self,
        *,
        completions: Sequence[Completion],
        task: Sequence[str],
        log_metric: Callable[[str, float], None] | None = None,
        **others: object,
    ) -> list[float | None]:
        """Return the rewards of a batch's answers, in order.

        Other arguments of TRL (``others``) are ignored.
        """
        require_equal_lengths(task=task, completions=completions)
        # Scoring the first answer to a task takes longest, so one worker scores all answers to a task.
        by_task = groupby(zip(task, completions, strict=True), itemgetter(0))
        groups = [(name, [completion for _, completion in pairs]) for name, pairs in by_task]
        pool = self.pool or WorkerPool()
        results = pool.map_batches(partial(_grade_groups, self.shaping), groups, batch_sizes=(1, 1))
        grades = list(chain.from_iterable(results))
        if log_metric is not None and grades:
            for metric in METRICS:
                log_metric(f"eai/{metric}", sum(grade.metrics[metric] for grade in grades) / len(grades))
        return [grade.value for grade in grades]


def _grade_groups(
    shaping: Shaping | str, groups: Sequence[tuple[str, Sequence[Completion]]]
) -> list[list[Grade]]:
    return [
        [grade_answer(task, extract_answer(completion), shaping) for completion in completions]
        for task, completions in groups
    ]


class TrlEnvironment:
    """An environment of TRL, played by actions: ``GRPOTrainer(environment_factory=TrlEnvironment, ...)``.

    The data set has a column ``task`` with tasks of action sequencing. The tool is `act`. An episode ends
    when all goals are reached or 50 actions are tried, or by other rules, such as
    `eai.agents.rules.STANDARD`.
    """

    def __init__(self, shaping: Shaping | str = Shaping.SUCCESS, rules: GameRules = TRAINING) -> None:
        self._rules = rules.model_copy(update={"reward": find_enum_member(Shaping, shaping, "shaping")})
        self._game: Game | None = None

    def reset(self, *, task: str, **others: object) -> str:
        """Begin an episode. Return the text about the world and the task, which an agent reads first."""
        self._game = Game(find_setup(task, self._rules))
        return self._game.write_manual_and_first_observation()

    def act(self, command: str) -> str:
        """Carry out one action in the household.

        Args:
            command: The action with its objects on one line, such as OPEN(fridge.7).

        Returns:
            What became of it, and all that is seen now.
        """
        if self._game is None or self._game.is_over:
            return "The episode is over."
        return self._game.act(command).observation

    def get_reward(self) -> float:
        """Return the value of the episode up to now, as `eai.Reward` defines it."""
        return 0.0 if self._game is None else self._game.reward_if_ended_now


def compute_score(
    data_source: str,
    solution_str: str,
    ground_truth: str,
    extra_info: Mapping[str, Any] | None = None,
    *,
    shaping: Shaping | str = Shaping.SUCCESS,
    **others: object,
) -> dict[str, float]:
    """Return the reward and metrics of an answer, as a reward function of verl.

    Write ``custom_reward_function: {path: pkg://eai.agents.rewards, name: compute_score}``. Add
    ``reward_kwargs: {shaping: progress}`` for another definition of the reward.

    Args:
        data_source: ignored; the task names its benchmark.
        solution_str: the answer.
        ground_truth: the task.
        extra_info: ignored.
        shaping: the definition of the reward.
        others: other arguments that verl passes; ignored.

    Returns:
        The reward as ``score``, 0 if nothing can be earned, and all metrics.
    """
    grade = grade_answer(ground_truth, extract_answer(solution_str), shaping)
    return {"score": grade.value or 0.0, **grade.metrics}


def reward_func(
    queries: Sequence[str],
    prompts: Sequence[str],
    labels: Sequence[str],
    *,
    shaping: Shaping | str = Shaping.SUCCESS,
    **others: object,
) -> dict[str, Any]:
    """Return rewards and metrics, as a reward function of OpenRLHF: ``--reward.remote_url FILE``.

    FILE imports this function, or defines ``reward_func = functools.partial(reward_func,
    shaping="progress")`` for another definition of the reward. If a query does not contain its prompt, this
    function cannot tell the answer from examples in the prompt. The reward is then 0, ``prompt_not_found`` is
    1, and a warning is issued.

    Args:
        queries: prompts with answers, decoded with special tokens.
        prompts: the prompts; if a prompt is empty, the query is only the answer.
        labels: the tasks.
        shaping: the definition of the reward.
        others: other arguments that OpenRLHF passes; ignored.

    Returns:
        ``rewards``, ``scores`` (equal to ``rewards``), and metrics with ``prompt_not_found`` as
            ``extra_logs``: numbers for a single answer, as OpenRLHF expects, lists for several answers.
    """
    require_equal_lengths(queries=queries, prompts=prompts, labels=labels)
    texts = [_get_text_after_prompt(prompt, query) for prompt, query in zip(prompts, queries, strict=True)]
    is_lost = [text is None for text in texts]
    if any(is_lost):
        warning = f"{sum(is_lost)} of {len(is_lost)} queries do not contain their prompt: their reward is 0"
        warnings.warn(warning, stacklevel=2)
    grades = [
        grade_answer(task, extract_answer(text or ""), shaping)
        for task, text in zip(labels, texts, strict=True)
    ]

    def unwrap_single_value(values: list[float]) -> float | list[float]:
        return values[0] if len(values) == 1 else values

    paid = unwrap_single_value([grade.value or 0.0 for grade in grades])
    logs = {metric: unwrap_single_value([grade.metrics[metric] for grade in grades]) for metric in METRICS}
    logs[PROMPT_NOT_FOUND] = unwrap_single_value([float(value) for value in is_lost])
    return {"rewards": paid, "scores": paid, "extra_logs": logs}


def _get_text_after_prompt(prompt: str, query: str) -> str | None:
    """Return the text after a prompt in a query, without special tokens; None if the prompt is absent."""
    position = query.find(prompt)
    return None if position < 0 else _SPECIAL_TOKENS.sub("", query[position + len(prompt) :])


class SkyRlTask:
    """A single-turn environment of SkyRL, to combine with SkyRL's base class (not imported here).

    ``class Household(SkyRlTask, BaseTextEnv): pass`` is registered by its module path. Rows of the data have
    ``reward_spec: {"ground_truth": TASK}``, and may have ``shaping`` (the name of a `Shaping`).
    """

    def __init__(self, env_config: object = None, extras: Mapping[str, Any] | None = None) -> None:
        super().__init__()
        extras = extras or {}
        self._task: str = extras["reward_spec"]["ground_truth"]
        self._shaping = find_enum_member(Shaping, extras.get("shaping", Shaping.SUCCESS), "shaping")
        self._metrics: Mapping[str, float] = {}

    def step(self, action: str) -> dict[str, Any]:
        """Return the reward of the answer, with the other fields of a SkyRL step.

        The episode ends with this step.
        """
        grade = grade_answer(self._task, extract_answer(action), self._shaping)
        self._metrics = grade.metrics
        return {
            "observations": [],
            "reward": grade.value or 0.0,
            "done": True,
            "metadata": dict(grade.metrics),
        }

    def get_metrics(self) -> dict[str, float]:
        """Return the metrics of the last answer, by name."""
        return dict(self._metrics)
