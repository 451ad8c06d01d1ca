"""Compare the verdicts of the reference package and of `eai-1.0.5` on mutated answers, field by field.

    python -m bench compare_with_reference    1,000 answers to each of the eight suites
    python -m bench compare_with_reference --suite behavior/ --rows 200 --seed 7

The answers are gold answers with random changes, from a misplaced step to a broken bracket; equal seeds give
equal answers. Both packages judge each answer separately. The exit status is 1 if a field differs.

Some answers are not compared, but counted by exception:

- Answers that end the whole run of the reference package, which gives no verdict. In goal interpretation
  `eai-1.0.5` reports that the run would end, and this is compared.
- Subgoals that the reference package tries for more than a minute (`overlong`).
- `UnboundLocalError`: the stand-ins for the simulator have no object left on, under or next to another. No
  real scene is like that.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import tempfile
from collections import Counter
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from bench.record import add_write_option, get_suite_title, write_rows
from bench.result import Figure
from differential.behavior_scenes import ALSO_IMPORTED, described
from differential.mutated_answers import maker
from differential.mutations import Dice
from differential.reference import CACHE, REFERENCE, environment
from differential.verdict_fields import examples, fields
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.protocol import PAPER_ABILITIES, Ability, Protocol
from eai.abilities.verdict import Verdict
from eai.benchmarks.behavior.tasks import open_tasks, read_initial_relations
from eai.benchmarks.suite import Suite, open_suite
from eai.extensions.reference.protocol import open_scored_virtualhome_tasks
from eai.pddl.planning import PlannerChoice
from eai.tasks.source import Source

CHILD = Path(__file__).with_name("compare_with_reference_child.py")
SUITES = tuple(
    f"{domain}/{ability.value}" for domain in ("virtualhome", "behavior") for ability in PAPER_ABILITIES
)
NEEDED = ("scipy", *ALSO_IMPORTED)


class Row(NamedTuple):
    """An answer to a task."""

    task_id: str
    text: str


class Pair(NamedTuple):
    """Values of a field: the reference package's and ours."""

    reference: object
    ours: object


@dataclass(frozen=True, slots=True)
class Difference:
    """A row, and the fields in which its verdicts differ."""

    row: Row
    fields: Mapping[str, Pair]


def made_rows(suite: str, count: int, seed: int) -> list[Row]:
    """Return mutated answers to tasks of a suite that the reference package scores."""
    make, scored, dice = maker(*parts(suite)), scorers(suite), Dice(f"{suite} {seed}")
    known = [i for i in scored.task_ids if getattr(scored.scorer(i), "excluded", None) is None]
    chosen = [dice.one(known) for _ in range(count)]
    return [Row(task_id, make(Dice(f"{suite} {seed} {n}"), task_id)) for n, task_id in enumerate(chosen)]


def parts(suite: str) -> tuple[str, Ability]:
    """Return the domain and the ability of a suite."""
    domain, _, ability = suite.partition("/")
    return domain, Ability(ability)


def scorers(suite: str) -> Suite:
    """Return our scorers of a suite. VirtualHome plans need ids everywhere, as release 1.0.5 expects."""
    domain, ability = parts(suite)
    opener = (
        partial(open_scored_virtualhome_tasks, with_ids=True)
        if suite == "virtualhome/action_sequencing"
        else None
    )
    source = Source(planner=PlannerChoice.NONE)
    return open_suite(domain, ability, Protocol("eai-1.0.5"), source=source, opener=opener)


