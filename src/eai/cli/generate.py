"""``eai generate``: new tasks in the world of a benchmark, each with a plan that solves it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Annotated, Any

from rich.progress import Progress
from rich.table import Table

from eai.base.errors import EaiError, InputError, InterruptError, did_you_mean
from eai.base.files import convert_write_errors
from eai.benchmarks.generator import sets
from eai.benchmarks.generator.generator import Generator, generate
from eai.benchmarks.generator.measures import Measure
from eai.benchmarks.generator.spec import (
    Forms,
    Generated,
    GenerationOutcome,
    HeldOut,
    Reason,
    Spec,
    Split,
    TaskKind,
    Tier,
)
from eai.benchmarks.registry import find_benchmark
from eai.cli.console import DOMAIN_HELP, counted, errors, output, tell
from eai.cli.options import AsJson, DataFolder, Seed, flag, opened_source
from eai.pddl.export import export
from eai.pddl.val import VALID, find_val, run_val
from eai.tasks.task import Task
from eai.tasks.task_files import open_task_files, task_file_content, write_task_file
from eai.tasks.task_lines import write_task_line
from eai.world.action import Action
from eai.world.domain import Domain


def verdict_of_val(val: Path, domain: Domain, task: Task, plan: Sequence[Action]) -> str:
    """The verdict of VAL on a plan.

    Raises:
        DomainError: a goal is about more than the end, of which PDDL says nothing.
    """
    exported = export(domain, task.initial, [goal.formula for goal in task.goals])
    return run_val(val, exported.domain, exported.problem, [exported.step(action) for action in plan])


def generate_tasks(
    like: Annotated[str, flag(help=f"Whose world the tasks are in. {DOMAIN_HELP}")],
    out: Annotated[Path, flag()],
    n: Annotated[int, flag(min=1)] = 100,
    seed: Seed = 0,
    split: Split = Split.ALL,
    held_out: HeldOut = "goals",
    against: Annotated[list[Path] | None, flag(metavar="PATH")] = None,
    secret: Annotated[str | None, flag(envvar="EAI_SECRET")] = None,
    tier: Annotated[Tier, flag(metavar="SIZE")] = Tier.DATA,
    forms: Forms = "data",
    actions: bool = False,
    kind: TaskKind = TaskKind.PLAIN,
    by_place: bool = False,
    objects: Annotated[int, flag(min=2)] = 30,
    depth: Annotated[int, flag(min=1)] = 1,
    difficulty: Annotated[str | None, flag(metavar="LOW:HIGH")] = None,
    at_least: Annotated[
        list[str] | None,
        flag(
            help=f"Only tasks with so many of {', '.join(measure.value for measure in Measure)}. Repeatable.",
            metavar="NAME=N",
        ),
    ] = None,
    val: bool = False,
    compress: Annotated[bool, flag("--gzip")] = False,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Generate tasks that nobody has seen. Equal arguments give equal bytes.

    OUT/SPLIT.jsonl is a task file; OUT/generated.json says how it was made and what the tasks are like.

    Example: eai generate --like virtualhome --n 500 --seed 7 --out tasks/

    Options:
        out: The folder to write to.
        n: How many tasks.
        split: Name of the file. train, validation and test have no goals in common; tasks is no split.
        held_out: What splits share nothing of: goals, pairs of predicate and kind of thing, titles, scenes.
        against: Task files elsewhere, say those of train: what is in them, or is solved by looking it up
            there, is refused. Repeatable.
        secret: A secret without which nobody can make the same tasks.
        tier: Steps of a plan: S 3-6, M 7-12, L 13-24, XL 25-48, XXL 49-96; data: as in the data set.
        forms: Shapes of goals: those of the data set, or all equally often.
        actions: Also ask for actions to be taken, where the data set does.
        kind: order: also ask for an order, or that something never be so. hazards: the shortest way is not
            safe; untold-hazards: and nothing says so. pairs: N pairs, one of each without a plan. ambiguous:
            N pairs, the words of one of each fit two things.
        by_place: Instructions tell things by where they are, not by names.
        objects: How many objects a scene has at most; VirtualHome needs 40 for --tier XL.
        depth: Try all plans of so many actions, as a lower bound of plan lengths.
        difficulty: Expected difficulty in logits, as in 0:2; a rough guide.
        val: Also have VAL check every certificate; it must be installed.
        compress: Write FILE.jsonl.gz.
    """
    validator = find_val() if val else None
    if kind.is_over_time and val:
        raise InputError(f"--val: VAL knows no goals over time; leave out --kind {kind.value}")
    benchmark = find_benchmark(like)
    with opened_source(data) as source:
        tasks = benchmark.tasks(source)
    spec = Spec(
        like,
        tasks.sha256,
        tier,
        forms,
        actions=actions,
        kind=kind,
        by_place=by_place,
        most_objects=objects,
        depth=depth,
        difficulty=None if difficulty is None else _between(difficulty),
        at_least=tuple(sorted(map(_at_least, at_least or ()))),
        split=split,
        held_out=held_out,
    )
    file = out / f"{split.value}.jsonl{'.gz' if compress else ''}"
    others = sets.read_other_sets(out, like, benchmark.domain, without=file)
    earlier = {name: made for name, made in others.items() if sets.is_earlier_split(name, split.value)}
    later = {name: made for name, made in others.items() if sets.is_earlier_split(split.value, name)}
    for path in against or ():
        others[str(path)] = earlier[str(path)] = list(open_task_files(path).tasks(benchmark.domain).values())
    known = {sets.fingerprint_task(task) for tasks in others.values() for task in tasks}
    rivals = sets.make_leak_test(benchmark.domain, chain(*earlier.values()), chain(*later.values()))
    with convert_write_errors(out):  # generating takes long enough to know first that tasks can be written
        out.mkdir(parents=True, exist_ok=True)
    generator = Generator(benchmark, spec, source, rivals)
    outcomes, stopped = _collect(generate(generator, sets.make_seeds(split.value, seed, secret), n, known), n)
    made = [each for each in outcomes if isinstance(each, Generated)]
    rejected = [each for each in outcomes if isinstance(each, Reason)]
    if stopped is not None and (not made or file.exists()):
        raise stopped
    if validator is not None:
        _validate(validator, benchmark.domain, [each.task for each in made])
    lines = [
        write_task_line(one.task, like, benchmark.domain, one.about)
        for each in made
        for one in sorted(
            [one for one in (each, each.paired) if one is not None], key=lambda one: one.task.id
        )
    ]
    write_task_file(file, lines)
    entry = sets.make_manifest_entry(spec, seed, secret, task_file_content(lines), made, rejected)
    new, domain = [each.task for each in made], benchmark.domain
    overlap = {
        (split.value, name): sets.measure_overlap(new, known, domain) for name, known in earlier.items()
    }
    overlap |= {
        (name, split.value): sets.measure_overlap(known, new, domain) for name, known in later.items()
    }
    sets.write_manifest(out, split.value, entry, overlap)
    if stopped is not None:
        kept = f"{counted(len(made), 'task')} written to {file}, those that --n {len(made)} gives"
        raise type(stopped)(f"{stopped}; {kept}")
    if not as_json:
        _print_shapes(
            sets.measure_shape(list(tasks.values())), sets.measure_shape([each.task for each in made])
        )
    number = counted(len(made), "task" if all(each.paired is None for each in made) else "pair")
    line = f"{number} written to {file}; {counted(len(rejected), 'seed')} gave none"
    line += "; VAL accepts every certificate" if val else ""
    tell(line, value={"file": str(file), "tasks": len(made), "rejected": len(rejected)}, as_json=as_json)


