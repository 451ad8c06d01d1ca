"""BEHAVIOR: our speed as a ratio to the reference's symbolic evaluation, on the same answers in one run.

`python bench/behavior.py`. The reference needs a simulator even to score text; here objects that say what our
records say stand in its place, so that only its symbolic part is measured. The answers are the data set's own
plans, and the same plans told as subgoals. Only processor time counts, scoring alone on both sides; loading
our data has a limit of its own. Exits with status 1 when a limit is missed.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from eai.abilities.action_sequencing.behavior import ActionSequencing
from eai.abilities.action_sequencing.behavior_writer import join_steps, write_steps
from eai.abilities.behavior_goals import SceneObjects
from eai.abilities.protocol import Protocol
from eai.abilities.subgoal_decomposition.behavior import SubgoalDecomposition
from eai.abilities.verdict import Verdict
from eai.data.behavior_evidence import load_evidence
from eai.data.behavior_tasks import BehaviorTask, initial_relations, initial_states, open_tasks
from eai.data.dataset import fetch
from eai.logic.formula import Formula, Not
from eai.logic.traversal import walk
from eai.logic.truncated_options import truncated_options
from eai.world.execution import Action
from eai.world.state import Scene
from reference import CACHE, REFERENCE, environment

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


@dataclass(frozen=True, slots=True)
class Answers:
    """The answers to one task."""

    task: BehaviorTask
    plan: str
    subgoals: str


def answers(task: BehaviorTask) -> Answers:
    """The data set's plan as text, and told as subgoals."""
    plan = join_steps(write_steps(task.script, task.scene))
    return Answers(task, plan, json.dumps({"output": list(subgoals(task.script, task.scene))}))


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


def described(answer: Answers) -> dict[str, Any]:
    """What the reference's stand-in for the simulator is told of a task, with the answers."""
    task, record, evidence = answer.task, answer.task.record, load_evidence()
    relations = list(initial_relations(record, evidence))
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
        mine = [relation for relation in relations if relation.source == thing.name]
        volume = evidence.volumes.of(record.scene, thing.name, thing.model)
        for name in (thing.name, *thing.parts):
            part = name != thing.name
            related = (
                {}
                if part
                else {r.predicate: [s.target for s in mine if s.predicate == r.predicate] for r in mine}
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
                for option in truncated_options(goal.formula, SceneObjects(task.scene))
            ],
        }
        for goal in task.goals
    ]
    return {
        "activity": record.activity,
        "objects": objects,
        "scope": [[thing.instance, [thing.name, *thing.parts]] for thing in record.objects],
        "goals": goals,
        "plan": answer.plan,
        "subgoals": answer.subgoals,
    }


def spelt(state: str) -> str:
    """A state as the simulator names its class."""
    return "".join(word.capitalize() for word in state.split("_"))


def listed(literal: Formula, instances: dict[str, str]) -> list[Any]:
    """A literal as bddl writes ground options."""
    if isinstance(literal, Not):
        return ["not", listed(literal.operand, instances)]
    return [literal.predicate, *(instances[term.name] for term in literal.arguments)]  # type: ignore[union-attr]


def run_reference(python: Path, scenes: list[dict[str, Any]]) -> dict[str, Any]:
    """Let the reference evaluate all scenes in a process of its own."""
    probe = [str(python), "-c", "import networkx, yaml"]
    if subprocess.run(probe, check=False, capture_output=True).returncode:
        subprocess.run([str(python), "-m", "pip", "install", "--quiet", *ALSO_IMPORTED], check=True)
    with tempfile.TemporaryDirectory(prefix="eai-bench-") as folder:
        path = Path(folder) / "scenes.json"
        path.write_text(json.dumps(scenes), encoding="utf-8")
        child = subprocess.run(
            [str(python), "-W", "ignore", str(CHILD), str(path)],
            check=True,
            stdout=subprocess.PIPE,
            text=True,
        )
    report: dict[str, Any] = json.loads(child.stdout.splitlines()[-1])
    return report


def cost(score: Sequence[Callable[[], Verdict]], repeats: int) -> tuple[float, list[bool]]:
    """Seconds of processor time to score all answers once, the median of several runs, and their success."""
    seconds = []
    for _ in range(repeats):
        started = time.process_time()
        verdicts = [each() for each in score]
        seconds.append(time.process_time() - started)
    return sorted(seconds)[repeats // 2], [bool(verdict.success) for verdict in verdicts]


def loading() -> float:
    """Seconds of processor time to load all records and make all tasks."""
    started = time.process_time()
    dict(open_tasks())
    return time.process_time() - started


def main() -> int:
    """Run both sides and print the comparison."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--limit", type=int, help="the first N tasks only")
    parser.add_argument("--repeats", type=int, default=15, help="runs of ours")
    parser.add_argument("--cache", type=Path, default=CACHE, help="where the reference's environment is kept")
    arguments = parser.parse_args()
    fetch()
    load = loading()
    given = [answers(task) for task in open_tasks().values()][: arguments.limit]
    theirs = run_reference(environment(arguments.cache), [described(each) for each in given])
    kept = load <= LOAD_CPU_SECONDS
    print(f"{len(given)} tasks, {REFERENCE}, Python {theirs['python']}; load {load:.2f} CPU s")
    reference = Protocol.EAI_1_0_5
    plans = [(ActionSequencing(each.task, reference).score, each.plan) for each in given]
    goals = [(SubgoalDecomposition(each.task, reference).score, each.subgoals) for each in given]
    for ability, calls in (("action_sequencing", plans), ("subgoal_decomposition", goals)):
        ours, succeeded = cost([lambda s=s, t=t: s(t) for s, t in calls], arguments.repeats)  # type: ignore[misc]
        ratio = theirs[ability]["cpu_seconds"] / ours
        same = sum(a == bool(b) for a, b in zip(succeeded, theirs[ability]["succeeded"], strict=True))
        fine = ratio >= RATIOS[ability]
        kept = kept and fine
        rate = len(given) / theirs[ability]["cpu_seconds"]
        mine, needed = len(given) / ours, RATIOS[ability]
        print(f"{'kept  ' if fine else 'MISSED'}  {ability}: ratio {ratio:,.0f}, at least {needed:,.0f}")
        print(f"        reference {rate:.1f}, eai {mine:,.0f} tasks per CPU s; same success on {same}")
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
