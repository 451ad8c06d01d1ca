"""BEHAVIOR: our speed as a ratio to the reference's symbolic evaluation, on the same answers in one run.

`python bench/behavior.py`. The reference needs a simulator even to score text; here objects that say what our
records say stand in its place, so that only its symbolic part is measured. The answers are the data set's own
plans, and the same plans told as subgoals; `--plans FILE...` and `--subgoals FILE...` take real ones instead.
Only processor time counts, scoring alone on both sides, the median of several runs of each; the reference's
subgoals, which take it long, are run once. Loading our data has a limit of its own. Exits with status 1 when
a limit is missed.
"""

from __future__ import annotations

import argparse
import gc
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import islice
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

from eai.abilities.notation.plans import JsonPlans
from eai.abilities.scorer import Scorer
from eai.abilities.verdict import PlanVerdict, Verdict
from eai.data.dataset import fetch
from eai.households.behavior.evidence import GroundRelation, load_evidence
from eai.households.behavior.tasks import BehaviorTask, initial_relations, initial_states, open_tasks
from eai.households.packs import published_packs
from eai.logic.formula import Atom, Formula, Not
from eai.logic.traversal import walk
from eai.reference.behavior_plans import BehaviorActionSequencing
from eai.reference.behavior_quirks import truncated_options
from eai.reference.behavior_subgoals import BehaviorSubgoalDecomposition
from eai.world.execution import Action
from eai.world.state import Scene
from reference import CACHE, REFERENCE, environment, read_responses

CHILD = Path(__file__).with_name("behavior_reference_child.py")
ALSO_IMPORTED = ("networkx", "pyyaml")
RATIOS = {"action_sequencing": 30.0, "subgoal_decomposition": 500.0}
LOAD_CPU_SECONDS = 0.3
SUBGOALS = {
    "GRASP": "holds_{hand}h({x})",
    "PLACE_ONTOP": "ontop({held}, {x})",
    "PLACE_INSIDE": "inside({held}, {x})",
    "PLACE_NEXTTO": "nextto({held}, {x})",
    "PLACE_UNDER": "under({held}, {x})",
    "OPEN": "open({x})",
    "CLOSE": "not open({x})",
    "TOGGLE_ON": "toggledon({x})",
    "TOGGLE_OFF": "not toggledon({x})",
    "SOAK": "soaked({x})",
    "COOK": "cooked({x})",
    "SLICE": "sliced({x})",
    "CLEAN": "not dusty({x})",
}


class Answer(NamedTuple):
    """An answer to a task."""

    task_id: str
    text: str


def made_plan(task: BehaviorTask) -> str:
    """The data set's plan as text."""
    notation = JsonPlans()
    return notation.join(notation.write(task.script, task.scene))


def made_subgoals(task: BehaviorTask) -> str:
    """The data set's plan told as subgoals."""
    return json.dumps({"output": list(subgoals(task.script, task.scene))})


def answers(
    tasks: Mapping[str, BehaviorTask], files: Sequence[Path], make: Callable[[BehaviorTask], str]
) -> list[Answer]:
    """The answers of response files, or where there are none the made ones."""
    if not files:
        return [Answer(task_id, make(task)) for task_id, task in tasks.items()]
    found = [response for path in files for response in read_responses(path)]
    return [Answer(each.task_id, each.text) for each in found if each.task_id in tasks]


def subgoals(script: Sequence[Action], scene: Scene) -> Iterator[str]:
    """What each action of a plan brings about; parts of objects have no name."""
    held: dict[str, str] = {}
    for action in script:
        hand, _, name = action.operator.partition("_")
        name = name if hand in ("LEFT", "RIGHT") else action.operator
        x = scene.objects[action.arguments[-1]].name
        if "_part_" in x or name not in SUBGOALS:
            continue
        dotted = ".".join(x.rsplit("_", 1))
        if name == "GRASP":
            held[hand] = dotted
        if "{held}" in SUBGOALS[name] and hand not in held:
            continue
        yield SUBGOALS[name].format(x=dotted, hand=hand[0].lower(), held=held.get(hand))


def described(task: BehaviorTask, relations: Sequence[GroundRelation] | None = None) -> dict[str, Any]:
    """What the reference's stand-in for the simulator is told of a task, or of one with other relations."""
    record, evidence = task.record, load_evidence()
    relations = initial_relations(record, evidence) if relations is None else relations
    true = set(initial_states(record, evidence))
    instances = {thing.name: thing.instance for thing in record.objects}
    objects = []
    for thing in record.objects:
        marks = [
            m for m, a in (("Slicer", "slicer"), ("CleaningTool", "cleaningTool")) if a in thing.abilities
        ]
        states = {spelt(state): (state, thing.name) in true for state in thing.states} | dict.fromkeys(
            marks, True
        )
        mine = [(predicate, target) for predicate, source, target in relations if source == thing.name]
        volume = evidence.volumes.of(record.scene, thing.name, thing.model)
        for name in (thing.name, *thing.parts):
            part = name != thing.name
            related = (
                {}
                if part
                else {each: [target for predicate, target in mine if predicate == each] for each, _ in mine}
            )
            size = volume * evidence.volumes.part if part else volume
            objects.append(
                {
                    "name": name,
                    "floor": thing.is_floor,
                    "volume": size,
                    "states": states,
                    "relations": related,
                }
            )
    goals = [
        {
            "terms": [part.predicate for part in walk(goal.formula) if hasattr(part, "predicate")],
            "options": [
                [listed(literal, instances) for literal in option]
                for option in truncated_options(goal.formula, task.scene.named)
            ],
        }
        for goal in task.goals
    ]
    return {
        "activity": record.activity,
        "objects": objects,
        "scope": [[thing.instance, [thing.name, *thing.parts]] for thing in record.objects],
        "initial": [
            *map(words, record.problem.initial),
            *(["not", *words(fact)] for fact in record.problem.denied),
        ],
        "goals": goals,
    }


