"""The built-in models as an Inspect provider: ``eai/oracle``, ``eai/planner``, ``eai/lookup`` and others.

They answer without network and key. What they need to know of a question they read from the metadata of its
message, which `eai.run.tasks` puts there; a question from elsewhere they cannot answer.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from functools import cache, partial
from pathlib import Path
from threading import Thread
from typing import Any, NamedTuple, TypeVar

from inspect_ai.model import ChatMessage, GenerateConfig, ModelAPI, ModelOutput, ModelUsage, modelapi
from inspect_ai.tool import ToolChoice, ToolInfo
from pydantic import Field

from eai.abilities.declaration import declaration_of
from eai.abilities.protocol import Ability
from eai.agents.agents import AGENTS
from eai.agents.command import DONE
from eai.agents.play import Arena, commands_of
from eai.agents.setting import STANDARD, Setting
from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.copied_answers import open_copy_book, open_empty_book, open_lookup_book
from eai.benchmarks.gold_answers import (
    AnswerBook,
    WrittenAnswer,
    believing,
    continuing,
    heeding_answer,
    lacking,
    no_answer,
    noisy_answer,
    open_answer_book,
    open_planned_book,
)
from eai.benchmarks.random_answers import open_random_answers
from eai.benchmarks.registry import find_benchmark
from eai.planning.search import Limits
from eai.results.answer_files import find_recorded_file
from eai.results.batch import NO_ROW
from eai.results.epochs import STATED
from eai.results.responses import read_responses
from eai.run.job import CAPTIONER, ERRATA, PROVIDER, can_answer, check_model
from eai.run.tasks import raise_refusals
from eai.studies.perception.scene_graph import SCENE, read_scene_graph
from eai.tasks.options import Options
from eai.tasks.source import ErrataChoice, Source, errata_choice
from eai.world.action import Action

DEFAULT_NOISE = 0.1

LIMITS = Limits(200)
"""The effort of `eai/planner` for a plan from a later state, or in a perceived scene, which may have none.

