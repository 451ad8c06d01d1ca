"""The built-in models as an Inspect provider: ``eai/oracle``, ``eai/planner``, ``eai/lookup`` and others.

They need no network and no key. They read the metadata that `eai.run.tasks` adds to a question's message, so
they can only answer questions of this package.
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

from eai.abilities.declaration import get_declaration
from eai.abilities.protocol import Ability
from eai.agents.agents import AGENTS
from eai.agents.command import DONE
from eai.agents.play import EpisodeFactory, read_commands
from eai.agents.setting import STANDARD, AgentSetting
from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.copied_answers import (
    open_answers_copied_from_questions,
    open_answers_of_similar_tasks,
    open_empty_answers,
)
from eai.benchmarks.gold_answers import (
    AnswerInParts,
    AnswersByTask,
    make_benchmark_starting_after_actions,
    make_benchmark_without_reached_goals,
    make_no_answer_error,
    make_noisy_answer,
    make_noisy_answer_heeding_feedback,
    open_answers_of_planner,
    open_gold_answers,
    replace_goals_by_answers,
)
from eai.benchmarks.random_answers import open_random_answers
from eai.benchmarks.registry import find_benchmark
from eai.planning.search import Limits
from eai.results.answer_files import find_response_file_of_suite
from eai.results.batch import NO_ROW
from eai.results.epochs import STATED
from eai.results.responses import read_responses
from eai.run.job import CAPTIONER, ERRATA, KEPT_TASKS, PROVIDER, can_model_answer, check_model_name
from eai.run.tasks import raise_input_errors_as_task_argument_errors
from eai.studies.perception.scene_graph import SCENE, read_scene_graph
from eai.tasks.options import Options
from eai.tasks.source import ErrataChoice, Source, find_errata_choice
from eai.world.action import Action

DEFAULT_NOISE = 0.1

PLANNER_LIMITS = Limits(200)
"""Search limits of `eai/planner` if a question describes a changed state or a scene as a model perceived it.

The goals may be out of reach there; then the limits end the search. All tasks of the household benchmarks
need less search.
"""

T = TypeVar("T")

_ANSWER_OPENERS = {
    "planner": open_answers_of_planner,
    "lookup": open_answers_of_similar_tasks,
    "copy": open_answers_copied_from_questions,
    "empty": open_empty_answers,
}
"""Name of a built-in model -> function that returns its answers to a suite.

Models that use the data set's own answers are left out.
"""

_REQUIRED_METADATA = frozenset({"domain", "ability", "task_id"})
"""Names of the metadata that every built-in model needs with a question."""


class _ModelArguments(Options):
    """Arguments of a built-in model.

    Attributes:
        rate: The share of errors.
        seed: Seed of random draws.
        heed: The probability with which the model repairs an error that feedback names.
        path: A response file, or a folder of them.
    """

    rate: float = Field(default=DEFAULT_NOISE, ge=0, le=1)
    seed: int = 0
    heed: float | None = Field(default=None, ge=0, le=1)
    path: Path | None = None


class _QuestionForBuiltInModel(NamedTuple):
    """A question with the metadata that built-in models read.

    Attributes:
        attempt: number of the attempt at the task, from 1 on.
        done: actions that earlier attempts executed in the world that the question describes.
        text: text of all messages.
        stated: an earlier answer of a model, whose goals the question states. None if the question states
            the task's own goals.
        scene: the scene graph that the question shows; None if it shows the task's scene.
        source: settings for opening the data set, which has the gold answers.
        setting: rules of the episode, in the ability ``acting``.
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
    setting: AgentSetting = STANDARD


