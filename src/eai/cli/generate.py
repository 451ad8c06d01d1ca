"""``eai generate``: new tasks in the world of a benchmark, each with a plan that solves it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from rich.table import Table

from eai.agents.reference import add_reference_plans
from eai.base.errors import EaiError, InputError, UserInterruptError, did_you_mean
from eai.base.files import raise_write_errors_as_input_errors
from eai.base.json_value import Json
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator import sets
from eai.benchmarks.generator.generator import TaskGenerator, generate_from_seeds
from eai.benchmarks.generator.measures import TaskMeasure
from eai.benchmarks.generator.seed_batches import (
    make_tasks_from_seed_batch,
    open_generator,
    unpickle_task_generation_outcome,
)
from eai.benchmarks.generator.seeds import select_tasks
from eai.benchmarks.generator.spec import (
    GeneratedTask,
    GenerationOutcome,
    GoalFormFrequency,
    HeldOut,
    PlanLengthTier,
    SeedRejectionReason,
    TaskKind,
    TaskSpecification,
    TaskSplit,
)
from eai.benchmarks.registry import find_benchmark
from eai.cli.console import DOMAIN_HELP, format_count, get_output_console, print_result
from eai.cli.options import (
    AsJson,
    DataFolder,
    OnRay,
    Seed,
    Workers,
    make_flag,
    open_data_source,
    open_scoring_workers,
)
from eai.cli.progress import show_generation_progress, show_scoring_progress
from eai.pddl.export import export_domain_and_problem
from eai.pddl.val import NOT_VALID, VALID, find_val_program, run_val
from eai.results.workers import WorkerPool
from eai.tasks.task import Task
from eai.tasks.task_files import make_task_file_content, write_task_file
from eai.tasks.task_lines import write_task_line
from eai.world.action import Action
from eai.world.domain import Domain

_MAX_BATCH_SEEDS = 4
"""Maximum number of seeds in one batch of a worker process.

