"""The benchmark as Inspect tasks, for ``eai run`` and for ``inspect eval eai/...`` alike.

Inspect's command line, which is click's, refuses arguments that cannot be used in one line.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import click
import inspect_ai
from inspect_ai.dataset import MemoryDataset, Sample
from inspect_ai.log import HeadlineMetric
from inspect_ai.model import GenerateConfig
from inspect_ai.solver import Solver
from inspect_ai.util import registry_info

from eai.abilities.codec import experiment_to_json
from eai.abilities.declaration import declaration_of
from eai.abilities.experiment import Experiment
from eai.abilities.protocol import DEFAULT_PROTOCOL, Ability
from eai.abilities.verdict import Json
from eai.acting.play import in_setting
from eai.acting.setting import ACTING, AGENT, Setting
from eai.benchmark.gold_answers import open_answer_book
from eai.benchmark.prompt_library import Library
from eai.benchmark.registry import find_benchmark
from eai.benchmark.suite import Suite, open_suite
from eai.errors import InputError, did_you_mean
from eai.pddl.planning import PlannerChoice
from eai.prompts.prompt import Prompt
from eai.run.acting import enter, player
from eai.run.job import ERRATA
from eai.run.scorer import EXPERIMENT, SCORERS
from eai.run.solver import ask_as_published, messages_of
from eai.run.spec import read_spec, study_of
from eai.scoring.epochs import Believed, SuiteResult
from eai.scoring.trials import open_trials
from eai.studies.variation import Endpoint, Stage
from eai.tasks.source import ErrataChoice, Source, suite_name


class _RefusalError(InputError, click.ClickException):
    """An argument of a task or a model that cannot be used."""


@contextmanager
def refusing() -> Iterator[None]:
    """Input that cannot be used ends what is in the block as a `_RefusalError`."""
    try:
        yield
    except InputError as error:
        raise _RefusalError(str(error)) from error


def build_task(
    suite: Suite,
    prompts: Mapping[str, Prompt],
    solver: Solver,
    *,
    metadata: Mapping[str, Json] | None = None,
    experiment: Experiment | None = None,
    about: Mapping[str, Mapping[str, str]] | None = None,
) -> inspect_ai.Task:
    """The Inspect task that puts prompts to a model, each with its task's id and gold answer.

    Args:
        suite: what is asked.
        prompts: the questions by id of their task.
        solver: what asks them.
        metadata: what the log says of the task besides its domain and ability.
        experiment: what it is an experiment of, if answers are carried out in one.
        about: what the built-in models are to know of questions besides, by task.
    """
    benchmark, ability, source = suite.benchmark, suite.ability, suite.source
    name = suite_name(benchmark.name, ability)
    book = open_answer_book(benchmark, ability, source)
    gold = {task_id: book[task_id].text for task_id in book if task_id in prompts}
    of_all = {"domain": benchmark.reference, "ability": ability.value, ERRATA: source.errata.value}
    of_experiment = {} if experiment is None else {EXPERIMENT: experiment_to_json(experiment)}
    samples = []
    for task_id, prompt in prompts.items():
        known = {**of_all, "task_id": task_id, **(about or {}).get(task_id, {})}
        told: dict[str, Json] = {**known, "stop": list(prompt.stop), **of_experiment}
        question = messages_of(prompt, known)
        samples.append(Sample(input=question, target=gold.get(task_id, ""), id=task_id, metadata=told))
    rules = suite.protocol.value, source.planner.value, source.errata.value
    return inspect_ai.Task(
        dataset=MemoryDataset(samples, name=name),
        solver=solver,
        scorer=SCORERS[ability](benchmark.reference, *rules),
        headline_metric=HeadlineMetric(metric=next(iter(declaration_of(ability).main))),
        name=name,
        metadata={"domain": benchmark.name, "ability": ability.value, **(metadata or {})},
    )


def published_task(reference: str, ability: Ability) -> Callable[..., inspect_ai.Task]:
    """Register a suite as an Inspect task, ``eai/<domain>_<ability>``.

    Without a reference it is ``eai/<ability>``, to which ``-T domain=`` names the benchmark.
    """

    def suite(
        domain: str = reference,
        protocol: str = DEFAULT_PROTOCOL.value,
        prompts: str = "official",
        prompt_folder: str | None = None,
        planner: str = PlannerChoice.AUTO.value,
        errata: str = ErrataChoice.CURRENT.value,
        tasks: str | int | Sequence[str] | None = None,
        **studies: Any,
    ) -> inspect_ai.Task:
        with refusing():
            spec = read_spec(
                {
                    "prompts": {"set": prompts, "folder": prompt_folder},
                    "scoring": {"protocol": protocol, "planner": planner, "errata": errata},
                    **_of_sections(ability, studies),
                }
            )
            scoring, experiment = spec.scoring, spec.variation.experiment
            source = Source(planner=scoring.planner, errata=scoring.errata)
            suite = open_suite(find_benchmark(domain), ability, scoring.protocol, source=source)
            library = Library(spec.prompts.set, spec.prompts.folder, source)
            questions = library.open(suite.benchmark, ability)
            asked = questions if tasks is None else _only(questions, tasks)
            about: Mapping[str, Mapping[str, str]] = {}
            solver = ask_as_published(None)
            stage = spec.variation.stage(library, {suite.domain: asked}, _ask_nobody)
            if ability is ACTING:
                asked, about = in_setting(spec.agent, asked, suite)
                experiment, solver = None, player()
            elif stage is not None:
                spec.variation.abilities([ability])
                asked, believed = _staged(stage, asked, suite)
                experiment, about = believed.experiment, believed.about
            elif experiment is not None:
                asker = library.asker(suite.benchmark, ability, asked)
                solver = ask_as_published(open_trials(suite, experiment, asker, asked))
        task = build_task(suite, asked, solver, experiment=experiment, about=about)
        task.config = GenerateConfig(temperature=0.0)
        task.score_on_error = True
        task.setup = enter() if ability is ACTING else None
        return task

    name = suite_name(reference, ability).lstrip("_")
    registered = inspect_ai.task(name=name)(suite)
    if registry_info(registered).name == name:  # Inspect names the package only where it is not editable
        registered = inspect_ai.task(name=f"eai/{name}")(suite)
    return registered


def _of_sections(ability: Ability, arguments: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """The options of agents and studies as sections of a specification.

    Raises:
        InputError: there is no such option, or it is of a model that would be asked first.
    """
    tables: dict[str, dict[str, Any]] = {}
    for name, value in arguments.items():
        if ability is ACTING and name in Setting.model_fields:
            tables.setdefault(AGENT, {})[name] = value
            continue
        if name.startswith("scene_") or (name, value) == ("scene", "predicted"):
            raise InputError(f"{name}: in Inspect no second model lists scenes; eai run asks one")
        tables.setdefault(study_of(name), {})[name] = value
    return tables


def _ask_nobody(*_: object, **__: object) -> SuiteResult:
    raise InputError("goals: in Inspect those of answers that there are; eai run asks for a model's own")


def _staged(stage: Stage, asked: Mapping[str, Prompt], suite: Suite) -> tuple[Mapping[str, Prompt], Believed]:
    """The same questions stating what came of an earlier stage, and that.

    Raises:
        InputError: there is nothing to state of a task; a log would leave it out of all rates.
    """
    prompts, believed = stage.second(Endpoint(""), asked, suite)
    missing = len(asked) - len(prompts)
    if missing:
        raise InputError(
            f"{missing} of {len(asked)} tasks cannot be asked: {believed.lacking}; "
            "leave them out with -T tasks=, or take eai run, which counts them as failed"
        )
    return prompts, believed


def _only(prompts: Mapping[str, Prompt], tasks: str | int | Sequence[str]) -> Mapping[str, Prompt]:
    """The prompts of the named tasks, in the order of the data set.

    Raises:
        InputError: a name is no name of a task, or could be that of several.
    """
    if isinstance(tasks, int):  # Inspect reads arguments as YAML, in which 27_2 is the number 272
        meant = [task_id for task_id in prompts if task_id.replace("_", "") == str(tasks)]
        if len(meant) != 1:
            raise InputError(f"tasks={tasks} is a number and no task; --sample-id takes ids as they are")
        tasks = meant
    named = {task_id.strip() for task_id in ([tasks] if isinstance(tasks, str) else tasks)} - {""}
    for task_id in named - prompts.keys():
        hint = did_you_mean(task_id, prompts)
        raise InputError(f"tasks: {task_id!r} is not a task of this suite{hint}")
    return {task_id: prompts[task_id] for task_id in prompts if task_id in named}