@modelapi(name=PROVIDER)
class _BuiltInModel(ModelAPI):
    """A built-in model.

    Args:
        model_name: one of these names:

            - ``oracle``: the data set's own answers.
            - ``planner``: plans for the goals that the question states, or subgoals of such plans.
              After an attempt that changed the world, the search starts in the changed state.
            - ``lookup``: the answer of the most similar public task, with renamed objects.
            - ``copy``: answers copied from the question (`open_answers_copied_from_questions`).
            - ``empty``: answers without content, in the requested form.
            - ``random``: random possible actions; argument ``seed``.
            - ``noisy``: the data set's answers with random errors, which differ between attempts; arguments
              ``rate`` and ``seed``. With the argument ``heed``, a further attempt repeats the last answer. An
              error that feedback names is then repaired with the probability ``heed``.
            - ``captioner``: scene graphs of pictures, with errors; arguments ``rate`` and ``seed``.
            - ``replay``: answers from response files; argument ``path``. Answers of further attempts are in
              ``<model>_attempt_<k>_outputs.json``.
            - a name in `eai.run.job.EXPLORERS`: the commands of a built-in agent in episodes.
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
        with raise_input_errors_as_task_argument_errors():
            check_model_name(f"{PROVIDER}/{model_name}")
            self._arguments = _ModelArguments.read(f"{PROVIDER}/{model_name}", model_args)
            if model_name == "replay" and self._arguments.path is None:
                raise InputError("eai/replay: expected -M path=FILE, a response file or a folder of them")
        self._open_answers = cache(_ANSWER_OPENERS.get(model_name, open_gold_answers))
        self._find_commands = cache(self._list_commands_of_model_in_episode)
        self._open_random_answers = cache(open_random_answers)
        self._open_recorded_answers = cache(self._read_answers_from_response_file)

    async def generate(
        self, input: list[ChatMessage], tools: list[ToolInfo], tool_choice: ToolChoice, config: GenerateConfig
    ) -> ModelOutput:
        """Answer the last question. In an ability whose answers are episodes, return the next command."""
        positions = [
            n for n, message in enumerate(input) if (message.metadata or {}).keys() >= _REQUIRED_METADATA
        ]
        metadata = (input[positions[-1]].metadata or {}) if positions else {}
        takes_turns = bool(positions) and get_declaration(Ability(metadata["ability"])).takes_turns
        if not positions or (not takes_turns and positions[-1] != len(input) - 1):
            raise InputError(
                f"eai/{self.model_name} answers only questions of the Inspect tasks eai/...; "
                "ask it with `eai run` or `inspect eval eai/...`"
            )
        question = _QuestionForBuiltInModel(
            find_benchmark(str(metadata["domain"])),
            Ability(metadata["ability"]),
            str(metadata["task_id"]),
            int(metadata.get("epoch", 1)),
            int(metadata.get("attempt", 1)),
            tuple([Action(name, tuple(arguments)) for name, *arguments in metadata.get("done", ())]),
            "\n\n".join([message.text for message in input]),
            metadata.get(STATED),
            metadata.get(SCENE),
            Source(errata=find_errata_choice(metadata.get(ERRATA, ErrataChoice.CURRENT)), kept=KEPT_TASKS),
            AgentSetting.from_metadata(metadata),
        )
        if takes_turns:
            commands = await _run_in_thread(partial(self._find_commands, question._replace(text="")))
            actions_taken = sum(message.role == "assistant" for message in input[positions[-1] :])
            return self._make_output(
                input, commands[actions_taken] if actions_taken < len(commands) else DONE, tools
            )
        return self._make_output(input, await _run_in_thread(partial(self._answer_question, question)))

    def _list_commands_of_model_in_episode(self, question: _QuestionForBuiltInModel) -> list[str]:
        """Return the commands of an episode: recorded commands, or the model's plan for the task."""
        task = question.benchmark.tasks(question.source)[question.task_id]
        if self.model_name in AGENTS:
            arena = EpisodeFactory(question.benchmark, question.setting)
            return arena.play_episode_and_return_commands(
                self.model_name, task, self._arguments.seed, question.epoch
            )
        of_plan = question._replace(ability=Ability.ACTION_SEQUENCING)
        answer = self._answer_question(question if self.model_name == "replay" else of_plan)
        return read_commands(task, question.benchmark, answer)

    def _make_output(
        self, input: Sequence[ChatMessage], answer: str, tools: Sequence[ToolInfo] = ()
    ) -> ModelOutput:
        """Return the model's output: an answer as text or a command as a tool call, with token counts."""
        name = f"{PROVIDER}/{self.model_name}"
        if not tools:
            output = ModelOutput.from_content(name, answer)
        elif answer == DONE:
            output = ModelOutput.for_tool_call(name, "done", {}, content="")
        else:
            action, _, objects = answer.removesuffix(")").partition("(")
            object_names = [name.strip() for name in objects.split(",") if name.strip()]
            output = ModelOutput.for_tool_call(
                name, "act", {"action": action, "objects": object_names}, content=""
            )
        # Without usage figures, Inspect would download a tokenizer to count tokens.
        prompt_words = sum(len(message.text.split()) for message in input)
        words = len(answer.split())
        output.usage = ModelUsage(
            input_tokens=prompt_words, output_tokens=words, total_tokens=prompt_words + words
        )
        return output

    def _answer_question(self, question: _QuestionForBuiltInModel) -> str:
        if not can_model_answer(f"{PROVIDER}/{self.model_name}", question.ability):
            raise make_no_answer_error(self.model_name, question.benchmark, question.ability)
        if self.model_name == CAPTIONER:
            return self._describe_scene(question)
        if self.model_name == "replay":
            recorded = self._open_recorded_answers(
                question.benchmark, question.ability, question.attempt, question.source
            )
            if question.task_id not in recorded:
                raise InputError(NO_ROW)
            return recorded[question.task_id]
        if self.model_name == "planner" and (question.done or question.scene is not None):
            answers = open_answers_of_planner(
                _adapt_benchmark_to_question(question),
                question.ability,
                question.source,
                PLANNER_LIMITS,
            )
            return _get_text_or_raise(answers[question.task_id])
        if self.model_name in ("planner", "copy") and question.stated is not None:
            answers = _ANSWER_OPENERS[self.model_name](
                _adapt_benchmark_to_question(question), question.ability, question.source
            )
            return _get_text_or_raise(answers[question.task_id])
        if self.model_name == "random":
            seed = f"{self._arguments.seed} {question.epoch} {question.attempt}"
            draw = self._open_random_answers(question.benchmark, question.ability, question.source)
            return draw(question.task_id, seed, question.done).text
        answers = self._open_answers(question.benchmark, question.ability, question.source)
        if self.model_name in ("oracle", *_ANSWER_OPENERS):
            return _get_text_or_raise(answers[question.task_id])
        _get_text_or_raise(answers[question.task_id])
        return self._corrupt_answer(answers, question).text

    def _describe_scene(self, question: _QuestionForBuiltInModel) -> str:
        """Return a task's scene graph, corrupted by random errors.

        On average, half of the errors leave out a fact, and half give a fact a wrong object.
        """
        from eai.studies.perception.belief import make_scene_graph_vocabulary
        from eai.studies.perception.noise import PerceptionNoise, perceive_with_noise

        half = self._arguments.rate / 2
        noise = PerceptionNoise(missing=half, misplaced=half, seed=self._arguments.seed)
        stream = str(question.epoch)
        task = question.benchmark.tasks_for(question.ability, question.source)[question.task_id]
        return perceive_with_noise(
            task, make_scene_graph_vocabulary(question.benchmark), noise, stream
        ).json_text

    def _corrupt_answer(self, answers: AnswersByTask, question: _QuestionForBuiltInModel) -> AnswerInParts:
        """Return a corrupted answer to a question.

        Each attempt at a task draws new errors. With the argument ``heed``, a later attempt repeats the last
        answer instead. If the question names an error, the attempt repairs it with the probability ``heed``.
        """
        seed = f"{self._arguments.seed} {question.epoch}"
        if self._arguments.heed is not None:
            text, attempt, rate = question.text, question.attempt, self._arguments.rate
            return make_noisy_answer_heeding_feedback(
                answers,
                question.task_id,
                text,
                attempt,
                error_rate=rate,
                seed=seed,
                repair_probability=self._arguments.heed,
            )
        seed += f" {question.attempt}" if question.attempt > 1 else ""
        return make_noisy_answer(answers, question.task_id, self._arguments.rate, seed)

    def _read_answers_from_response_file(
        self, benchmark: Benchmark, ability: Ability, attempt: int, source: Source
    ) -> dict[str, str]:
        answers = self._open_answers(benchmark, ability, source)
        file = find_response_file_of_suite(Path(str(self._arguments.path)), benchmark.name, ability, attempt)
        recorded = read_responses(file, answers, benchmark.data.task_id_of)
        return {response.task_id: response.text for response in recorded.responses}


