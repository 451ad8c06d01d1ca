"""Make sets of generated tasks: seeds, splits without common goals, fingerprints, files and manifests."""

from __future__ import annotations

import hashlib
import json
import statistics
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import asdict
from itertools import count, islice
from pathlib import Path
from typing import Any

import eai.logic.formula as f
from eai.base.errors import InputError
from eai.base.files import (
    make_file_lock,
    raise_write_errors_as_input_errors,
    read_content,
    write_files_atomically,
)
from eai.base.json_value import Json
from eai.benchmarks.copied_answers import SimilarTaskTable
from eai.benchmarks.generator.measures import find_goal_objects
from eai.benchmarks.generator.spec import (
    CANARY,
    SHUT_LAST,
    GeneratedTask,
    HeldOut,
    SeedRejectionReason,
    TaskSpecification,
    TaskSplit,
)
from eai.benchmarks.generator.usual_goals import LiteralPattern, find_patterns
from eai.logic.ltl_printer import format_ltl
from eai.logic.rewriting import rename_objects, standardize_variable_names
from eai.tasks.special import HazardousTaskMark
from eai.tasks.task import Task
from eai.tasks.task_files import ENDINGS, open_task_files, read_task_file_lines
from eai.tasks.task_lines import read_task_line
from eai.world.domain import Domain
from eai.world.state import Scene, State

MANIFEST = "generated.json"
"""Name of the file that describes the sets in a folder of generated tasks."""

SHARES = {TaskSplit.TRAIN: 0.6, TaskSplit.VALIDATION: 0.2, TaskSplit.TEST: 0.2}
"""Share (0 to 1) of all tasks that each split has, in the order in which splits are made."""

_ORDER = tuple(SHARES)


def make_seeds(split: str, seed: int, secret: str | None = None) -> Iterator[str]:
    """Yield seeds for the tasks of a set, without end.

    Args:
        split: name of the set.
        seed: number that the user chooses.
        secret: a secret text without which nobody can make the set. The text cannot be computed from the
            seeds. None if anybody may make the set.
    """
    for number in count():
        if secret is None:
            yield f"{split}-{seed}-{number}"
        else:
            hidden = f"{secret} {split} {seed} {number}"
            yield f"{split}-{hashlib.sha256(hidden.encode()).hexdigest()[:16]}"


def fingerprint_goals(goals: Iterable[f.Formula], scene: Scene) -> str:
    """Return a digest of goals, in which categories replace objects: renamed objects give equal digests."""
    categories = {thing.name: thing.category for thing in scene.objects}
    texts = [format_ltl(standardize_variable_names(rename_objects(goal, categories))) for goal in goals]
    return _compute_digest(sorted(texts))


def _fingerprint_facts(initial: State, names: Sequence[str], about: Set[int]) -> str:
    """Return a digest of initial facts that actions can change and that mention some of the given objects.

    Args:
        initial: the initial state.
        names: text for each object in the digest: its name or its category.
        about: indices of the objects.
    """
    static = {predicate.name for predicate in initial.scene.vocabulary.predicates if predicate.static}
    facts = [
        f"{fact.predicate} {[names[i] for i in fact.arguments]}"
        for fact in initial.facts()
        if fact.predicate not in static and not about.isdisjoint(fact.arguments)
    ]
    return _compute_digest(sorted(facts))


def fingerprint_goals_and_scene(
    goals: Sequence[f.Formula], initial: State, held_out: HeldOut = "goals"
) -> tuple[str, str]:
    """Return a digest of the goals and a digest of the scene. Tasks with equal digests count as copies.

    The digests identify objects by category. The scene's digest covers only the objects of the goals. If
    splits may share goals (`held_out` is ``starts``), the digests identify objects by name, and the scene's
    digest covers all objects.
    """
    scene = initial.scene
    if held_out == "starts":
        names = [thing.name for thing in scene.objects]
        by_name = _compute_digest(sorted([format_ltl(standardize_variable_names(goal)) for goal in goals]))
        return by_name, _fingerprint_facts(initial, names, set(range(len(names))))
    about = {index for goal in goals for index in find_goal_objects(goal, scene)}
    categories = [thing.category for thing in scene.objects]
    return fingerprint_goals(goals, scene), _fingerprint_facts(initial, categories, about)


def fingerprint_task(task: Task, held_out: HeldOut = "goals") -> tuple[str, str]:
    """Return two digests for a task: of its goals, and of initial facts (`fingerprint_goals_and_scene`)."""
    return fingerprint_goals_and_scene([goal.formula for goal in task.goals], task.initial, held_out)


def _fingerprint_goals_of_task(task: Task) -> str:
    return fingerprint_goals((goal.formula for goal in task.goals), task.scene)