A seed may take seconds, and work on unfinished seeds is lost when the command ends.
"""


def validate_with_val(val: Path, domain: Domain, task: Task, plan: Sequence[Action]) -> str:
    """Return the verdict of the plan validator VAL on a plan, as text.

    Raises:
        DomainError: A goal concerns states during the plan, which PDDL goals cannot express.
    """
    exported = export_domain_and_problem(domain, task.initial, [goal.formula for goal in task.goals])
    return run_val(val, exported.domain, exported.problem, [exported.to_pddl_step(action) for action in plan])


def generate_tasks(
    like: Annotated[str, make_flag(help=f"Whose world the tasks are in. {DOMAIN_HELP}")],
    out: Annotated[Path, make_flag()],
    n: Annotated[int, make_flag(min=1)] = 100,
    seed: Seed = 0,
    split: TaskSplit = TaskSplit.ALL,
    held_out: HeldOut = "goals",
    against: Annotated[list[Path] | None, make_flag(metavar="PATH")] = None,
    secret: Annotated[str | None, make_flag(envvar="EAI_SECRET")] = None,
    tier: Annotated[PlanLengthTier, make_flag(metavar="SIZE")] = PlanLengthTier.DATA,
    forms: GoalFormFrequency = "data",
    actions: bool = False,
    kind: TaskKind = TaskKind.PLAIN,
    by_place: bool = False,
    objects: Annotated[int, make_flag(min=2)] = 30,
    depth: Annotated[int, make_flag(min=1)] = 1,
    difficulty: Annotated[str | None, make_flag(metavar="LOW:HIGH")] = None,
    at_least: Annotated[
        list[str] | None,
        make_flag(
            help=f"Only tasks with so many of {', '.join([each.value for each in TaskMeasure])}. Repeatable.",
            metavar="NAME=N",
        ),
    ] = None,
    val: bool = False,
    workers: Workers = None,
    ray: OnRay = None,
    compress: Annotated[bool, make_flag("--gzip")] = False,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Generate new tasks, each with a plan that solves it. Equal arguments give equal bytes.

    OUT/SPLIT.jsonl is a task file. OUT/generated.json has its arguments and statistics of the tasks.

    Example: eai generate --like virtualhome --n 500 --seed 7 --out tasks/

    Options:
        out: Output folder.
        n: Number of tasks.
        split: Name of the file. The files train, validation and test share no goals; the file tasks may share
            goals with each.
        held_out: What train, validation and test do not share: goals, starts (goals and initial state
            together), pairs of predicate and object kind, titles, or scenes.
        against: Other task files, such as training tasks. Their tasks, and tasks that their plans solve, are
            refused. Repeatable.
        secret: A secret that is needed to make the same tasks again.
        tier: Steps of a plan: S 3-6, M 7-12, L 13-24, XL 25-48, XXL 49-96; data: as in the data set.
        forms: Shapes of goals: those of the data set, or all equally often.
        actions: Also generate action goals, if the data set has any.
        kind: order: goals about an order, or about a state to avoid. hazards: the shortest plan is unsafe;
            untold-hazards: and the instruction does not mention it. pairs: N pairs of tasks, one without a
            plan. ambiguous: N pairs, one with words that fit two objects.
        by_place: Instructions describe objects by their location, not by names.
        objects: Maximum number of objects in a scene; VirtualHome needs 40 for --tier XL.
        depth: Search all plans of this length, for a lower bound of plan lengths.
        difficulty: Expected difficulty in logits, as in 0:2; a rough guide.
        val: Also check the plan of every task with VAL, which must be installed.
        compress: Write FILE.jsonl.gz.
    """
    validator = find_val_program() if val else None
    if kind.has_temporal_goal and val:
        raise InputError(f"--val: VAL cannot check goals over time; leave out --kind {kind.value}")
    plain, zipped = out / f"{split.value}.jsonl", out / f"{split.value}.jsonl.gz"
    file, other_form = (zipped, plain) if compress else (plain, zipped)
    if other_form.exists():
        raise InputError(
            f"{other_form}: the set {split.value} is there already; delete the file, or write it again "
            f"{'without' if compress else 'with'} --gzip"
        )
    benchmark = find_benchmark(like)
    with open_data_source(data) as source:
        tasks = benchmark.tasks(source)
    spec = TaskSpecification(
        like,
        tasks.sha256,
        tier,
        forms,
        actions=actions,
        kind=kind,
        by_place=by_place,
        most_objects=objects,
        depth=depth,
        difficulty=None if difficulty is None else _parse_range(difficulty),
        at_least=tuple(sorted(map(_parse_minimum, at_least or ()))),
        split=split,
        held_out=held_out,
    )
    others = sets.find_other_task_sets_of_benchmark(out, like, excluded_file=file)
    earlier = {
        name: path
        for name, path in others.items()
        if sets.is_earlier_in_train_validation_test_order(name, split.value)
    }
    later = {
        name: path
        for name, path in others.items()
        if sets.is_earlier_in_train_validation_test_order(split.value, name)
    }
    for path in against or ():
        others[str(path)] = earlier[str(path)] = path
    other_tasks = {name: sets.read_tasks_of_set(path, benchmark.domain) for name, path in others.items()}
    known = {sets.fingerprint_task(task, held_out) for tasks in other_tasks.values() for task in tasks}
    # generating takes long, so check first that the folder can be written
    with raise_write_errors_as_input_errors(out):
        out.mkdir(parents=True, exist_ok=True)
    generator = open_generator(spec, source, tuple(earlier.values()), tuple(later.values()))
    seeds = sets.make_seeds(split.value, seed, secret)
    with open_scoring_workers(workers, ray) as pool:
        fingerprints_with_copies: list[tuple[str, str]] = []
        generated = _generate_with_workers(generator, seeds, n, known, fingerprints_with_copies, pool)
        write_lines = partial(_make_task_file_lines, benchmark_name=like, benchmark=benchmark)
        outcomes, lines, stopped = _collect_outcomes_and_task_lines(
            generated, n, like, write_lines, quiet=as_json
        )
    made = [each for each in outcomes if isinstance(each, GeneratedTask)]
    rejected = [each for each in outcomes if isinstance(each, SeedRejectionReason)]
    if stopped is not None and (not made or file.exists()):
        raise stopped
    validated = ""
    if validator is not None:
        plans = [each.task for each in made]
        undecided = _validate_plans_and_count_undecided(validator, benchmark.domain, plans, quiet=as_json)
        validated = "; VAL accepts every certificate"
        if undecided:
            validated = f"; VAL accepts {len(plans) - undecided:,} certificates, no answer on {undecided:,}"
    write_task_file(file, lines)
    fingerprints_with_copies = fingerprints_with_copies[
        : len(made) + rejected.count(SeedRejectionReason.COPY)
    ]
    content = make_task_file_content(lines)
    entry = sets.make_manifest_entry(spec, seed, secret, content, made, rejected, fingerprints_with_copies)
    new, domain = [each.task for each in made], benchmark.domain
    overlap = {
        (split.value, name): sets.measure_overlap(new, other_tasks[name], domain, held_out)
        for name in earlier
    }
    overlap |= {
        (name, split.value): sets.measure_overlap(other_tasks[name], new, domain, held_out) for name in later
    }
    sets.add_set_to_manifest(out, split.value, entry, overlap)
    estimate = sets.estimate_number_of_distinct_tasks(fingerprints_with_copies)
    if stopped is not None:
        kept = f"{format_count(len(made), 'task')} written to {file}, as with --n {len(made)}"
        raise type(stopped)(f"{stopped}; {kept}; {_describe_estimated_task_count(estimate)}")
    if not as_json:
        _print_task_statistics(
            sets.compute_set_statistics(list(tasks.values())),
            sets.compute_set_statistics([each.task for each in made]),
        )
    number = format_count(len(made), "task" if all(each.paired is None for each in made) else "pair")
    line = f"{number} written to {file}; {format_count(len(rejected), 'seed')} gave none"
    line += validated
    value: dict[str, Json] = {"file": str(file), "tasks": len(made), "rejected": len(rejected)}
    value["estimated_tasks"] = estimate
    print_result(line, _describe_estimated_task_count(estimate), value=value, as_json=as_json)


