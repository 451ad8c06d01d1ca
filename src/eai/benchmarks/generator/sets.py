"""Sets of generated tasks: seeds, splits that share no goals, fingerprints, files and the manifest."""

from __future__ import annotations

import hashlib
import json
import statistics
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from itertools import count, islice
from pathlib import Path
from typing import Any

import eai.logic.formula as f
from eai.base.errors import InputError
from eai.base.files import read_content, write_whole
from eai.base.json_value import Json
from eai.benchmarks.copied_answers import LookupTable
from eai.benchmarks.generator.measures import spoken_of
from eai.benchmarks.generator.prior import Pattern, patterns_of
from eai.benchmarks.generator.spec import CANARY, SHUT_LAST, Generated, HeldOut, Reason, Spec, Split
from eai.logic.ltl_printer import print_ltl
from eai.logic.rewriting import rename_objects, rename_variables
from eai.tasks.special import Hazards
from eai.tasks.task import Task
from eai.tasks.task_files import ENDINGS, lines_in, open_task_files
from eai.tasks.task_lines import read_line
from eai.world.domain import Domain
from eai.world.state import Scene, State

MANIFEST = "generated.json"
"""The name of the manifest of a folder of generated tasks."""

SHARES = {Split.TRAIN: 0.6, Split.VALIDATION: 0.2, Split.TEST: 0.2}
"""The share of what is held out that falls to each split, in the order in which the splits are made."""

_ORDER = tuple(SHARES)


def seeds_of(split: str, seed: int, secret: str | None = None) -> Iterator[str]:
    """The seeds from which the tasks of a set are made, one by one and without end.

    Args:
        split: the name of the set.
        seed: the user's number.
        secret: what nobody else knows, so that nobody else can make the set; it cannot be read from the
            seeds. None if anybody may.
    """
    for number in count():
        if secret is None:
            yield f"{split}-{seed}-{number}"
        else:
            hidden = f"{secret} {split} {seed} {number}"
            yield f"{split}-{hashlib.sha256(hidden.encode()).hexdigest()[:16]}"


def goals_fingerprint(goals: Iterable[f.Formula], scene: Scene) -> str:
    """The fingerprint of goals: equal if they ask for the same of objects of the same categories."""
    categories = {thing.name: thing.category for thing in scene.objects}
    texts = [print_ltl(rename_variables(rename_objects(goal, categories))) for goal in goals]
    return _digest(sorted(texts))


def _scene_fingerprint(initial: State, goals: Iterable[f.Formula]) -> str:
    """The fingerprint of what can change and holds at the start of what the goals speak of."""
    scene, vocabulary = initial.scene, initial.scene.vocabulary
    named = {index for goal in goals for index in spoken_of(goal, scene)}
    static = {predicate.name for predicate in vocabulary.predicates if predicate.static}
    facts = [
        f"{fact.predicate} {[scene.objects[i].category for i in fact.arguments]}"
        for fact in initial.facts()
        if fact.predicate not in static and named.intersection(fact.arguments)
    ]
    return _digest(sorted(facts))


def fingerprint(goals: Sequence[f.Formula], initial: State) -> tuple[str, str]:
    """The fingerprints of goals, and of the scene in which they are to be reached, which tell tasks apart."""
    return goals_fingerprint(goals, initial.scene), _scene_fingerprint(initial, goals)


def fingerprint_of(task: Task) -> tuple[str, str]:
    """Both fingerprints of a task: of its goals, and of its scene."""
    return fingerprint([goal.formula for goal in task.goals], task.initial)


def _digest(texts: Iterable[str]) -> str:
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()[:16]


def split_of(key: str) -> Split:
    """The split that a hash gives a text."""
    return _split_at(_hash(key))


def _hash(key: str) -> float:
    return int.from_bytes(hashlib.sha256(key.encode()).digest()[:8], "big") / 2**64


def _split_at(place: float) -> Split:
    """The split at a place between 0 and 1, of which each has its share."""
    for split, share in SHARES.items():
        place -= share
        if place < 0:
            return split
    return _ORDER[-1]


def split_of_goals(goals: Sequence[f.Formula], scene: Scene, held_out: HeldOut) -> Split:
    """The split to which a task with these goals belongs, whatever their objects are called."""
    if held_out == "pairs":
        literals = [pattern for goal in goals for pattern in patterns_of(goal, scene)]
        splits = {split_of(f"pair {_pair(pattern, scene)}") for pattern in literals}
        if splits:
            return max(splits, key=_ORDER.index)
    return split_of(f"goals {goals_fingerprint(goals, scene)}")


