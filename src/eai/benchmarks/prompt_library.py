"""Open the prompts of a suite (a benchmark and an ability) from a set, such as the official prompts.

Files of the user may replace prompts of the set. `make_answer_schema` returns the schema of the answer to a
question, for providers that enforce a schema. The schema allows only words that occur in the question.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from eai.abilities.answer_schema import Schema, is_schema_accepted_by_providers
from eai.abilities.declaration import QuestionMaker, get_declaration
from eai.abilities.feedback import MultiAttemptQuestionWriter, ScenePerception
from eai.abilities.protocol import Ability, find_ability_entry_points
from eai.base.errors import InputError
from eai.base.files import find_files_below
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.made_example import make_example_task_for_prompts
from eai.benchmarks.names import suite_name
from eai.benchmarks.registry import list_benchmarks
from eai.tasks.prompts.own import (
    PromptTemplateValues,
    make_answer_format_samples_by_placeholder,
    render_operator_prompts,
    render_prompts,
    render_task_prompt,
)
from eai.tasks.prompts.prompt import (
    BelievedTask,
    Image,
    Prompt,
    PromptSet,
    read_prompt_file,
    read_system_message_file,
)
from eai.tasks.prompts.template import PromptTemplates, list_template_names
from eai.tasks.source import Source, TaskSet, use_tasks
from eai.tasks.task import Task
from eai.tasks.wording import PromptAndAnswerWording


def make_answer_schema(
    benchmark: Benchmark, ability: Ability, task: Task | None, prompt: Prompt
) -> Schema | None:
    """Return the JSON schema of the answer to a question, or None if the ability has no schema.

    The schema allows only names of objects that the question lists. It allows any name if the question does
    not list all objects, because a schema must not reveal more than the question. It also allows any name if
    the list is too long for providers.

    Args:
        benchmark: the benchmark.
        ability: the ability of the question.
        task: the task whose objects the question lists; None if the question lists objects of several tasks.
        prompt: the question.
    """
    declared = get_declaration(ability).interaction.answer_form
    if declared is None:
        return None
    words, form = declared(benchmark.collect_domain_and_notation(Source()), task)
    schema = form(words) if words and _contains_all(f"{prompt.system or ''}\n{prompt.user}", words) else None
    return schema if schema is not None and is_schema_accepted_by_providers(schema) else form(None)


def _contains_all(question: str, words: Sequence[str]) -> bool:
    return all(re.search(rf"(?<!\w){re.escape(word)}(?!\w)", question) for word in words)


@dataclass(frozen=True, slots=True)
class PromptLibrary:
    """The prompts of a run: a set of prompts, and files of the user that replace prompts of the set.

    Attributes:
        prompts: name of the set of prompts.
        folder: the folder of the user's own files, or None. ``<domain>_<ability>.json`` replaces the prompts
            of a suite, ``<domain>_<ability>_system.json`` its system message, and other files replace
            templates of our sets.
        source: the source of the data.
    """

    prompts: PromptSet
    folder: Path | None = None
    source: Source = field(default_factory=Source)

    @property
    def templates(self) -> PromptTemplates:
        """Templates of our prompts. Templates in the user's folder replace templates of the same name."""
        return PromptTemplates(self.folder, self.prompts)

    def open(
        self, benchmark: Benchmark, ability: Ability, beliefs: Mapping[str, BelievedTask] | None = None
    ) -> Mapping[str, Prompt]:
        """Return the prompts of a benchmark for an ability by task id, in the order of the data set.

        If a benchmark has no published prompts, our prompts are rendered from its domain.

        Args:
            benchmark: the benchmark.
            ability: the ability.
            beliefs: task id -> the goals or the scene that the prompt states in place of the task's own.

        Raises:
            DataError: the data cannot be obtained.
            InputError: a file of the user cannot be used, or the set has no prompts for this ability.
        """
        beliefs = beliefs or {}
        if self.folder is not None:
            _check_prompt_folder(self.folder, benchmark)
        official = self.prompts == "official"
        published = benchmark.official_prompts(ability, self.source) if official else None
        if published is not None:
            prompts = self._replace_by_user_prompts(published, benchmark, ability)
            return _replace_prompt_goals_by_believed_goals(prompts, benchmark, ability, beliefs)
        prompts = self._render_prompts(benchmark, ability, beliefs)
        replaced = self._replace_by_user_prompts(prompts, benchmark, ability)
        for task_id in beliefs.keys() & prompts.keys():
            if replaced[task_id].user != prompts[task_id].user:
                raise InputError(
                    f"{self.folder}: leave out the prompt of {task_id} in <domain>_<ability>.json, because "
                    "it lacks the goals or the scene that a model gave in an earlier answer"
                )
        return replaced

    def count_questions_corrected_by_errata(
        self, benchmark: Benchmark, ability: Ability, task_ids: Iterable[str]
    ) -> int:
        """Return the number of tasks whose official question is corrected by errata."""
        if self.prompts != "official":
            return 0
        corrected = benchmark.get_errata(self.source).find_corrected_tasks(ability).intersection(task_ids)
        return len(corrected - self._read_user_prompts(benchmark, ability).keys())

    def make_question_writer(
        self,
        benchmark: Benchmark,
        ability: Ability,
        prompts: Mapping[str, Prompt],
        perceive: ScenePerception | None = None,
    ) -> MultiAttemptQuestionWriter:
        """Return an object that writes the first question about a task, and further questions after failures.

        The first question is one of `prompts`. Further questions made from our templates describe the world
        as earlier actions have changed it. Published prompts and prompts of the user stay unchanged.

        Args:
            benchmark: the benchmark.
            ability: the ability.
            prompts: the first question by task id.
            perceive: function that simulates how a changed scene is perceived; None if questions describe the
                true scene.
        """
        rendered = self.prompts != "official" or benchmark.data.prompts is None
        templates, restate = self.templates, None
        if rendered and not self._has_user_file(benchmark, ability):
            restate = partial(
                render_task_prompt,
                self._make_prompt_template_values(benchmark, ability, {}),
                templates=templates,
            )
        return MultiAttemptQuestionWriter(
            prompts.__getitem__, benchmark.wording(ability), restate, templates, perceive
        )

    def _render_prompts(
        self, benchmark: Benchmark, ability: Ability, beliefs: Mapping[str, BelievedTask]
    ) -> Mapping[str, Prompt]:
        """Return our prompts.

        They are rendered from templates, unless code of the ability writes its questions.
        """
        templates, interaction = self.templates, get_declaration(ability).interaction
        if interaction.uses_operator_tasks:
            tasks = benchmark.operator_tasks(self.source)
            return render_operator_prompts(
                tasks, templates, has_example=not benchmark.uses_declared_names_in_prompts
            )
        if interaction.make_question is not None:
            return self._make_prompts_by_ability_code(interaction.make_question, benchmark, ability, beliefs)
        return render_prompts(self._make_prompt_template_values(benchmark, ability, beliefs), templates)

    def _make_prompts_by_ability_code(
        self,
        make_question: QuestionMaker,
        benchmark: Benchmark,
        ability: Ability,
        beliefs: Mapping[str, BelievedTask],
    ) -> Mapping[str, Prompt]:
        """Return a mapping from task ids to questions, for an ability whose own code writes them.

        Each question is made on first use, because it may need pictures.
        """
        world = benchmark.collect_domain_and_notation(self.source)
        tasks = benchmark.tasks_for(ability, self.source)
        templates, pictures = self.templates, get_declaration(ability).interaction.pictures

        def pose_question(task_id: str) -> Prompt:
            belief = beliefs.get(task_id)
            question, _ = make_question(world, tasks[task_id] if belief is None else belief.task)
            text = (
                question if isinstance(question, str) else templates.fill_template(f"{ability}.txt", question)
            )
            if belief is not None:
                return Prompt(text, images=belief.images)
            shown = () if pictures is None else pictures(world, tasks[task_id])
            return Prompt(text, images=tuple([Image(*picture) for picture in shown]))

        return TaskSet(tasks, pose_question, tasks.sha256)

    def _make_prompt_template_values(
        self, benchmark: Benchmark, ability: Ability, beliefs: Mapping[str, BelievedTask]
    ) -> PromptTemplateValues:
        """Return the values that our templates render: wording, tasks, answer format and samples."""
        templates, notation = self.templates, benchmark.notation
        name = f"formats/{benchmark.name}_{ability.value}.txt"
        wording = benchmark.wording(ability)
        asked = _make_benchmark_for_prompt_examples(benchmark, wording, self.source)
        book = open_gold_answers(asked, ability, self.source)
        own_format = templates.read_user_template(name)
        own_texts = {} if own_format is None else {ability.value: own_format}
        return PromptTemplateValues(
            ability.value,
            wording,
            notation.english.role,
            benchmark.tasks_for(ability, self.source),
            own_format
            or notation.formats.get(ability)
            or templates.fill_template(
                f"formats/{ability.value}.txt", make_answer_format_samples_by_placeholder(wording)
            ),
            lambda task_id: book[task_id].text,
            beliefs,
            asked.tasks_for(ability, self.source),
            {**notation.short_texts, **own_texts},
        )

    def _has_user_file(self, benchmark: Benchmark, ability: Ability) -> bool:
        return self.folder is not None and (self.folder / f"{benchmark.name}_{ability.value}.json").exists()

    def _read_user_prompts(self, benchmark: Benchmark, ability: Ability) -> Mapping[str, str]:
        """Return task id -> the user's prompt that replaces the prompt of the set."""
        if self.folder is None or not self._has_user_file(benchmark, ability):
            return {}
        prompts = read_prompt_file(self.folder / f"{suite_name(benchmark.name, ability)}.json")
        return {benchmark.data.task_id_of(i) or i: text for i, text in prompts.items()}

    def _replace_by_user_prompts(
        self, prompts: Mapping[str, Prompt], benchmark: Benchmark, ability: Ability
    ) -> Mapping[str, Prompt]:
        if self.folder is None:
            return prompts
        name = suite_name(benchmark.name, ability)
        file, system_file = self.folder / f"{name}.json", self.folder / f"{name}_system.json"
        if user_prompts := self._read_user_prompts(benchmark, ability):
            for task_id in user_prompts:
                if task_id not in prompts:
                    raise InputError(f"{file}: identifier {task_id!r} is not one of the tasks of {name}")
            prompts = {
                i: replace(prompt, user=user_prompts.get(i, prompt.user)) for i, prompt in prompts.items()
            }
        if system_file.exists():
            system = read_system_message_file(system_file)
            prompts = {i: replace(prompt, system=system) for i, prompt in prompts.items()}
        return prompts


