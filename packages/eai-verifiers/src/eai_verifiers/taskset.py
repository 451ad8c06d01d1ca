"""The verifiers taskset of whole answers, for all four abilities."""

from __future__ import annotations

from collections.abc import Iterator

import verifiers.v1 as vf

from eai.abilities.protocol import Ability
from eai.agents.rewards import extract_answer
from eai.benchmarks.generator.spec import PlanLengthTier, TaskSplit
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.names import TaskReference
from eai.results.reward import Grade, Reward, Shaping, open_reward
from eai.tasks.prompts.prompt import PromptSet
from eai_verifiers.tasks import (
    TaskWithPrompt,
    generate_tasks,
    iterate_benchmark_tasks,
    make_single_task_suite,
)


class HouseholdData(vf.TaskData):
    """One task: its reference, and its line of a task file if it is generated."""

    task: str
    line: str | None = None


class HouseholdTaskConfig(vf.TaskConfig):
    """Options of the reward of a task."""

    shaping: Shaping = Shaping.SUCCESS
    """``success``, ``goals``, ``progress``, ``diagnosis``, ``repair`` or ``partial``."""


class HouseholdConfig(vf.TasksetConfig):
    """Choice of the tasks."""

    domain: str = "virtualhome"
    """A benchmark: ``virtualhome``, ``behavior``, ``module:object``, a task file or a folder of them."""
    ability: Ability = Ability.ACTION_SEQUENCING
    """The ability to test, one of four."""
    prompts: PromptSet = "official"
    """The data set's prompts if it has some, or those of `eai`; generated tasks always have the latter."""
    generated: bool = False
    """Whether to generate new tasks in the benchmark's world without end, instead of its own tasks."""
    seed: int = 0
    """Seed of generated tasks."""
    split: TaskSplit = TaskSplit.TRAIN
    """Split of generated tasks: ``train``, ``validation`` and ``test`` have no common goals."""
    tier: PlanLengthTier = PlanLengthTier.DATA
    """Length of generated tasks' plans, from ``S`` to ``XXL``; ``data`` is that of the data set's plans."""
    task: HouseholdTaskConfig = HouseholdTaskConfig()


class HouseholdTask(vf.Task[HouseholdData, vf.State, HouseholdTaskConfig]):
    """One task. The answer is the last reply without its reasoning."""

    @vf.reward
    async def household(self, trace: vf.Trace) -> float:
        """Return the reward of the answer, or 0 if the task can pay no reward."""
        return self.grade(trace.last_reply).value or 0.0

    @vf.metric
    async def faults(self, trace: vf.Trace) -> dict[str, float]:
        """Return metrics: the number of faults of each kind, success and progress."""
        return dict(self.grade(trace.last_reply).metrics)

    async def validate(self, runtime: vf.Runtime) -> bool:
        """Return whether the gold answer earns the full reward, for ``vf-validate``."""
        task, suite = TaskReference.parse(self.data.task), self.open_reward_function().suite
        gold_answers = open_gold_answers(suite.benchmark, suite.ability, suite.source)
        return self.grade(gold_answers[task.task_id].text).value == 1

    def grade(self, reply: str) -> Grade:
        """Return the reward of a reply with its reasons."""
        return self.open_reward_function().grade(
            TaskReference.parse(self.data.task).task_id, extract_answer(reply)
        )

    def open_reward_function(self) -> Reward:
        """Return the reward function: of the benchmark's suite, or of the generated task alone."""
        task, shaping = TaskReference.parse(self.data.task), self.config.shaping
        if self.data.line is None:
            return open_reward(task, shaping)
        return Reward(make_single_task_suite(self.data.line, task.ability), shaping)


class HouseholdTaskset(vf.Taskset[HouseholdTask, HouseholdConfig]):
    """The tasks of a benchmark, or generated tasks in its world without end."""

    def __init__(self, config: HouseholdConfig) -> None:
        super().__init__(config)
        self.INFINITE = config.generated

    def iterate_tasks(self) -> Iterator[TaskWithPrompt]:
        """Yield the tasks with their prompts."""
        config = self.config
        if config.generated:
            yield from generate_tasks(config.domain, config.ability, config.split, config.seed, config.tier)
        else:
            yield from iterate_benchmark_tasks(config.domain, config.ability, config.prompts)

    def load(self) -> Iterator[HouseholdTask]:
        """Yield the tasks that can pay a reward, in order."""
        for task_with_prompt in self.iterate_tasks():
            data = HouseholdData(
                id=task_with_prompt.task,
                name=task_with_prompt.task,
                prompt=task_with_prompt.prompt.user,
                system_prompt=task_with_prompt.prompt.system,
                task=task_with_prompt.task,
                line=task_with_prompt.line,
            )
            task = HouseholdTask(data, self.config.task)
            if task.grade("").value is not None:
                yield task