def _pair(pattern: Pattern, scene: Scene) -> tuple[str, ...]:
    """The predicate, and the first kind of thing that is not the agent's."""
    agent = None if scene.agent is None else scene.objects[scene.agent].category
    return pattern.predicate, *[kind for kind in pattern.categories if kind != agent][:1]


def bases_of(tasks: Sequence[Task], split: Split, held_out: HeldOut) -> Sequence[Task]:
    """The public tasks from which those of a split are made.

    Titles and scenes are few, so that splits get their share of them, in the order of their hashes.
    """
    if split is Split.ALL or held_out not in ("titles", "scenes"):
        return tasks
    keys = [task.title if held_out == "titles" else task.id for task in tasks]
    ranked = sorted(set(keys), key=lambda key: _hash(f"{held_out} {key}"))
    splits = {key: _split_at((rank + 0.5) / len(ranked)) for rank, key in enumerate(ranked)}
    return [task for task, key in zip(tasks, keys, strict=True) if splits[key] is split]


def giving_away(
    domain: Domain, known: Iterable[Task] = (), held_out: Iterable[Task] = ()
) -> Callable[[Task], bool]:
    """Whether a task is solved by looking up one of another split, or would be what one is solved by.

    Args:
        domain: whose world they are in.
        known: the tasks of earlier splits: no plan that `eai/lookup` finds among them is to solve a task.
        held_out: the tasks of later splits: none of them is to be solved by the plan of a task.
    """
    table, later = LookupTable(known, domain), tuple(held_out)
    return lambda task: table.solves(task) or any(map(LookupTable([task], domain).solves, later))


def overlap_of(tasks: Sequence[Task], known: Sequence[Task], domain: Domain) -> dict[str, int]:
    """The overlap of tasks with others that are known, say those of a training set.

    ``tasks``: how many there are. ``same``: those that are the same as a known one, with equal goals of
    things that start alike. ``same_goals``: those with the goals of a known one, objects known by kind.
    ``solved_by_lookup``: those that are solved by the plan of the known task with the most similar goals.
    """
    prints = set(map(fingerprint_of, known))
    known_goals = {goals for goals, _ in prints}
    table = LookupTable(known, domain)
    found = list(map(fingerprint_of, tasks))
    return {
        "tasks": len(tasks),
        "same": sum(each in prints for each in found),
        "same_goals": sum(goals in known_goals for goals, _ in found),
        "solved_by_lookup": sum(map(table.solves, tasks)),
    }


def is_before(one: str, other: str) -> bool:
    """Whether one name is that of a split, and the other that of a later one."""
    return one in _ORDER and other in _ORDER and _ORDER.index(Split(one)) < _ORDER.index(Split(other))


def shape_of(tasks: Sequence[Task]) -> dict[str, Any]:
    """The least, the quartiles and the greatest of steps of plans, goals and objects, and the forms of goals.

    Tasks without a plan have no steps; the most frequent form is first.
    """
    forms = Counter(type(goal.formula).__name__ for task in tasks for goal in task.goals)
    return {
        "steps": _spread([len(task.script) for task in tasks if task.script]),
        "goals": _spread([len(task.goals) for task in tasks]),
        "objects": _spread([len(task.scene.objects) for task in tasks]),
        "forms": dict(forms.most_common()),
    }


def _spread(numbers: list[int]) -> list[int]:
    if len(numbers) < 2:
        return numbers
    return [min(numbers), *map(round, statistics.quantiles(numbers, n=4, method="inclusive")), max(numbers)]


def sets_in(folder: Path, base: str, domain: Domain, *, without: Path) -> dict[str, Sequence[Task]]:
    """The tasks of a world that a folder holds in other files than one, by name of the file.

    Raises:
        InputError: a line of them is no task.
    """
    files = sorted(folder.iterdir()) if folder.is_dir() else []
    others = [file for file in files if file.name.endswith(ENDINGS) and file != without]
    read = [open_task_files(file) for file in others if file.stat().st_size]
    return {each.name: list(each.tasks(domain).values()) for each in read if each.base == base}