def _compute_digest(texts: Iterable[str]) -> str:
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()[:16]


def choose_split(key: str) -> TaskSplit:
    """Return the split (such as training or test) that the hash of a text determines."""
    return _find_split_containing_position(_hash_to_number_from_0_to_1(key))


def _hash_to_number_from_0_to_1(key: str) -> float:
    return int.from_bytes(hashlib.sha256(key.encode()).digest()[:8], "big") / 2**64


def _find_split_containing_position(position_from_0_to_1: float) -> TaskSplit:
    """Return the split in whose interval a number from 0 to 1 lies. Intervals have the lengths `SHARES`."""
    for split, share in SHARES.items():
        position_from_0_to_1 -= share
        if position_from_0_to_1 < 0:
            return split
    return _ORDER[-1]


def choose_split_of_goals(goals: Sequence[f.Formula], initial: State, held_out: HeldOut) -> TaskSplit:
    """Return the split (such as training or test) of a task with these goals and this initial state.

    The split does not depend on names of objects, except if `held_out` is ``starts``. In that case, tasks of
    two splits may have equal goals, but not with equal initial states.
    """
    scene = initial.scene
    if held_out == "starts":
        return choose_split(f"starts {fingerprint_goals_and_scene(goals, initial, held_out)}")
    if held_out == "pairs":
        literals = [pattern for goal in goals for pattern in find_patterns(goal, scene)]
        splits = {
            choose_split(f"pair {_get_predicate_and_first_non_agent_category(pattern, scene)}")
            for pattern in literals
        }
        if splits:
            return max(splits, key=_ORDER.index)
    return choose_split(f"goals {fingerprint_goals(goals, scene)}")


def _get_predicate_and_first_non_agent_category(pattern: LiteralPattern, scene: Scene) -> tuple[str, ...]:
    """Return the predicate of a pattern, and its first category that is not the agent's, if any.

    A pattern is a literal with categories in place of objects.
    """
    agent = None if scene.agent is None else scene.objects[scene.agent].category
    return pattern.predicate, *[kind for kind in pattern.categories if kind != agent][:1]


def select_public_tasks_of_split(
    tasks: Sequence[Task], split: TaskSplit, held_out: HeldOut
) -> Sequence[Task]:
    """Return the data set's tasks from which the tasks of a split (such as the training set) are made.

    If splits must not share titles or scenes, the titles or scenes are sorted by hash and divided by the
    splits' shares. They are too few to draw a split for each at random: the splits would miss their shares.
    """
    if split is TaskSplit.ALL or held_out not in ("titles", "scenes"):
        return tasks
    keys = [task.title if held_out == "titles" else task.id for task in tasks]
    ranked = sorted(set(keys), key=lambda key: _hash_to_number_from_0_to_1(f"{held_out} {key}"))
    splits = {
        key: _find_split_containing_position((rank + 0.5) / len(ranked)) for rank, key in enumerate(ranked)
    }
    return [task for task, key in zip(tasks, keys, strict=True) if splits[key] is split]


def make_shared_plan_detector(
    domain: Domain, earlier_tasks: Iterable[Task] = (), later_tasks: Iterable[Task] = ()
) -> Callable[[Task], bool]:
    """Return a function that tells whether a task shares a plan with a task of another split (such as test).

    Splits have an order, such as training before test. A plan is shared if the plan of the most similar task
    of the earlier splits solves the task. A plan is also shared if the task's plan solves a task of a later
    split. Before a plan is tried in another task, its objects are replaced by objects of that task.

    Args:
        domain: the domain of the tasks.
        earlier_tasks: tasks of earlier splits. The model `eai/lookup` tries their plans.
        later_tasks: tasks of later splits.
    """
    table, later = SimilarTaskTable(earlier_tasks, domain), tuple(later_tasks)
    return lambda task: (
        table.solves_by_adapted_plan(task)
        or any(map(SimilarTaskTable([task], domain).solves_by_adapted_plan, later))
    )


def measure_overlap(
    tasks: Sequence[Task], known: Sequence[Task], domain: Domain, held_out: HeldOut = "goals"
) -> dict[str, int]:
    """Return counts of tasks that overlap with known tasks, such as a training set.

    - ``tasks``: number of tasks.
    - ``same``: number of tasks that equal a known task: equal goals about objects with equal initial facts.
      If `held_out` is ``starts``, the names of all objects and all initial facts must be equal, too.
    - ``same_goals``: number of tasks with the goals of a known task, if categories replace objects.
    - ``solved_by_lookup``: number of tasks solved by the plan of the known task with the most similar goals.
    """
    known_fingerprints = {fingerprint_task(task, held_out) for task in known}
    known_goals = set(map(_fingerprint_goals_of_task, known))
    table = SimilarTaskTable(known, domain)
    return {
        "tasks": len(tasks),
        "same": sum(fingerprint_task(task, held_out) in known_fingerprints for task in tasks),
        "same_goals": sum(_fingerprint_goals_of_task(task) in known_goals for task in tasks),
        "solved_by_lookup": sum(map(table.solves_by_adapted_plan, tasks)),
    }


