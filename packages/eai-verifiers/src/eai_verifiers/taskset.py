"""The taskset of whole answers, in all four abilities."""

from __future__ import annotations

from collections.abc import Iterator

import verifiers.v1 as vf

from eai.abilities.protocol import Ability
from eai.agents.rewards import answer_of
from eai.benchmarks.generator.spec import Split, Tier
from eai.benchmarks.gold_answers import open_answer_book
from eai.benchmarks.names import TaskReference
from eai.results.reward import Grade, Reward, Shaping, open_reward
from eai.tasks.prompts.prompt import PromptSet
from eai_verifiers.tasks import Asked, new_tasks, own_tasks, suite_of_one


class HouseholdData(vf.TaskData):
    """One task: its name, and all of it where it has been made anew."""

    task: str
    line: str | None = None


class HouseholdTaskConfig(vf.TaskConfig):
    """What is paid for."""

    shaping: Shaping = Shaping.SUCCESS
    """``success``, ``goals``, ``progress``, ``diagnosis``, ``repair`` or ``partial``."""


class HouseholdConfig(vf.TasksetConfig):
    """Which tasks there are."""

    domain: str = "virtualhome"
    """A benchmark: ``virtualhome``, ``behavior``, ``module:object``, a task file or a folder of them."""
    ability: Ability = Ability.ACTION_SEQUENCING
    """Which of the four abilities is asked for."""
    prompts: PromptSet = "official"
    """The data set's prompts, where it has some, or ours; about new tasks ours."""
    generated: bool = False
    """Instead of the benchmark's own tasks, new ones in its world, without end."""
    seed: int = 0
    """Of new tasks."""
    split: Split = Split.TRAIN
    """Of new tasks: those of ``train``, ``validation`` and ``test`` have no goals in common."""
    tier: Tier = Tier.DATA
    """Of new tasks: how long plans are, from ``S`` to ``XXL``; ``data`` is as in the data set."""
    task: HouseholdTaskConfig = HouseholdTaskConfig()


class HouseholdTask(vf.Task[HouseholdData, vf.State, HouseholdTaskConfig]):
    """One task, of which the last reply is the answer, without what was thought."""

    @vf.reward
    async def household(self, trace: vf.Trace) -> float:
        """What the answer is worth; 0 where nothing can be earned."""
        return self.grade(trace.last_reply).value or 0.0

    @vf.metric
    async def faults(self, trace: vf.Trace) -> dict[str, float]:
        """How often each kind of fault was diagnosed, success and progress."""
        return dict(self.grade(trace.last_reply).metrics)

    async def validate(self, runtime: vf.Runtime) -> bool:
        """Whether the gold answer earns everything, as ``vf-validate`` asks."""
        task, suite = TaskReference.parse(self.data.task), self.paid().suite
        book = open_answer_book(suite.benchmark, suite.ability, suite.source)
        return self.grade(book[task.task_id].text).value == 1

    def grade(self, reply: str) -> Grade:
        """What a reply is worth, and why."""
        return self.paid().grade(TaskReference.parse(self.data.task).task_id, answer_of(reply))

    def paid(self) -> Reward:
        """What is paid for, of the benchmark's suite or that of the task alone."""
        task, shaping = TaskReference.parse(self.data.task), self.config.shaping
        if self.data.line is None:
            return open_reward(task, shaping)
        return Reward(suite_of_one(self.data.line, task.ability), shaping)


class HouseholdTaskset(vf.Taskset[HouseholdTask, HouseholdConfig]):
    """The tasks of a benchmark, or new ones in its world without end."""

    def __init__(self, config: HouseholdConfig) -> None:
        super().__init__(config)
        self.INFINITE = config.generated

    def asked(self) -> Iterator[Asked]:
        """The tasks with their prompts."""
        config = self.config
        if config.generated:
            yield from new_tasks(config.domain, config.ability, config.split, config.seed, config.tier)
        else:
            yield from own_tasks(config.domain, config.ability, config.prompts)

    def load(self) -> Iterator[HouseholdTask]:
        """The tasks in which something can be earned, in order."""
        for each in self.asked():
            data = HouseholdData(
                id=each.task,
                name=each.task,
                prompt=each.prompt.user,
                system_prompt=each.prompt.system,
                task=each.task,
                line=each.line,
            )
            task = HouseholdTask(data, self.config.task)
            if task.grade("").value is not None:
                yield task