def manifest_entry(
    spec: Spec,
    seed: int,
    secret: str | None,
    content: bytes,
    made: Sequence[Generated],
    rejected: Iterable[Reason],
) -> dict[str, Json]:
    """The entry of a manifest: all it takes to make it again, but no secret, and the shape of its tasks."""
    reasons = Counter(rejected)
    hazardous = [(each, special) for each in made if isinstance(special := each.task.special, Hazards)]
    hazards = Counter(name for _, special in hazardous for name in special.hazards)
    price = [
        len(each.task.script) - len(tempting)
        for each, _ in hazardous
        for tempting in [each.about["temptation"]]
        if isinstance(tempting, list)
    ]
    dangers: dict[str, Json] = {}
    if price:
        dangers = {"hazards": dict(hazards.most_common()), "steps_for_safety": _spread(price)}
        dangers[SHUT_LAST] = sum(each.about.get(SHUT_LAST) is True for each in made)
    return {
        "spec": {
            name: value.value if hasattr(value, "value") else value for name, value in asdict(spec).items()
        },
        "spec_sha256": spec.sha256,
        "seed": seed,
        "secret_sha256": None if secret is None else hashlib.sha256(secret.encode()).hexdigest(),
        "tasks": len(made),
        "sha256": hashlib.sha256(content).hexdigest(),
        "rejected": {reason.value: reasons[reason] for reason in Reason if reasons[reason]},
        "shape": shape_of([each.task for each in made]),
        **dangers,
    }


def set_of(folder: Path, split: str) -> Mapping[str, Any]:
    """The entry in a manifest of a set that was made with a secret.

    Raises:
        InputError: there is no such set, or it was made without a secret.
    """
    entry = _manifest(folder / MANIFEST).get(split)
    if not isinstance(entry, dict) or entry.get("secret_sha256") is None:
        raise InputError(f"{folder / MANIFEST}: expected a set {split!r} that was made with a secret")
    return entry


def file_of_set(folder: Path, split: str) -> Path | None:
    """The file with the tasks of a set, or None where it is not in its folder."""
    return next((folder / f"{split}{end}" for end in ENDINGS if (folder / f"{split}{end}").exists()), None)


def unproven(folder: Path, split: str, secret: str | None) -> Iterator[str]:
    """Reasons against the claim that a set was made with a secret whose digest its manifest published.

    The content of the file, the secret, and that the seed of every task follows from it are checked; that a
    seed gives its task shows when the set is made again. Where the secret is None, its content alone is.

    Raises:
        InputError: there is no such set, or it was made without a secret.
    """
    entry = set_of(folder, split)
    file = file_of_set(folder, split)
    if file is None:
        raise InputError(f"{folder}: expected {split}.jsonl or {split}.jsonl.gz")
    lines = [place.content for place in lines_in(file)]
    if hashlib.sha256(b"".join([line + b"\n" for line in lines])).hexdigest() != entry["sha256"]:
        yield f"the content of {file} is not what was published"
    if secret is None:
        return
    if hashlib.sha256(secret.encode()).hexdigest() != entry["secret_sha256"]:
        yield "the digest of the secret is not the one that was published"
    tried = int(entry["tasks"]) + sum(map(int, entry["rejected"].values()))
    seeds = set(islice(seeds_of(split, int(entry["seed"]), secret), tried))
    strange = [about for line in lines if (about := read_line(line).about.get("seed")) not in seeds]
    if strange:
        yield f"{len(strange)} of {len(lines)} tasks are of a seed that does not follow from the secret"


def _manifest(file: Path, part: str = "sets") -> dict[str, Any]:
    """The sets of a manifest, or what they have in common.

    Raises:
        InputError: it cannot be read, or is none.
    """
    content = read_content(file)
    try:
        found = json.loads(content)
        return dict(found["sets"] if part == "sets" else found.get(part, {}))
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"{file}: expected the manifest of generated tasks") from error


def write_manifest(
    folder: Path, split: str, entry: dict[str, Json], overlap: Mapping[tuple[str, str], dict[str, int]]
) -> None:
    """Enter a set into the manifest of a folder, and what sets have in common with others: (set, other).

    Raises:
        InputError: there is a file of that name that is no manifest, or it cannot be written.
    """
    file = folder / MANIFEST
    sets, known = (_manifest(file, part) if file.exists() else {} for part in ("sets", "overlap"))
    common: dict[str, dict[str, dict[str, int]]] = {
        name: {other: found for other, found in others.items() if split not in (name, other)}
        for name, others in known.items()
    }
    for (name, other), found in overlap.items():
        common.setdefault(name, {})[other] = found
    common = {name: others for name, others in common.items() if others}
    content = {"canary": CANARY, "sets": {**sets, split: entry}, "overlap": common}
    write_whole({file: f"{json.dumps(content, indent=2)}\n"})