def words(fact: Atom) -> list[str]:
    """The words of an initial fact, as bddl gives its terms."""
    return [fact.predicate, *(term.name for term in fact.arguments)]


def spelt(state: str) -> str:
    """A state as the simulator names its class."""
    return "".join(word.capitalize() for word in state.split("_"))


def listed(literal: Formula, instances: dict[str, str]) -> list[Any]:
    """A literal as bddl writes ground options."""
    if isinstance(literal, Not):
        return ["not", listed(literal.operand, instances)]
    return [literal.predicate, *(instances[term.name] for term in literal.arguments)]  # type: ignore[union-attr]


def run_reference(python: Path, given: dict[str, Any]) -> dict[str, Any]:
    """Let the reference evaluate all answers in a process of its own."""
    probe = [str(python), "-c", "import networkx, yaml"]
    if subprocess.run(probe, check=False, capture_output=True).returncode:
        subprocess.run([str(python), "-m", "pip", "install", "--quiet", *ALSO_IMPORTED], check=True)
    with tempfile.TemporaryDirectory(prefix="eai-bench-") as folder:
        path = Path(folder) / "answers.json"
        path.write_text(json.dumps(given), encoding="utf-8")
        child = subprocess.run(
            [str(python), "-W", "ignore", str(CHILD), str(path)],
            check=True,
            stdout=subprocess.PIPE,
            text=True,
        )
    report: dict[str, Any] = json.loads(child.stdout.splitlines()[-1])
    return report


@dataclass(frozen=True, slots=True)
class Ours:
    """Our scorers of the answers to an ability.

    Attributes:
        calls: for each answer its scoring.
        seconds: processor time to score all answers once, of each run so far.
    """

    calls: tuple[Callable[[], Verdict], ...]
    seconds: list[float] = field(default_factory=list)

    def run(self, repeats: int) -> None:
        """Score all answers some times."""
        for _ in range(repeats):
            started = time.process_time()
            for each in self.calls:
                each()
            self.seconds.append(time.process_time() - started)


def scoring(
    make: Callable[[BehaviorTask], Scorer], tasks: Mapping[str, BehaviorTask], given: Sequence[Answer]
) -> Ours:
    """What scores the answers, one scorer a task."""
    scorers = {task_id: make(tasks[task_id]) for task_id in {each.task_id for each in given}}
    return Ours(tuple(partial(scorers[each.task_id].score, each.text) for each in given))


def loading() -> float:
    """Seconds of processor time to load all records and make all tasks."""
    started = time.process_time()
    dict(open_tasks())
    return time.process_time() - started


def _succeeds(verdict: Verdict) -> bool:
    return isinstance(verdict, PlanVerdict) and bool(verdict.success)


def report(ability: str, ours: Ours, theirs: dict[str, Any]) -> bool:
    """Print the comparison for one ability; whether its limit is kept."""
    count = len(ours.calls)
    rate, reference = count / median(ours.seconds), count / median(theirs["cpu_seconds"])
    ratio: float = rate / reference
    needed = RATIOS[ability]
    pairs = zip(ours.calls, theirs["succeeded"], strict=True)
    same = sum(_succeeds(score()) == bool(succeeded) for score, succeeded in pairs)
    print(
        f"{'kept  ' if ratio >= needed else 'MISSED'}  {ability}: ratio {ratio:,.0f}, at least {needed:,.0f}"
    )
    print(
        f"        reference {reference:,.1f}, eai {rate:,.0f} answers per CPU s; "
        f"same success on {same} of {count}"
    )
    return ratio >= needed


def main() -> int:
    """Run both sides and print the comparison."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--plans", type=Path, nargs="+", default=[], help="response files of action sequencing"
    )
    parser.add_argument("--subgoals", type=Path, nargs="+", default=[], help="of subgoal decomposition")
    parser.add_argument("--limit", type=int, help="the first N tasks only")
    parser.add_argument(
        "--repeats", type=int, default=8, help="runs of ours before and after the reference's"
    )
    parser.add_argument("--cache", type=Path, default=CACHE, help="where the reference's environment is kept")
    arguments = parser.parse_args()
    fetch(packs=published_packs())
    load = loading()
    tasks = dict(islice(open_tasks().items(), arguments.limit))
    plans = answers(tasks, arguments.plans, made_plan)
    goals = answers(tasks, arguments.subgoals, made_subgoals)
    ours = {
        "action_sequencing": scoring(BehaviorActionSequencing, tasks, plans),
        "subgoal_decomposition": scoring(BehaviorSubgoalDecomposition, tasks, goals),
    }
    scenes = {task_id: described(task) for task_id, task in tasks.items()}
    given = {"scenes": scenes, "action_sequencing": plans, "subgoal_decomposition": goals}
    gc.collect()
    gc.freeze()
    for each in ours.values():
        each.run(arguments.repeats)
    theirs = run_reference(environment(arguments.cache), given)
    for each in ours.values():
        each.run(arguments.repeats)
    print(f"{len(tasks)} tasks, {REFERENCE}, Python {theirs['python']}; load {load:.2f} CPU s")
    kept = [report(ability, each, theirs[ability]) for ability, each in ours.items()]
    return 0 if all(kept) and load <= LOAD_CPU_SECONDS else 1


if __name__ == "__main__":
    sys.exit(main())