def _adapt_benchmark_to_question(question: _QuestionForBuiltInModel) -> Benchmark:
    """Return the benchmark of a question, with the question's task changed as the question describes it.

    The task gets the state after the executed actions, the perceived scene, and the stated goals.
    """
    benchmark, task_id = question.benchmark, question.task_id
    if question.done:
        benchmark = make_benchmark_starting_after_actions(benchmark, task_id, question.done)
    if question.scene is not None:
        from eai.studies.perception.belief import make_scene_graph_vocabulary, replace_scenes_of_benchmark

        graph = read_scene_graph(
            question.scene, make_scene_graph_vocabulary(benchmark).arity_by_predicate_name_in_graphs
        )
        benchmark = replace_scenes_of_benchmark(benchmark, {task_id: graph})
    if question.stated is not None:
        benchmark = replace_goals_by_answers(benchmark, {task_id: question.stated})
    if question.done:
        return make_benchmark_without_reached_goals(benchmark, task_id, question.done)
    return benchmark


def _get_text_or_raise(answer: AnswerInParts) -> str:
    if answer.why_none:
        raise InputError(answer.why_none)
    return answer.text


async def _run_in_thread(work: Callable[[], T]) -> T:
    """Run a function in a thread, and return its result. An interrupt ends the wait, not the thread."""
    future: Future[T] = Future()
    future.set_running_or_notify_cancel()

    def run_work_and_set_future() -> None:
        try:
            future.set_result(work())
        except BaseException as error:
            future.set_exception(error)

    Thread(target=run_work_and_set_future, daemon=True).start()
    return await asyncio.wrap_future(future)
