"""The benchmark as Inspect tasks, for ``eai run`` and for ``inspect eval eai/...`` alike."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import inspect_ai
from inspect_ai.dataset import MemoryDataset, Sample
from inspect_ai.model import ChatMessage, ChatMessageSystem, ChatMessageUser, GenerateConfig
from inspect_ai.scorer import Score, Scorer, Target, mean, scorer, stderr
from inspect_ai.solver import Solver, TaskState
from inspect_ai.util import registry_info

from eai.abilities.codec import fields_of
from eai.abilities.declarations import DECLARATIONS
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.verdict import Verdict
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.prompt_library import Library
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import DEFAULT_PROTOCOL, Suite, open_suite
from eai.metrics.rate import Rate
from eai.prompts.prompt import Prompt, PromptSet
from eai.run.solver import ask_as_published


def build_task(
    benchmark: Benchmark,
    ability: Ability,
    prompts: Mapping[str, Prompt],
    solver: Solver,
    protocol: Protocol,
) -> inspect_ai.Task:
    """The Inspect task that puts prompts to a model, each with its task's id.

    Args:
        benchmark: the benchmark.
        ability: the ability.
        prompts: the questions by id of their task.
        solver: what asks them.
        protocol: the rules for scoring.
    """
    name = f"{benchmark.name}_{ability.value}"
    samples = [_sample(benchmark, ability, task_id, prompt) for task_id, prompt in prompts.items()]
    return inspect_ai.Task(
        dataset=MemoryDataset(samples, name=name),
        solver=solver,
        scorer=verdict_scorer(benchmark.reference, ability.value, protocol.value),
        name=name,
        metadata={"domain": benchmark.name, "ability": ability.value},
    )


def published_task(reference: str, ability: Ability) -> Callable[..., inspect_ai.Task]:
    """Register a suite as an Inspect task, ``eai/<domain>_<ability>``."""

    def suite(
        protocol: str = DEFAULT_PROTOCOL.value,
        prompts: str = PromptSet.OFFICIAL.value,
        prompt_folder: str | None = None,
    ) -> inspect_ai.Task:
        folder = None if prompt_folder is None else Path(prompt_folder)
        benchmark = find_benchmark(reference)
        asked = Library(PromptSet(prompts), folder).open(benchmark, ability)
        task = build_task(benchmark, ability, asked, ask_as_published(), Protocol(protocol))
        task.config = GenerateConfig(temperature=0.0)
        return task

    name = f"{reference}_{ability.value}"
    registered = inspect_ai.task(name=name)(suite)
    if registry_info(registered).name == name:  # Inspect names the package only where it is not editable
        registered = inspect_ai.task(name=f"eai/{name}")(suite)
    return registered


@scorer(metrics=[mean(), stderr()], name="eai_verdict")
def verdict_scorer(benchmark: str, ability: str, protocol: str) -> Scorer:
    """Scores an answer with the pure function of the library.

    The value is the answer's own share of the suite's main metric: success, or F1. The verdict goes into the
    metadata of the score.
    """
    suite: Suite | None = None

    async def score(state: TaskState, target: Target) -> Score:
        nonlocal suite
        if suite is None:
            suite = open_suite(benchmark, Ability(ability), Protocol(protocol))
        answer = state.output.completion
        verdict = suite.score(str(state.sample_id), answer)
        if verdict.excluded is not None:
            return Score.unscored(answer=answer, explanation=verdict.excluded)
        declared = DECLARATIONS[suite.ability]
        share = declared.contributions(verdict)[next(iter(declared.main))]
        percent = Rate(*share).percent
        if percent is None:
            return Score.unscored(answer=answer, explanation="nothing to be right or wrong about")
        told = fields_of(verdict)
        return Score(value=percent / 100, answer=answer, explanation=_explanation(verdict), metadata=told)

    return score


def _sample(benchmark: Benchmark, ability: Ability, task_id: str, prompt: Prompt) -> Sample:
    about = {"domain": benchmark.reference, "ability": ability.value, "task_id": task_id}
    messages: list[ChatMessage] = [ChatMessageUser(content=prompt.user, metadata=about)]
    if prompt.system is not None:
        messages.insert(0, ChatMessageSystem(content=prompt.system))
    return Sample(id=task_id, input=messages, metadata={**about, "stop": list(prompt.stop)})


def _explanation(verdict: Verdict) -> str | None:
    return None if verdict.error is None else f"{verdict.error.kind.value}: {verdict.error.detail}"