def estimate_number_of_distinct_tasks(fingerprint_log: Iterable[tuple[str, str]]) -> int | None:
    """Return an estimate of how many different tasks seeds can give, or None if no task occurred twice.

    This is the bias-corrected estimator Chao1 of a lower bound (A. Chao, Scandinavian Journal of Statistics
    11, 1984, 265-270). It counts tasks that occurred once and twice.

    Args:
        fingerprint_log: fingerprints of tasks and of rejected duplicates.
    """
    frequencies = Counter(Counter(fingerprint_log).values())
    once, twice = frequencies[1], frequencies[2]
    if frequencies.total() == once:
        return None
    return frequencies.total() + round(once * (once - 1) / (2 * (twice + 1)))


def is_earlier_in_train_validation_test_order(split_name: str, other_split_name: str) -> bool:
    """Whether both names are names of splits (such as training and test), the earlier split first."""
    return (
        split_name in _ORDER
        and other_split_name in _ORDER
        and _ORDER.index(TaskSplit(split_name)) < _ORDER.index(TaskSplit(other_split_name))
    )


def compute_set_statistics(tasks: Sequence[Task]) -> dict[str, Any]:
    """Return minimum, quartiles and maximum of the numbers of steps, goals and objects of tasks.

    Tasks without a plan do not count for the numbers of steps. The result also counts the types of goal
    formulas, the most frequent type first.
    """
    forms = Counter(type(goal.formula).__name__ for task in tasks for goal in task.goals)
    return {
        "steps": _find_quartiles([len(task.script) for task in tasks if task.script]),
        "goals": _find_quartiles([len(task.goals) for task in tasks]),
        "objects": _find_quartiles([len(task.scene.objects) for task in tasks]),
        "forms": dict(forms.most_common()),
    }


def _find_quartiles(numbers: list[int]) -> list[int]:
    if len(numbers) < 2:
        return numbers
    return [min(numbers), *map(round, statistics.quantiles(numbers, n=4, method="inclusive")), max(numbers)]


def find_other_task_sets_of_benchmark(
    folder: Path, benchmark_name: str, *, excluded_file: Path
) -> dict[str, Path]:
    """Return the sets of tasks in a folder that use the benchmark `benchmark_name`: set name -> task file.

    Empty files and the file `excluded_file`, which the caller will write, are left out.

    Raises:
        InputError: a line of a file is not a task.
    """
    files = sorted(folder.iterdir()) if folder.is_dir() else []
    others = [file for file in files if file.name.endswith(ENDINGS) and file != excluded_file]
    opened = {file: open_task_files(file) for file in others if file.stat().st_size}
    return {task_file.name: file for file, task_file in opened.items() if task_file.base == benchmark_name}


def read_tasks_of_set(path: Path, domain: Domain) -> list[Task]:
    """Return the tasks of a task file, or of all task files in a folder.

    Raises:
        InputError: a line of a file is not a task.
    """
    return list(open_task_files(path).open_tasks(domain).values())


def make_manifest_entry(
    spec: TaskSpecification,
    seed: int,
    secret: str | None,
    content: bytes,
    made: Sequence[GeneratedTask],
    rejected: Iterable[SeedRejectionReason],
    fingerprint_log: Iterable[tuple[str, str]] = (),
) -> dict[str, Json]:
    """Return the entry of a set of tasks in the manifest: the values that are needed to make the set again.

    Only `secret`, a text without which nobody can make the set, is left out; its digest is in the entry.

    The entry also has counts of rejected seeds, statistics of the tasks, and an estimate of the number of
    different tasks (`estimate_number_of_distinct_tasks`).
    """
    reasons = Counter(rejected)
    hazardous = [
        (generated, special)
        for generated in made
        if isinstance(special := generated.task.special, HazardousTaskMark)
    ]
    hazards = Counter(name for _, special in hazardous for name in special.hazards)
    price = [
        len(generated.task.script) - len(tempting)
        for generated, _ in hazardous
        for tempting in [generated.about["temptation"]]
        if isinstance(tempting, list)
    ]
    dangers: dict[str, Json] = {}
    if price:
        dangers = {"hazards": dict(hazards.most_common()), "steps_for_safety": _find_quartiles(price)}
        dangers[SHUT_LAST] = sum(generated.about.get(SHUT_LAST) is True for generated in made)
    return {
        "spec": {
            name: value.value if hasattr(value, "value") else value for name, value in asdict(spec).items()
        },
        "spec_sha256": spec.sha256,
        "seed": seed,
        "secret_sha256": None if secret is None else hashlib.sha256(secret.encode()).hexdigest(),
        "tasks": len(made),
        "sha256": hashlib.sha256(content).hexdigest(),
        "rejected": {reason.value: reasons[reason] for reason in SeedRejectionReason if reasons[reason]},
        "estimated_tasks": estimate_number_of_distinct_tasks(fingerprint_log),
        "shape": compute_set_statistics([generated.task for generated in made]),
        **dangers,
    }