Every plan of the households takes less.
"""

T = TypeVar("T")

_BOOKS = {
    "planner": open_planned_book,
    "lookup": open_lookup_book,
    "copy": open_copy_book,
    "empty": open_empty_book,
}
"""The models that have answers of their own."""

_NEEDED = frozenset({"domain", "ability", "task_id"})
"""The metadata of a question that a built-in model needs."""


class _ModelArguments(Options):
    """The arguments of a built-in model.

    Attributes:
        rate: The share of errors.
        seed: Of random draws.
        heed: The probability with which it mends what feedback says.
        path: A response file, or a folder of them.
    """

    rate: float = Field(default=DEFAULT_NOISE, ge=0, le=1)
    seed: int = 0
    heed: float | None = Field(default=None, ge=0, le=1)
    path: Path | None = None


class _ModelQuestion(NamedTuple):
    """A question, as far as built-in models know it.

    Attributes:
        attempt: which attempt at the task it is for, from 1 on.
        done: what has been executed in the world as the question tells it.
        text: all that was said.
        stated: the answer whose goals it states in the place of the task's; None for the task's.
        scene: the scene graph that it tells of in the place of the task's scene; None for the task's.
        source: what the task's own answers are read from.
        setting: how the task is played, where actions are asked for.
    """

    benchmark: Benchmark
    ability: Ability
    task_id: str
    epoch: int
    attempt: int
    done: tuple[Action, ...]
    text: str
    stated: str | None = None
    scene: str | None = None
    source: Source = Source()
    setting: Setting = STANDARD


@modelapi(name=PROVIDER)
class _BuiltInModel(ModelAPI):
    """A built-in model.

    Args:
        model_name: ``oracle`` (the data set's own answers), ``planner`` (plans found by search, for action
            sequencing and subgoal decomposition; in a world that continues, from its present state, and in a
            pipeline for the stated goals), ``lookup`` (the answer of the most similar public
            task, objects renamed), ``copy`` (what the question says), ``empty`` (nothing, in the form asked
            for), ``random`` (random possible actions; argument ``seed``), ``noisy``
            (the data set's answers, corrupted anew in each attempt; arguments ``rate`` and ``seed``, and
            ``heed``, the probability with which it mends what feedback says, and else says the same
            again), ``captioner`` (scene graphs of pictures, with errors; arguments ``rate`` and ``seed``) or
            ``replay`` (answers from response files, of further attempts from
            ``<model>_attempt_<k>_outputs.json``; argument ``path``).
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
        with raise_refusals():
            check_model(f"{PROVIDER}/{model_name}")
            self._given = _ModelArguments.read(f"{PROVIDER}/{model_name}", model_args)
            if model_name == "replay" and self._given.path is None:
                raise InputError("eai/replay: expected -M path=FILE, a response file or a folder of them")
        self._book = cache(_BOOKS.get(model_name, open_answer_book))
        self._played = cache(self._commands)
        self._random = cache(open_random_answers)
        self._recorded = cache(self._read_recorded)

    async def generate(
        self, input: list[ChatMessage], tools: list[ToolInfo], tool_choice: ToolChoice, config: GenerateConfig
    ) -> ModelOutput:
        """Answer the last question; where actions are asked for, take the next one of the answer."""
        known = [n for n, message in enumerate(input) if (message.metadata or {}).keys() >= _NEEDED]
        about = (input[known[-1]].metadata or {}) if known else {}
        takes_turns = bool(known) and declaration_of(Ability(about["ability"])).takes_turns
        if not known or (not takes_turns and known[-1] != len(input) - 1):
            raise InputError(f"eai/{self.model_name} can only answer the questions of eai's own tasks")
        question = _ModelQuestion(
            find_benchmark(str(about["domain"])),
            Ability(about["ability"]),
            str(about["task_id"]),
            int(about.get("epoch", 1)),
            int(about.get("attempt", 1)),
            tuple([Action(name, tuple(arguments)) for name, *arguments in about.get("done", ())]),
            "\n\n".join([message.text for message in input]),
            about.get(STATED),
            about.get(SCENE),
            Source(errata=errata_choice(about.get(ERRATA, ErrataChoice.CURRENT))),
            Setting.of_question(about),
        )
        if takes_turns:
            commands = await _off_the_loop(partial(self._played, question._replace(text="")))
            taken = sum(message.role == "assistant" for message in input[known[-1] :])
            return self._output(input, commands[taken] if taken < len(commands) else DONE, tools)
        return self._output(input, await _off_the_loop(partial(self._answer, question)))

    def _commands(self, asked: _ModelQuestion) -> list[str]:
        """The commands of an episode: a recorded one, or the model's answer to action sequencing."""
        task = asked.benchmark.tasks(asked.source)[asked.task_id]
        if self.model_name in AGENTS:
            arena = Arena(asked.benchmark, asked.setting)
            return arena.commands(self.model_name, task, self._given.seed, asked.epoch)
        of_plan = asked._replace(ability=Ability.ACTION_SEQUENCING)
        answer = self._answer(asked if self.model_name == "replay" else of_plan)
        return commands_of(task, asked.benchmark, answer)

    def _output(
        self, input: Sequence[ChatMessage], answer: str, tools: Sequence[ToolInfo] = ()
    ) -> ModelOutput:
        """An answer, or a command as a call of a tool, with words for tokens."""
        name = f"{PROVIDER}/{self.model_name}"
        if not tools:
            output = ModelOutput.from_content(name, answer)
        elif answer == DONE:
            output = ModelOutput.for_tool_call(name, "done", {}, content="")
        else:
            action, _, objects = answer.removesuffix(")").partition("(")
            listed = [each.strip() for each in objects.split(",") if each.strip()]
            output = ModelOutput.for_tool_call(name, "act", {"action": action, "objects": listed}, content="")
        # Without a usage Inspect would count tokens itself, for which it downloads a tokenizer.
        prompt_words = sum(len(message.text.split()) for message in input)
        words = len(answer.split())
        output.usage = ModelUsage(
            input_tokens=prompt_words, output_tokens=words, total_tokens=prompt_words + words
        )
        return output

    def _answer(self, asked: _ModelQuestion) -> str:
        if not can_answer(f"{PROVIDER}/{self.model_name}", asked.ability):
            raise no_answer(self.model_name, asked.benchmark, asked.ability)
        if self.model_name == CAPTIONER:
            return self._list(asked)
        if self.model_name == "replay":
            recorded = self._recorded(asked.benchmark, asked.ability, asked.attempt, asked.source)
            if asked.task_id not in recorded:
                raise InputError(NO_ROW)
            return recorded[asked.task_id]
        if self.model_name == "planner" and (asked.done or asked.scene is not None):
            book = open_planned_book(_as_told(asked), asked.ability, asked.source, LIMITS)
            return _text_of(book[asked.task_id])
        if self.model_name in ("planner", "copy") and asked.stated is not None:
            book = _BOOKS[self.model_name](_as_told(asked), asked.ability, asked.source)
            return _text_of(book[asked.task_id])
        if self.model_name == "random":
            seed = f"{self._given.seed} {asked.epoch} {asked.attempt}"
            draw = self._random(asked.benchmark, asked.ability, asked.source)
            return draw(asked.task_id, seed, asked.done).text
        book = self._book(asked.benchmark, asked.ability, asked.source)
        if self.model_name in ("oracle", *_BOOKS):
            return _text_of(book[asked.task_id])
        _text_of(book[asked.task_id])
        return self._noisy(book, asked).text

    def _list(self, asked: _ModelQuestion) -> str:
        """The scene graph of a task with errors: as many facts are lost as are misplaced, on average."""
        from eai.studies.perception.belief import scene_words
        from eai.studies.perception.noise import Noise, perceive

        half = self._given.rate / 2
        noise, stream = Noise(missing=half, misplaced=half, seed=self._given.seed), str(asked.epoch)
        task = asked.benchmark.tasks_for(asked.ability, asked.source)[asked.task_id]
        return perceive(task, scene_words(asked.benchmark), noise, stream).text

    def _noisy(self, book: AnswerBook, asked: _ModelQuestion) -> WrittenAnswer:
        """A corrupted answer: a new one in each attempt, or the same, mended where feedback is heeded."""
        seed = f"{self._given.seed} {asked.epoch}"
        if self._given.heed is not None:
            question, attempt, rate = asked.text, asked.attempt, self._given.rate
            return heeding_answer(
                book, asked.task_id, question, attempt, rate=rate, seed=seed, heed=self._given.heed
            )
        seed += f" {asked.attempt}" if asked.attempt > 1 else ""
        return noisy_answer(book, asked.task_id, self._given.rate, seed)

    def _read_recorded(
        self, benchmark: Benchmark, ability: Ability, attempt: int, source: Source
    ) -> dict[str, str]:
        book = self._book(benchmark, ability, source)
        file = find_recorded_file(Path(str(self._given.path)), benchmark.name, ability, attempt)
        recorded = read_responses(file, book, benchmark.data.task_id_of)
        return {response.task_id: response.text for response in recorded.responses}


