"""``eai annotate problems``: planning problems from the goals of tasks."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.transition_modeling.planners import make_planner
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.registry import find_benchmark
from eai.cli.console import DOMAIN_HELP, counted, data_progress, note, print_json, say
from eai.cli.options import AsJson, Planner
from eai.cli.progress import scoring_progress
from eai.cli.store import DataFolder, store
from eai.data.files import write_whole
from eai.errors import InputError
from eai.pddl.model import PddlDomain
from eai.pddl.planning import PlannerChoice, PlannerOutcome
from eai.studies.annotation.problems import Problem, domain_of, make_problem, with_one_domain
from eai.tasks.source import Source

DOMAIN_FILE = "domain.pddl"


def problems(
    domain: Annotated[str, typer.Option(help=DOMAIN_HELP)],
    out: Annotated[Path, typer.Option(help="Where domain and problems go.")],
    conditions: Annotated[int, typer.Option(min=1, help="The most conditions of a goal.")] = 4,
    seed: Annotated[int, typer.Option(help="Of what is drawn.")] = 0,
    limit: Annotated[int | None, typer.Option(min=1, help="Tasks, at most.")] = None,
    planner: Planner = PlannerChoice.AUTO,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write a planning problem a task: some ground conditions of its goal that a planner reaches.

    One way to meet the goal is drawn, and of its conditions some; what cannot be solved is drawn again. Exit
    status 1 if a task is left without a problem that can be solved.

    Example: eai annotate problems --domain behavior --out problems --limit 5
    """
    with data_progress() as report:
        benchmark, source = find_benchmark(domain), Source(store(data), report)
        tasks = benchmark.tasks(source)
        operators = _published(benchmark, source)
    judge = make_planner(planner, benchmark.planner_seconds)
    if judge is None:
        raise InputError("--planner none: problems are kept if they can be solved")
    made: list[Problem] = []
    chosen = [tasks[task_id] for task_id in list(tasks)[:limit]]
    with scoring_progress("planning", len(chosen), quiet=False) as told:
        for number, task in enumerate(chosen, 1):
            problem = make_problem(
                task, benchmark, judge, operators=operators, conditions=conditions, seed=seed
            )
            if problem is not None:
                made.append(problem)
            told(number)
    made = with_one_domain(made, benchmark)
    _write(out, made)
    failed = [problem for problem in made if problem.outcome is not PlannerOutcome.SOLVED]
    if as_json:
        print_json({each.task_id: {"outcome": each.outcome.value, "draws": each.draws} for each in made})
    else:
        say(f"{counted(len(made) - len(failed), 'problem')} written to {out}")
    for each in failed:
        note(f"{each.task_id}: no draw can be solved ({each.outcome.value}, {each.draws} draws)")
    if failed:
        raise typer.Exit(1)


def _published(benchmark: Benchmark, source: Source) -> PddlDomain | None:
    """The planning domain that comes with the data set, where its problems are of one."""
    if benchmark.problem_of is None:
        return None
    library = next(iter(benchmark.operators(source).values())).domain
    return domain_of([text.pddl for text in library.operators.values()], library.header)


def _write(folder: Path, made: list[Problem]) -> None:
    solved = [each for each in made if each.outcome is PlannerOutcome.SOLVED]
    names = [re.sub(r"[^\w.-]", "_", each.task_id) for each in solved]
    texts = {folder / f"{name}.pddl": f"{each.text}\n" for name, each in zip(names, solved, strict=True)}
    if made:
        write_whole({**texts, folder / DOMAIN_FILE: f"{made[0].domain}\n"})