def _generate_with_workers(
    generator: TaskGenerator,
    seeds: Iterator[str],
    task_count: int,
    known_fingerprints: set[tuple[str, str]],
    fingerprints_with_copies: list[tuple[str, str]],
    pool: WorkerPool,
) -> Iterator[GenerationOutcome]:
    """Yield the task that each seed gives, or the reason why it gives none, until there are enough tasks.

    The tasks are equal for any number of workers.
    """
    if not pool.has_worker_processes:
        return generate_from_seeds(generator, seeds, task_count, known_fingerprints, fingerprints_with_copies)
    judge = partial(make_tasks_from_seed_batch, _add_reference_plans_to_generated_task, generator)
    vocabulary = generator.benchmark.domain.vocabulary
    judged = (
        unpickle_task_generation_outcome(content, vocabulary)
        for content in pool.map_batches(judge, seeds, batch_sizes=(1, _MAX_BATCH_SEEDS))
    )
    return select_tasks(judged, generator.spec, task_count, known_fingerprints, fingerprints_with_copies)


def _collect_outcomes_and_task_lines(
    generated: Iterator[GenerationOutcome],
    task_count: int,
    benchmark_name: str,
    write_lines: Callable[[GeneratedTask], Iterable[str]],
    *,
    quiet: bool,
) -> tuple[Sequence[GenerationOutcome], Sequence[str], InputError | UserInterruptError | None]:
    """Return the outcomes of seeds and the lines of their tasks, and the error if there are too few tasks.

    An interrupt is also returned as an error, with the outcomes and lines so far.
    The outcome of a seed is a task, or a reason why the seed gave no task. The lines of a task
    are made as soon as the task is generated, so that an interrupted command ends quickly.
    """
    outcomes: list[GenerationOutcome] = []
    lines: list[str] = []
    made = 0
    try:
        with show_generation_progress(f"generating {benchmark_name}", task_count, quiet=quiet) as report:
            for outcome in generated:
                new_lines = write_lines(outcome) if isinstance(outcome, GeneratedTask) else ()
                outcomes.append(outcome)
                lines += new_lines
                made += isinstance(outcome, GeneratedTask)
                report(made, len(outcomes) - made)
    except (InputError, KeyboardInterrupt) as error:
        while outcomes and isinstance(outcomes[-1], SeedRejectionReason):
            outcomes.pop()
        return outcomes, lines, error if isinstance(error, InputError) else UserInterruptError("interrupted")
    return outcomes, lines, None


