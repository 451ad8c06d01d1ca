"""The built-in models as an Inspect provider: ``eai/oracle``, ``eai/planner``, ``eai/noisy``, ``eai/replay``.

They answer without network and key. What they need to know of a question they read from the metadata of its
message, which `eai.run.tasks` puts there; a question from elsewhere they cannot answer.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

from inspect_ai.model import (
    ChatMessage,
    GenerateConfig,
    ModelAPI,
    ModelOutput,
    ModelUsage,
    modelapi,
)
from inspect_ai.tool import ToolChoice, ToolInfo

from eai.abilities.protocol import Ability
from eai.abilities.responses import read_responses
from eai.benchmarks.answer_files import recorded_file
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import AnswerBook, noisy_answer, open_answer_book, open_planned_book
from eai.benchmarks.registry import find_benchmark
from eai.errors import InputError, did_you_mean
from eai.run.job import PROVIDER, check_model
from eai.run.refusal import refusing
from eai.scoring.batch import NO_ROW

DEFAULT_NOISE = 0.1
_ARGUMENTS = ("rate", "seed", "path")


@modelapi(name=PROVIDER)
class BuiltInModel(ModelAPI):
    """A built-in model.

    Args:
        model_name: ``oracle`` (the data set's own answers), ``planner`` (plans found by search, for action
            sequencing and subgoal decomposition), ``noisy`` (the data set's answers, spoilt; arguments
            ``rate`` and ``seed``) or ``replay`` (answers from response files; argument ``path``).
        base_url: not used.
        api_key: not used.
        config: not used.
        model_args: the arguments of the model.

    Raises:
        InputError: the model or an argument is unknown.
    """

    def __init__(
        self,
        model_name: str,
        base_url: str | None = None,
        api_key: str | None = None,
        config: GenerateConfig = GenerateConfig(),  # noqa: B008 - the signature that Inspect asks for
        **model_args: Any,
    ) -> None:
        super().__init__(model_name, base_url, api_key, [], config)
        with refusing():
            check_model(f"{PROVIDER}/{model_name}")
            self._rate = _share(model_name, model_args.pop("rate", DEFAULT_NOISE))
            self._seed = _whole(model_name, model_args.pop("seed", 0))
            self._path = model_args.pop("path", None)
            if model_args:
                unknown = next(iter(model_args))
                hint = did_you_mean(unknown, _ARGUMENTS)
                raise InputError(f"eai/{model_name}: unknown argument {unknown}{hint}")
            if model_name == "replay" and self._path is None:
                raise InputError("eai/replay: expected -M path=FILE, a response file or a folder of them")
        self._book = cache(open_planned_book if model_name == "planner" else open_answer_book)
        self._recorded = cache(self._read_recorded)

    async def generate(
        self,
        input: list[ChatMessage],
        tools: list[ToolInfo],
        tool_choice: ToolChoice,
        config: GenerateConfig,
    ) -> ModelOutput:
        """Answer the last message."""
        question = input[-1].metadata or {}
        if not {"domain", "ability", "task_id"} <= question.keys():
            raise InputError(f"eai/{self.model_name} can only answer the questions of eai's own tasks")
        answer = self._answer(
            find_benchmark(str(question["domain"])),
            Ability(question["ability"]),
            str(question["task_id"]),
            int(question.get("epoch", 1)),
        )
        output = ModelOutput.from_content(f"{PROVIDER}/{self.model_name}", answer)
        # Without a usage Inspect would count tokens itself, for which it downloads a tokenizer.
        prompt_words = sum(len(message.text.split()) for message in input)
        words = len(answer.split())
        output.usage = ModelUsage(
            input_tokens=prompt_words, output_tokens=words, total_tokens=prompt_words + words
        )
        return output

    def _answer(self, benchmark: Benchmark, ability: Ability, task_id: str, epoch: int) -> str:
        if self.model_name == "replay":
            recorded = self._recorded(benchmark, ability)
            if task_id not in recorded:
                raise InputError(NO_ROW)
            return recorded[task_id]
        book: AnswerBook = self._book(benchmark, ability)
        if self.model_name in ("oracle", "planner"):
            return book.gold(task_id).text
        return noisy_answer(book, task_id, rate=self._rate, seed=f"{self._seed} {epoch}").text

    def _read_recorded(self, benchmark: Benchmark, ability: Ability) -> dict[str, str]:
        task_ids = self._book(benchmark, ability).task_ids
        file = recorded_file(Path(str(self._path)), benchmark.name, ability)
        recorded = read_responses(file, task_ids, benchmark.task_id_of)
        return {response.task_id: response.text for response in recorded.responses}


def _share(model: str, value: object) -> float:
    """A number from 0 to 1; raises InputError for anything else."""
    try:
        share = float(str(value))
    except ValueError:
        share = -1.0
    if not 0 <= share <= 1:
        raise InputError(f"eai/{model}: expected -M rate= with a number from 0 to 1, not {value!r}")
    return share


def _whole(model: str, value: object) -> int:
    """A whole number; raises InputError for anything else."""
    try:
        return int(str(value))
    except ValueError as error:
        raise InputError(f"eai/{model}: expected -M seed= with a whole number, not {value!r}") from error
