"""Data sets for training: prompts to be rewarded, verified answers, pairs of a better and a worse answer.

A row is a JSON object. ``prompt``, ``completion``, ``chosen`` and ``rejected`` are lists of messages, as TRL
has them; ``task`` names the task as `eai.reward` takes it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from eai.abilities.record import Record
from eai.abilities.verdict import Json
from eai.prompts.prompt import Prompt
from eai.scoring.reward import Reward

Row = dict[str, Json]


def prompt_rows(reward: Reward, prompts: Mapping[str, Prompt]) -> Iterator[Row]:
    """A row for each task in which something is to be earned, in the order of the data set.

    Besides prompt and task a row has the columns by which verl (``data_source``, ``reward_model``) and SkyRL
    (``env_class``, ``reward_spec``) learn of the task.
    """
    suite = reward.suite
    for task_id in suite.task_ids:
        if reward(task_id, "") is None:
            continue
        task = suite.reference(task_id)
        yield {
            "prompt": _messages_of(prompts[task_id]),
            "task": task,
            "data_source": f"{suite.domain}/{suite.ability.value}",
            "reward_model": {"style": "rule", "ground_truth": task},
            "env_class": "eai",
            "reward_spec": {"method": "rule", "ground_truth": task},
        }


class Rewarded(NamedTuple):
    """An answer to a prompt, with what it is worth."""

    prompt: Prompt
    task: str
    model: str
    text: str
    worth: float


NO_ANSWER = "without an answer, or with nothing to earn"
EXPERIMENT = "of experiments, which ask other questions"
ASKED_OTHERWISE = "answering another prompt than is exported"
NOT_PAID = "of several turns, whose verdicts do not say what an answer has earned"
"""Why a record is not used."""


def rewarded(
    records: Iterable[Record], reward: Reward, prompts: Mapping[str, Prompt], left_out: Counter[str]
) -> Iterator[Rewarded]:
    """The answers in records of one suite with what they are worth now, and the prompts they answer.

    ``left_out`` counts the records that are not used, by the reason.
    """
    for record in records:
        if record.experiment is not None and not record.experiment.is_plain:
            left_out[EXPERIMENT] += 1
            continue
        worth = None if record.unanswered is not None else reward(record.task_id, record.response)
        if worth is None:
            left_out[NO_ANSWER] += 1
            continue
        prompt = prompts[record.task_id]
        asked = None if record.origin is None else record.origin.prompt_sha256
        if asked not in (None, prompt.sha256):
            left_out[ASKED_OTHERWISE] += 1
            continue
        task = reward.suite.reference(record.task_id)
        yield Rewarded(prompt, task, record.model, record.response, worth)


def verified_rows(answers: Iterable[Rewarded], least: float = 1.0) -> Iterator[Row]:
    """A row for each answer that is worth at least so much; equal answers to a task stand there once."""
    seen: set[tuple[str, str]] = set()
    for answer in answers:
        place = (answer.task, answer.text)
        if answer.worth >= least and place not in seen:
            seen.add(place)
            yield {
                "prompt": _messages_of(answer.prompt),
                "completion": _message_of(answer.text),
                "task": answer.task,
                "model": answer.model,
                "reward": answer.worth,
            }


def preference_rows(answers: Iterable[Rewarded], margin: float = 0.0) -> Iterator[Row]:
    """For each task its best answer, the first of equally good ones, before every one that is worth less.

    Args:
        answers: the answers.
        margin: by more than how much the chosen answer must be worth more than the rejected one.
    """
    by_task: dict[str, dict[str, Rewarded]] = {}
    for answer in answers:
        by_task.setdefault(answer.task, {}).setdefault(answer.text, answer)
    for task, distinct in by_task.items():
        best = max(distinct.values(), key=lambda answer: answer.worth)
        for other in distinct.values():
            if best.worth - other.worth > margin:
                yield {
                    "prompt": _messages_of(best.prompt),
                    "chosen": _message_of(best.text),
                    "rejected": _message_of(other.text),
                    "task": task,
                    "margin": best.worth - other.worth,
                }


def _messages_of(prompt: Prompt) -> list[Json]:
    system: list[Json] = [] if prompt.system is None else [{"role": "system", "content": prompt.system}]
    return [*system, {"role": "user", "content": prompt.user}]


def _message_of(text: str) -> list[Json]:
    return [{"role": "assistant", "content": text}]