def _as_told(asked: _ModelQuestion) -> Benchmark:
    """The benchmark whose task is as a question tells it: its state, its scene and its goals."""
    benchmark, task_id = asked.benchmark, asked.task_id
    if asked.done:
        benchmark = continuing(benchmark, task_id, asked.done)
    if asked.scene is not None:
        from eai.studies.perception.belief import perceiving, scene_words

        graph = read_scene_graph(asked.scene, scene_words(benchmark).arities)
        benchmark = perceiving(benchmark, {task_id: graph})
    if asked.stated is not None:
        benchmark = believing(benchmark, {task_id: asked.stated})
    return lacking(benchmark, task_id, asked.done) if asked.done else benchmark


def _text_of(answer: WrittenAnswer) -> str:
    """Return the text of an answer.

    Raises:
        InputError: there is no answer.
    """
    if answer.why_none:
        raise InputError(answer.why_none)
    return answer.text


async def _off_the_loop(work: Callable[[], T]) -> T:
    """Return the result of some work, in a thread for which nobody waits when the run is interrupted."""
    done: Future[T] = Future()
    done.set_running_or_notify_cancel()

    def do() -> None:
        try:
            done.set_result(work())
        except BaseException as error:
            done.set_exception(error)

    Thread(target=do, daemon=True).start()
    return await asyncio.wrap_future(done)