def _make_benchmark_for_prompt_examples(
    benchmark: Benchmark, wording: PromptAndAnswerWording, source: Source
) -> Benchmark:
    """Return the benchmark from which prompts take examples.

    If the wording of the prompts comes from the benchmark's declaration, the result has only one task, which
    is made as an example: no prompt may show the answer to an evaluated task.
    """
    if not benchmark.uses_declared_names_in_prompts:
        return benchmark
    tasks = benchmark.tasks(source).values()
    example = make_example_task_for_prompts(benchmark.domain, tasks, wording.predicates) if tasks else None
    return replace(benchmark, open_tasks=use_tasks(*filter(None, [example])))


def _replace_prompt_goals_by_believed_goals(
    prompts: Mapping[str, Prompt], benchmark: Benchmark, ability: Ability, beliefs: Mapping[str, BelievedTask]
) -> Mapping[str, Prompt]:
    """Return the prompts, in which goals that a model stated replace the goals of the tasks."""
    section = benchmark.data.goal_sections.get(ability)
    if beliefs and section is None:
        raise InputError(
            f"{benchmark.name} {ability.value}: in the published prompts, goals from a model's answers "
            "(option goals) cannot replace the tasks' goals; use --set eai"
        )
    return {
        task_id: prompt
        if section is None or task_id not in beliefs
        else replace(prompt, user=section.replace_goals_in_question(prompt.user, beliefs[task_id]))
        for task_id, prompt in prompts.items()
    }


def _check_prompt_folder(folder: Path, benchmark: Benchmark) -> None:
    """Raise InputError if a path is no folder with prompts, or if a file in it replaces no prompt."""
    files = find_files_below(folder, "*.json*", "*.txt*")
    if not files:
        raise InputError(f"{folder}: expected a folder of prompts, with files such as BENCHMARK_ABILITY.json")
    names = dict.fromkeys((*list_benchmarks(), benchmark.name))
    suites = {suite_name(name, ability) for name in names for ability in find_ability_entry_points()}
    expected_names = {
        *list_template_names(),
        *(f"{suite}{ending}.json" for suite in suites for ending in ("", "_system")),
        *(f"formats/{suite}.txt" for suite in suites),
    }
    for file in files:
        if file.relative_to(folder).as_posix() not in expected_names:
            raise InputError(
                f"{file}: no prompt or template has this name; expected <domain>_<ability>.json, "
                "<domain>_<ability>_system.json or the name of a template"
            )
