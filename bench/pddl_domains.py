"""Domains in PDDL as people have them: which open, whether all is told, whether VAL agrees on their plans.

``bench/pddl_domains.py FOLDER...``: of every domain below the folders that no other equals the smallest
problem is taken that is one of it. A plan is searched for, and 20 seeded mutants of it made: VAL reads the
files, the plan and each mutant, and has to say what our scorer says. Exits with status 1 where they differ.
"""

from __future__ import annotations

import random
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from eai.abilities.planning import find_plan
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict
from eai.abilities.wording import is_property
from eai.benchmark.prompt_library import Library
from eai.benchmark.registry import find_benchmark
from eai.benchmark.suite import Suite, open_suite
from eai.errors import InputError
from eai.pddl.files import domain_in, read_text
from eai.pddl.val import VALID, installed_val, verdict_in
from eai.planning.planner import Planner
from eai.planning.search import Limits
from eai.tasks.source import Source

LIMITS = Limits(300, looks=30_000)
MUTANTS = 20
LARGEST = 100_000
"""The longest file of a problem that is looked at, in characters."""
NAME = {"domain": r"\(\s*domain\s+([^\s()]+)", "problem": r"\(\s*:domain\s+([^\s()]+)"}


def named(file: Path, kind: str) -> str | None:
    found = re.search(NAME[kind], re.sub(r";[^\n]*", "", file.read_text(errors="replace")).lower())
    return None if found is None else found[1]


def domains(folders: list[Path]) -> Iterator[tuple[Path, list[Path]]]:
    """Each domain, and its problems: those near it and small ones first."""
    files = [file for folder in folders for file in sorted(folder.rglob("*.pddl"))]
    seen: set[str] = set()
    problems: dict[str, list[Path]] = {}
    for file in files:
        if file.stat().st_size < LARGEST and (name := named(file, "problem")) is not None:
            problems.setdefault(name, []).append(file)
    for file in files:
        name = named(file, "domain")
        text = " ".join(re.sub(r";[^\n]*", "", file.read_text(errors="replace")).lower().split())
        if name is not None and text not in seen:
            seen.add(text)
            near = sorted(
                problems.get(name, []), key=lambda other: (_apart(file, other), other.stat().st_size)
            )
            yield file, near[:4]


def _apart(one: Path, other: Path) -> tuple[int, bool]:
    shared = sum(a == b for a, b in zip(one.parts, other.parts, strict=False))
    return -shared, one.stem.removeprefix("domain_") not in str(other)


def mutants(lines: list[str], words: list[str], rng: random.Random) -> Iterator[list[str]]:
    """Plans with one step left out, said twice, exchanged with the next, or about another object."""
    for _ in range(MUTANTS):
        place, changed = rng.randrange(len(lines)), list(lines)
        match rng.choice(("drop", "twice", "swap", "object", "object")):
            case "drop":
                del changed[place]
            case "twice":
                changed.insert(place, changed[place])
            case "swap":
                changed[place : place + 2] = reversed(changed[place : place + 2])
            case _:
                step = changed[place].strip("()").split()
                if len(step) > 1:
                    step[rng.randrange(1, len(step))] = rng.choice(words)
                changed[place] = f"({' '.join(step)})"
        yield changed


def val_accepts(domain: Path, problem: Path, lines: list[str]) -> bool | None:
    """Whether VAL calls a plan valid; None where it cannot read the files or gives no answer."""
    with TemporaryDirectory() as folder:
        plan = Path(folder) / "plan"
        plan.write_text("\n".join(lines) + "\n")
        try:
            words = [str(installed_val()), str(domain), str(problem), str(plan)]
            done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=False)
        except subprocess.TimeoutExpired:
            return None
    said = verdict_in(done.stdout + done.stderr)
    return None if said is None else said == VALID


def untold(suite: Suite, task_id: str) -> int:
    """How many facts that are no property stand in no prompt."""
    task = suite.tasks[task_id]
    prompt = Library("official", None, Source()).open(suite.benchmark, suite.ability)[task_id].user
    vocabulary = suite.benchmark.domain.vocabulary
    names = [each.name for each in task.scene.objects]
    facts = [fact for fact in task.initial.facts() if not is_property(vocabulary.stored(fact.predicate))]
    return sum(
        f"{each.predicate}({', '.join(names[i] for i in each.arguments)})" not in prompt for each in facts
    )


def tried(domain: Path, problems: list[Path]) -> tuple[str, str]:
    """What came of a domain: a word, and details."""
    try:
        domain_in(read_text(domain), domain)
    except InputError as error:
        return "refused", str(error)
    reason = "none is beside it"
    for problem in problems:
        try:
            suite = open_suite(find_benchmark(f"pddl:{domain},{problem}"), Ability.ACTION_SEQUENCING)
            task_id, task = next(iter(suite.tasks.items()))
        except InputError as error:
            reason = str(error)
            continue
        missing = untold(suite, task_id)
        found = find_plan(task, Planner(suite.benchmark.domain), LIMITS)
        names = [each.name for each in task.scene.objects]
        lines = [f"({' '.join([each.operator, *(names[i] for i in each.arguments)])})" for each in found.plan]
        if missing:
            return "untold", f"{missing} facts of {problem}"
        if not lines:
            return "no plan found", str(problem)
        rng = random.Random(7)  # noqa: S311 - which mutants they are
        for plan in (lines, *mutants(lines, names, rng)):
            if not plan:
                continue
            verdict = suite.scorer(task_id).score("\n".join(plan))
            ours = isinstance(verdict, PlanVerdict) and bool(verdict.success)
            theirs = val_accepts(domain, problem, plan)
            if theirs is None:
                return "VAL gives no answer", str(problem)
            if ours is not theirs:
                return "VAL differs", f"{problem}: {plan}: ours {ours}, VAL {theirs}"
        return "VAL agrees", f"{len(lines)} steps"
    return "no problem", reason


def main() -> None:
    counts = Counter[str]()
    for domain, problems in domains([Path(each) for each in sys.argv[1:]]):
        word, details = tried(domain, problems)
        counts[word] += 1
        print(f"{word}: {domain}: {details}", flush=True)
    print(", ".join(f"{number} {word}" for word, number in counts.most_common()))
    raise SystemExit(bool(counts["VAL differs"] or counts["untold"]))


if __name__ == "__main__":
    main()