def _describe_estimated_task_count(task_count: int | None) -> str:
    if task_count is None:
        return "no seed repeated a task, so the number of different tasks cannot be estimated"
    return f"estimated number of different tasks: at least {task_count:,}"


def _add_reference_plans_to_generated_task(made: GeneratedTask, benchmark: Benchmark) -> GeneratedTask:
    """Return a task, or a pair of tasks, with missing reference plans added."""
    paired = None if made.paired is None else _add_reference_plans_to_generated_task(made.paired, benchmark)
    return replace(made, task=add_reference_plans(made.task, benchmark), paired=paired)


def _make_task_file_lines(made: GeneratedTask, benchmark_name: str, benchmark: Benchmark) -> list[str]:
    """Return the lines of a task file for a generated task or pair of tasks, in the order of task ids."""
    completed = _add_reference_plans_to_generated_task(made, benchmark)
    pair = [one for one in (completed, completed.paired) if one is not None]
    return [
        write_task_line(one.task, benchmark_name, benchmark.domain, one.about)
        for one in sorted(pair, key=lambda one: one.task.id)
    ]


def _validate_plans_and_count_undecided(
    val: Path, domain: Domain, tasks: Sequence[Task], *, quiet: bool
) -> int:
    """Check the certificates (plans that solve the tasks) with VAL. Return on how many VAL gives no answer.

    Raises:
        EaiError: VAL rejects a certificate that the engine accepts, so no task can be trusted.
    """
    undecided = 0
    with show_scoring_progress("validating", len(tasks), quiet=quiet) as report:
        for number, task in enumerate(tasks, 1):
            verdict = validate_with_val(val, domain, task, task.script)
            if verdict == NOT_VALID:
                raise EaiError(
                    f"{task.id}: VAL rejects a plan that eai accepts, so no file is written; "
                    "report this contradiction, or leave out --val"
                )
            undecided += verdict != VALID
            report(number)
    return undecided


def _parse_range(text: str) -> tuple[float, float]:
    """Parse a range of difficulty, as in 0:2. The first number must not exceed the second."""
    low, _, high = text.partition(":")
    try:
        numbers = float(low), float(high)
    except ValueError:
        numbers = (1.0, 0.0)
    if not numbers[0] <= numbers[1]:
        raise InputError(f"--difficulty: expected two numbers LOW:HIGH, as in 0:2, found {text!r}")
    return numbers


def _parse_minimum(text: str) -> tuple[TaskMeasure, int]:
    """Parse a measure of tasks and its minimum value, as in containers=1."""
    name, _, number = text.partition("=")
    names = [measure.value for measure in TaskMeasure]
    if name not in names or not number.isdecimal():
        hint = did_you_mean(name, names) if name not in names else ""
        raise InputError(f"--at-least: expected NAME=N, as in containers=1, found {text!r}{hint}")
    return TaskMeasure(name), int(number)


def _print_task_statistics(data_set: Mapping[str, Any], generated: Mapping[str, Any]) -> None:
    """Print numbers of steps, goals and objects, and shapes of goals, for the data set and the new tasks."""
    table = Table("min, quartiles, max", "data set", "generated")
    for name in ("steps", "goals", "objects"):
        table.add_row(name, *(", ".join(map(str, shape[name])) for shape in (data_set, generated)))
    forms = [[f"{form} {n}" for form, n in shape["forms"].items()] for shape in (data_set, generated)]
    table.add_row("forms", *map("\n".join, forms))
    get_output_console().print(table)