def judged_by_reference(suite: str, rows: Sequence[Row], python: Path, workers: int) -> list[dict[str, Any]]:
    """Return the reference package's verdicts in order, computed by several processes."""
    domain, ability = parts(suite)
    scenes = scenes_for(ability, {row.task_id for row in rows}) if domain == "behavior" else {}
    shares = [rows[start::workers] for start in range(workers)]

    def judge(share: Sequence[Row]) -> list[dict[str, Any]]:
        with tempfile.TemporaryDirectory(prefix="eai-bench-") as folder:
            path = Path(folder) / "rows.json"
            path.write_text(json.dumps({"rows": share, "scenes": scenes}), encoding="utf-8")
            done = subprocess.run(
                [str(python), "-W", "ignore", str(CHILD), domain, ability.value, str(path)],
                check=True,
                stdout=subprocess.PIPE,
                text=True,
                cwd=folder,
                env=os.environ | {"PYTHONHASHSEED": "0", "PYTHONDONTWRITEBYTECODE": "1"},
            )
        return [json.loads(line) for line in done.stdout.splitlines()]

    with ThreadPoolExecutor(workers) as pool:
        found = list(pool.map(judge, shares))
    return [found[number % workers][number // workers] for number in range(len(rows))]


def scenes_for(ability: Ability, task_ids: set[str]) -> dict[str, Any]:
    """Return the scenes that replace BEHAVIOR's simulator: those on which `eai-1.0.5` judges the ability."""
    if ability not in (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION):
        return {}
    tasks = open_tasks()
    found = {}
    for task_id in sorted(task_ids):
        task = tasks[task_id]
        as_listed = ability is Ability.SUBGOAL_DECOMPOSITION and task.initial_as_published != task.initial
        found[task_id] = described(task, read_initial_relations(task.record) if as_listed else None)
    return found


def examine(suite: str, rows: Sequence[Row], python: Path, workers: int, show: int) -> tuple[int, int]:
    """Judge the rows with both packages, print differences, and count the compared and the different rows."""
    scored = scorers(suite)
    apart: Counter[str] = Counter()
    reached: Counter[str] = Counter()
    found: list[Difference] = []
    for row, theirs in zip(rows, judged_by_reference(suite, rows, python, workers), strict=True):
        ours = scored.score(row.task_id, row.text)
        reached.update(examples(ours))
        compared = differing(theirs, ours)
        if isinstance(compared, str):
            apart[compared] += 1
        elif compared:
            found.append(Difference(row, compared))
    set_apart = "".join(f", {count} {name}" for name, count in sorted(apart.items()))
    print(f"{suite:34} {len(rows):6,} rows, {len(found):4} differences{set_apart}", flush=True)
    print(f"    {', '.join(f'{name} {count}' for name, count in reached.most_common())}")
    for difference in found[:show]:
        print(f"    {difference.row.task_id}: {difference.row.text!r}")
        for name, (reference, mine) in difference.fields.items():
            print(f"        {name}: {reference} in the reference, {mine} here")
    return len(rows) - apart.total(), len(found)


def differing(theirs: Mapping[str, Any], ours: Verdict) -> Mapping[str, Pair] | str:
    """Return the fields in which two verdicts differ, or the reason why they cannot be compared."""
    if "overlong" in theirs:
        return "overlong"
    if "crash" in theirs and not isinstance(ours, GoalVerdict):
        return str(theirs["crash"]).partition(":")[0]
    mine = fields(ours)
    told = {"ends the run": True} if "crash" in theirs else theirs
    pairs = {name: Pair(value, mine.get(name)) for name, value in told.items()}
    return {name: pair for name, pair in pairs.items() if pair.reference != pair.ours}


def main() -> int:
    """Compare both packages on every suite and print the results."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--suite", default="", help="a part of DOMAIN/ABILITY")
    parser.add_argument("--rows", type=int, default=1_000, help="how many answers to each suite")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--show", type=int, default=5, help="how many differences of a suite are printed")
    parser.add_argument("--workers", type=int, default=1, help="processes of the reference")
    parser.add_argument("--cache", type=Path, default=CACHE, help="where the reference's environment is kept")
    add_write_option(parser)
    arguments = parser.parse_args()
    python = prepared(arguments.cache)
    print(f"mutated answers, {REFERENCE}, seed {arguments.seed}")
    counts = {}
    for suite in SUITES:
        if arguments.suite in suite:
            rows = made_rows(suite, arguments.rows, arguments.seed)
            counts[suite] = examine(suite, rows, python, arguments.workers, arguments.show)
    if arguments.write:
        table: list[list[Figure]] = [
            [get_suite_title(*suite.split("/")), *numbers] for suite, numbers in counts.items()
        ]
        write_rows("compare_with_reference", table)
    return int(any(different for _, different in counts.values()))


def prepared(cache: Path) -> Path:
    """Return the Python of the reference package's environment, with all imports of the evaluations."""
    python = environment(cache)
    probe = subprocess.run(
        [str(python), "-c", "import scipy, networkx, yaml"], check=False, capture_output=True
    )
    if probe.returncode:
        subprocess.run([str(python), "-m", "pip", "install", "--quiet", *NEEDED], check=True)
    return python