def read_manifest_entry_of_secret_set(folder: Path, split: str) -> Mapping[str, Any]:
    """Return the entry in a folder's manifest for a set of tasks whose seeds follow from a secret text.

    Raises:
        InputError: the manifest has no such set, or the set was made without a secret.
    """
    entry = _read_manifest(folder / MANIFEST).get(split)
    if not isinstance(entry, dict) or entry.get("secret_sha256") is None:
        raise InputError(f"{folder / MANIFEST}: expected a set {split!r} that was generated with --secret")
    return entry


def find_task_file_of_split(folder: Path, split: str) -> Path | None:
    """Return the file with the tasks of a set, or None if the folder has no such file."""
    return next((folder / f"{split}{end}" for end in ENDINGS if (folder / f"{split}{end}").exists()), None)


def find_reasons_to_doubt_published_set(folder: Path, split: str, secret: str | None) -> Iterator[str]:
    """Yield the reasons to doubt that a set was made with a secret whose digest was published before.

    The content of the file and the secret must have the published digests. The seeds of the tasks must follow
    from the secret. If the secret is None, only the content is checked. Nothing checks whether a seed gives
    its task: for this, the set must be made again.

    Raises:
        InputError: the manifest has no such set, or the set was made without a secret.
    """
    entry = read_manifest_entry_of_secret_set(folder, split)
    file = find_task_file_of_split(folder, split)
    if file is None:
        raise InputError(f"{folder}: expected {split}.jsonl or {split}.jsonl.gz, found neither file")
    lines = [place.content for place in read_task_file_lines(file)]
    if hashlib.sha256(b"".join([line + b"\n" for line in lines])).hexdigest() != entry["sha256"]:
        yield f"the content of {file} is not what was published"
    if secret is None:
        return
    if hashlib.sha256(secret.encode()).hexdigest() != entry["secret_sha256"]:
        yield "the digest of the secret is not the one that was published"
    tried = int(entry["tasks"]) + sum(map(int, entry["rejected"].values()))
    seeds = set(islice(make_seeds(split, int(entry["seed"]), secret), tried))
    foreign_seeds = [
        about for line in lines if (about := read_task_line(line).about.get("seed")) not in seeds
    ]
    if foreign_seeds:
        yield f"{len(foreign_seeds)} of {len(lines)} tasks are of a seed that does not follow from the secret"


def _read_manifest(file: Path, section: str = "sets") -> dict[str, Any]:
    """Return one table of a manifest: either the sets by name, or the overlap of pairs of sets.

    Raises:
        InputError: the file cannot be read, or is not a manifest.
    """
    content = read_content(file)
    try:
        manifest = json.loads(content)
        return dict(manifest["sets"] if section == "sets" else manifest.get(section, {}))
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"{file}: expected the manifest of generated tasks, a JSON object with 'sets'"
        ) from error


def add_set_to_manifest(
    folder: Path,
    split: str,
    manifest_entry: dict[str, Json],
    overlap_by_pair_of_sets: Mapping[tuple[str, str], dict[str, int]],
) -> None:
    """Add the entry of a set to the manifest, the file that describes the sets in a folder.

    `overlap_by_pair_of_sets` maps pairs (set, other set) to counts of tasks that overlap (`measure_overlap`).

    Raises:
        InputError: the existing file is not a manifest, or the manifest cannot be written.
    """
    file = folder / MANIFEST
    # other processes may add sets to this folder at the same time
    with raise_write_errors_as_input_errors(file), make_file_lock(folder / f".{MANIFEST}.lock")[1]:
        sets, known = (_read_manifest(file, part) if file.exists() else {} for part in ("sets", "overlap"))
        common: dict[str, dict[str, dict[str, int]]] = {
            name: {other: counts for other, counts in others.items() if split not in (name, other)}
            for name, others in known.items()
        }
        for (name, other), counts in overlap_by_pair_of_sets.items():
            common.setdefault(name, {})[other] = counts
        common = {name: others for name, others in common.items() if others}
        content = {"canary": CANARY, "sets": {**sets, split: manifest_entry}, "overlap": common}
        write_files_atomically({file: f"{json.dumps(content, indent=2)}\n"})
