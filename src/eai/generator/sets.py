"""Sets of generated tasks: their seeds, their files, and what is known of a set as a whole."""

from __future__ import annotations

import hashlib
import json
import statistics
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import count, islice
from pathlib import Path
from typing import Any

from eai.abilities.task import Task
from eai.abilities.verdict import Json
from eai.data.files import write_whole
from eai.errors import InputError
from eai.generator.spec import CANARY, Generated, Reason, Rejected, Spec
from eai.generator.splits import Overlap
from eai.tasks.task_files import ENDINGS, lines_in, open_task_files
from eai.tasks.task_lines import read_line
from eai.world.domain import Domain

MANIFEST = "generated.json"
"""The name of the manifest of a folder of generated tasks."""


@dataclass(frozen=True, slots=True)
class Seeds:
    """From what the tasks of a set are made, one by one.

    Attributes:
        split: the name of the set.
        seed: the user's number.
        secret: what nobody else knows, so that nobody else can make the set; None if anybody may.
    """

    split: str
    seed: int
    secret: str | None = None

    def __iter__(self) -> Iterator[str]:
        """The seeds, without end; a secret cannot be told from them."""
        for number in count():
            if self.secret is None:
                yield f"{self.split}-{self.seed}-{number}"
            else:
                told = f"{self.secret} {self.split} {self.seed} {number}"
                yield f"{self.split}-{hashlib.sha256(told.encode()).hexdigest()[:16]}"


@dataclass(frozen=True, slots=True)
class Shape:
    """The features of tasks, as the least, the quartiles and the greatest of each number.

    Attributes:
        steps: of the plans of those that have one.
        goals: per task.
        objects: per task.
        forms: how many goals have each form, the most frequent first.
    """

    steps: tuple[int, ...]
    goals: tuple[int, ...]
    objects: tuple[int, ...]
    forms: tuple[tuple[str, int], ...]

    @staticmethod
    def of(tasks: Sequence[Task]) -> Shape:
        """The shape of some tasks."""
        forms = Counter(type(goal.formula).__name__ for task in tasks for goal in task.goals)
        return Shape(
            _spread([len(task.script) for task in tasks if task.script]),
            _spread([len(task.goals) for task in tasks]),
            _spread([len(task.scene.objects) for task in tasks]),
            tuple(forms.most_common()),
        )


def _spread(numbers: Sequence[int]) -> tuple[int, ...]:
    if len(numbers) < 2:
        return tuple(numbers)
    return (min(numbers), *map(round, statistics.quantiles(numbers, n=4, method="inclusive")), max(numbers))


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
    spec: Spec, seeds: Seeds, content: bytes, made: Sequence[Generated], rejected: Iterable[Rejected]
) -> dict[str, Json]:
    """What a manifest says of a set: what it takes to make it again, but no secret, and what it is like."""
    reasons = Counter(each.reason for each in rejected)
    shape = Shape.of([each.task for each in made])
    return {
        "spec": {
            name: value.value if hasattr(value, "value") else value for name, value in asdict(spec).items()
        },
        "spec_sha256": spec.sha256,
        "seed": seeds.seed,
        "secret_sha256": None if seeds.secret is None else hashlib.sha256(seeds.secret.encode()).hexdigest(),
        "tasks": len(made),
        "sha256": hashlib.sha256(content).hexdigest(),
        "rejected": {reason.value: reasons[reason] for reason in Reason if reasons[reason]},
        "shape": {
            "steps": list(shape.steps),
            "goals": list(shape.goals),
            "objects": list(shape.objects),
            "forms": dict(shape.forms),
        },
    }


def unproven(folder: Path, split: str, secret: str) -> Iterator[str]:
    """What does not prove that a set was made with a secret whose digest its manifest published.

    The content of the file, the secret, and that the seed of every task follows from it are checked; that a
    seed gives its task is told by making the set again.

    Raises:
        InputError: there is no such set, or it was made without a secret.
    """
    entry = _manifest(folder / MANIFEST).get(split)
    if not isinstance(entry, dict) or entry.get("secret_sha256") is None:
        raise InputError(f"{folder / MANIFEST}: expected a set {split!r} that was made with a secret")
    if hashlib.sha256(secret.encode()).hexdigest() != entry["secret_sha256"]:
        yield "the digest of the secret is not the one that was published"
    file = next((folder / f"{split}{end}" for end in ENDINGS if (folder / f"{split}{end}").exists()), None)
    if file is None:
        raise InputError(f"{folder}: expected {split}.jsonl or {split}.jsonl.gz")
    lines = [place.content for place in lines_in(file)]
    if hashlib.sha256(b"".join([line + b"\n" for line in lines])).hexdigest() != entry["sha256"]:
        yield f"the content of {file} is not what was published"
    tried = int(entry["tasks"]) + sum(map(int, entry["rejected"].values()))
    seeds = set(islice(iter(Seeds(split, int(entry["seed"]), secret)), tried))
    strange = [about for line in lines if (about := read_line(line).about.get("seed")) not in seeds]
    if strange:
        yield f"{len(strange)} of {len(lines)} tasks are of a seed that does not follow from the secret"


def _manifest(file: Path, part: str = "sets") -> dict[str, Any]:
    """The sets of a manifest, or what they have in common.

    Raises:
        InputError: it cannot be read, or is none.
    """
    try:
        found = json.loads(file.read_bytes())
        return dict(found["sets"] if part == "sets" else found.get(part, {}))
    except OSError as error:
        raise InputError(f"{file}: cannot be read ({error.strerror})") from error
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"{file}: expected the manifest of generated tasks") from error


def write_manifest(
    folder: Path, split: str, entry: dict[str, Json], overlap: Mapping[tuple[str, str], Overlap]
) -> None:
    """Enter a set into the manifest of a folder, and what sets have in common with others: (set, other).

    Raises:
        InputError: there is a file of that name that is no manifest, or it cannot be written.
    """
    file = folder / MANIFEST
    sets, told = (_manifest(file, part) if file.exists() else {} for part in ("sets", "overlap"))
    common: dict[str, dict[str, Json]] = {
        name: {other: found for other, found in others.items() if split not in (name, other)}
        for name, others in told.items()
    }
    for (name, other), found in overlap.items():
        common.setdefault(name, {})[other] = asdict(found)
    common = {name: others for name, others in common.items() if others}
    content = {"canary": CANARY, "sets": {**sets, split: entry}, "overlap": common}
    write_whole({file: f"{json.dumps(content, indent=2)}\n"})