def _collect(
    found: Iterator[GenerationOutcome], number: int
) -> tuple[Sequence[GenerationOutcome], InputError | InterruptError | None]:
    """The outcomes of seeds, up to the last of so many tasks, and why there are fewer, if there are."""
    outcomes: list[GenerationOutcome] = []
    try:
        with Progress(console=errors(), transient=True, disable=not errors().is_terminal) as bar:
            shown = bar.add_task("generating", total=number)
            for outcome in found:
                outcomes.append(outcome)
                bar.update(shown, advance=isinstance(outcome, Generated))
    except (InputError, KeyboardInterrupt) as error:
        while outcomes and isinstance(outcomes[-1], Reason):
            outcomes.pop()
        return outcomes, error if isinstance(error, InputError) else InterruptError("interrupted")
    return outcomes, None


def _validate(val: Path, domain: Domain, tasks: Sequence[Task]) -> None:
    """Have VAL check all certificates.

    Raises:
        EaiError: it does not accept one: the engine and it do not agree, and no task is to be trusted.
    """
    with Progress(console=errors(), transient=True, disable=not errors().is_terminal) as bar:
        for task in bar.track(tasks, description="validating"):
            verdict = verdict_of_val(val, domain, task, task.script)
            if verdict != VALID:
                raise EaiError(f"{task.id}: VAL says of the certificate: {verdict}; nothing is written")


def _between(text: str) -> tuple[float, float]:
    """Two numbers, of which the first is not the greater."""
    low, _, high = text.partition(":")
    try:
        numbers = float(low), float(high)
    except ValueError:
        numbers = (1.0, 0.0)
    if not numbers[0] <= numbers[1]:
        raise InputError(f"--difficulty: expected two numbers LOW:HIGH, as in 0:2, found {text!r}")
    return numbers


def _at_least(text: str) -> tuple[Measure, int]:
    """A measure, and its least number."""
    name, _, number = text.partition("=")
    names = [measure.value for measure in Measure]
    if name not in names or not number.isdecimal():
        hint = did_you_mean(name, names) if name not in names else ""
        raise InputError(f"--at-least: expected NAME=N, as in containers=1, found {text!r}{hint}")
    return Measure(name), int(number)


def _print_shapes(public: Mapping[str, Any], made: Mapping[str, Any]) -> None:
    """Print the shapes of the data set and of the new tasks side by side."""
    table = Table("min, quartiles, max", "data set", "generated")
    for name in ("steps", "goals", "objects"):
        table.add_row(name, *(", ".join(map(str, shape[name])) for shape in (public, made)))
    forms = [[f"{form} {n}" for form, n in shape["forms"].items()] for shape in (public, made)]
    table.add_row("forms", *map("\n".join, forms))
    output().print(table)
