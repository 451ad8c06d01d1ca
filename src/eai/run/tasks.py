"""The benchmark as Inspect tasks, for ``eai run`` and for ``inspect eval eai/...`` alike."""

from __future__ import annotations

import inspect_ai
from inspect_ai.dataset import MemoryDataset, Sample
from inspect_ai.model import ChatMessage, ChatMessageSystem, ChatMessageUser, GenerateConfig
from inspect_ai.scorer import Score, Scorer, Target, accuracy, scorer, stderr
from inspect_ai.solver import TaskState, generate

from eai.abilities.protocol import Ability, Domain, Protocol
from eai.abilities.suite import Suite, open_suite
from eai.abilities.verdict import Verdict, fields_of
from eai.prompts.official import Prompt, official_prompts


def build_task(domain: Domain, ability: Ability, protocol: Protocol) -> inspect_ai.Task:
    """The Inspect task of a domain and an ability: official prompts, one generation, our verdict."""
    prompts = official_prompts(domain, ability)
    samples = [_sample(domain, ability, task_id, prompt) for task_id, prompt in prompts.items()]
    name = f"{domain.value}_{ability.value}"
    return inspect_ai.Task(
        dataset=MemoryDataset(samples, name=name),
        solver=generate(),
        scorer=verdict_scorer(domain.value, ability.value, protocol.value),
        config=GenerateConfig(temperature=0.0),
        name=name,
        metadata={"domain": domain.value, "ability": ability.value},
    )


@inspect_ai.task
def virtualhome_action_sequencing(protocol: str = Protocol.STRICT.value) -> inspect_ai.Task:
    """Action sequencing in VirtualHome."""
    return build_task(Domain.VIRTUALHOME, Ability.ACTION_SEQUENCING, Protocol(protocol))


@scorer(metrics=[accuracy(), stderr()], name="eai_verdict")
def verdict_scorer(domain: str, ability: str, protocol: str) -> Scorer:
    """Scores an answer with the pure function of the library; the verdict goes into the score's metadata."""
    suite: Suite | None = None

    async def score(state: TaskState, target: Target) -> Score:
        nonlocal suite
        if suite is None:
            suite = open_suite(Domain(domain), Ability(ability), Protocol(protocol))
        verdict = suite.score(str(state.sample_id), state.output.completion)
        if verdict.excluded is not None:
            return Score.unscored(answer=state.output.completion, explanation=verdict.excluded)
        return Score(
            value=1 if verdict.success else 0,
            answer=state.output.completion,
            explanation=_explanation(verdict),
            metadata=fields_of(verdict),
        )

    return score


def _sample(domain: Domain, ability: Ability, task_id: str, prompt: Prompt) -> Sample:
    about = {"domain": domain.value, "ability": ability.value, "task_id": task_id}
    messages: list[ChatMessage] = [ChatMessageUser(content=prompt.user, metadata=about)]
    if prompt.system is not None:
        messages.insert(0, ChatMessageSystem(content=prompt.system))
    return Sample(id=task_id, input=messages, metadata=about)


def _explanation(verdict: Verdict) -> str:
    if verdict.error is not None:
        return f"{verdict.error.kind.value}: {verdict.error.detail}"
    return "success" if verdict.success else "the goal is not reached"
