"""``eai run``: obtain a model's answers and score them."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from eai.abilities.protocol import Ability, Domain, Protocol
from eai.abilities.responses import SUFFIX, ResponseFile
from eai.abilities.suite import Source, Suite, available_suites, open_suite
from eai.cli.console import data_progress, errors, output, print_rates
from eai.cli.score import write_results
from eai.envs.batch import score_batch
from eai.errors import EaiError, InputError
from eai.metrics.rate import Rate
from eai.metrics.summary import TABLE_COLUMNS, summarise

if TYPE_CHECKING:
    from eai.run.evaluation import Answers


def run(
    model: Annotated[list[str], typer.Option(help="A model as Inspect names it, or eai/oracle, eai/noisy.")],
    domain: Annotated[list[Domain] | None, typer.Option(help="Domains; all if not given.")] = None,
    ability: Annotated[list[Ability] | None, typer.Option(help="Abilities; all if not given.")] = None,
    protocol: Annotated[Protocol, typer.Option(help="The rules for scoring.")] = Protocol.STRICT,
    tasks: Annotated[str, typer.Option(help="Only these tasks: ids separated by commas.")] = "",
    limit: Annotated[int | None, typer.Option(min=1, help="At most so many tasks of each suite.")] = None,
    model_arg: Annotated[
        list[str] | None, typer.Option("-M", help="An argument of the model, as NAME=VALUE.")
    ] = None,
    model_base_url: Annotated[str | None, typer.Option(help="Where a local server listens.")] = None,
    out: Annotated[Path, typer.Option(help="Where answers, logs, records and summaries go.")] = Path("runs"),
) -> None:
    """Obtain answers to the official prompts through Inspect and score them.

    Example: eai run --model eai/noisy -M rate=0.2 --domain virtualhome --ability action_sequencing
    """
    with data_progress() as report:
        suites = [
            open_suite(d, a, protocol, source=Source(report=report))
            for d, a in available_suites()
            if d in (domain or Domain) and a in (ability or Ability)
        ]
    if not suites:
        raise InputError("no suite has this domain and this ability yet")
    arguments = dict(_pair(text) for text in model_arg or ())
    for suite in suites:
        task_ids = _chosen(tasks, suite)
        rates = {
            name: _run_model(suite, _ask(suite, name, task_ids, limit, arguments, model_base_url, out), out)
            for name in model
        }
        title = f"{suite.domain.value}, {suite.ability.value}, protocol {protocol.value} (percent)"
        print_rates(title, TABLE_COLUMNS[suite.ability], rates)
    output().print(f"written to {out}", soft_wrap=True, highlight=False)


def _ask(
    suite: Suite,
    model: str,
    task_ids: tuple[str, ...],
    limit: int | None,
    arguments: Mapping[str, str],
    base_url: str | None,
    out: Path,
) -> Answers:
    """Obtain a model's answers through Inspect, which is imported only here."""
    try:
        from eai.run.evaluation import Job, obtain_answers
    except ImportError as error:
        hint = "pip install 'embodied-agent-interface[run]'"
        raise EaiError(f"model runs need inspect-ai ({error.name} is missing): {hint}") from error
    job = Job(
        model=model,
        domain=suite.domain,
        ability=suite.ability,
        protocol=suite.protocol,
        limit=limit,
        task_ids=task_ids,
        model_args=arguments,
        model_base_url=base_url,
    )
    return obtain_answers(job, out / "logs", display="rich" if sys.stderr.isatty() else "none")


def _run_model(suite: Suite, answers: Answers, out: Path) -> dict[str, Rate]:
    """Write a model's answers, score them and write the results."""
    for task_id, why in answers.unanswered.items():
        errors().print(f"task {task_id} was not answered: {why}", markup=False, highlight=False)
    file = answers.file
    if not file.responses:
        raise EaiError(f"{file.model} answered none of the tasks; see {answers.log}")
    folder = out / suite.domain.value / suite.ability.value / file.model
    _write_answers(folder, file)
    texts = [response.text for response in file.responses]
    settled = open_suite(suite.domain, suite.ability, suite.protocol, answers=texts)
    records = score_batch(settled, file)
    verdicts = [record.verdict for record in records]
    rates = summarise(verdicts, suite.domain.value, suite.ability, suite.protocol)
    write_results(folder, records, rates)
    return rates


def _write_answers(folder: Path, file: ResponseFile) -> None:
    """Write the answers as a response file, so that they can be scored again and elsewhere."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = [{"identifier": r.task_id, "llm_output": r.text} for r in file.responses]
    (folder / f"{file.model}{SUFFIX}").write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


def _chosen(tasks: str, suite: Suite) -> tuple[str, ...]:
    """The tasks named on the command line."""
    chosen: Sequence[str] = [task_id.strip() for task_id in tasks.split(",") if task_id.strip()]
    for task_id in chosen:
        if task_id not in suite.task_ids:
            raise InputError(f"--tasks: {task_id!r} is not a task of {suite.domain.value}")
    return tuple(chosen)


def _pair(text: str) -> tuple[str, str]:
    name, separator, value = text.partition("=")
    if not separator:
        raise InputError(f"-M {text}: expected NAME=VALUE")
    return name, value
