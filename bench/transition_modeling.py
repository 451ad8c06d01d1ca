"""Transition modeling: our speed as a ratio to the reference's, on VirtualHome's gold operators in one run.

`.venv/bin/python bench/transition_modeling.py`. Only processor time counts, that of child processes
included. Without the planner the reference's is that of its own worker function, one process, its imports
not counted. With the planner it is that of the planner's own command (`fast-downward.py --alias
lama-first`) alone, on a domain that is already written, on every tenth task. Ours is scoring the same
answers in this process, with nothing remembered from before. Exits with status 1 when a limit is missed.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import median

from eai.abilities.operator_task import TransitionTask
from eai.abilities.transition_modeling.scorer import TransitionModeling
from eai.benchmark.gold_answers import join_operators
from eai.households.published import open_virtualhome
from eai.pddl.fast_downward import FastDownward
from eai.pddl.planners import make_planner
from eai.pddl.planning import PddlPlanner, PlannerChoice
from eai.reference.operator_rules import ReferenceRules
from reference import CACHE, REFERENCE, environment, package_folder

LOGIC_RATIO = 50.0
PLANNER_RATIO = 5.0
EVERY = 10
REPEATS = 5
NEEDED = ("numpy", "scipy")
CHILD = """
import json, os, sys, time, types
fd = types.ModuleType("fd")
class FD:
    def plan_from_pddl(self, *args, **kwargs):
        raise RuntimeError("no planner")
fd.FD = FD
sys.modules["virtualhome_eval.simulation.evolving_graph.pddlgym_planners.fd"] = fd
from virtualhome_eval.evaluation.transition_modeling.scripts import evaluate_results as module
root, folder = sys.argv[1:]
read = lambda name: json.load(open(os.path.join(root, name + ".json")))
actions, categories = read("id2action"), read("predicates_category")
shared = ["model", "virtualhome", 100, root, folder, os.path.join(root, "problem_pddl"), actions,
          read("id2category_2"), read("id2task"), read("success_task"), categories, read("gold_action"),
          set(categories.values()) | {"object_tools"}, {name for names in actions.values() for name in names},
          set(categories)]
responses = json.load(sys.stdin)
start = time.process_time()
for response in responses:
    result, _ = module.worker_process((response, *shared))
    assert result["total_predict_action_num"]
print(time.process_time() - start)
"""


def cpu_seconds(work: Callable[[], object]) -> float:
    """Processor time of a piece of work, its child processes included."""
    start = _used()
    work()
    return _used() - start


def _used() -> float:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def gold_answer(task: TransitionTask) -> str:
    return join_operators(task.domain.operators[name].pddl for name in task.operators)


def ours(tasks: Sequence[TransitionTask], planner: PddlPlanner | None) -> float:
    """Scoring the gold answers under eai-1.0.5: the median of several runs, nothing remembered between
    them."""
    costs = []
    for _ in range(REPEATS):
        rules = ReferenceRules(planner)
        scorers = [(TransitionModeling(task, rules), gold_answer(task)) for task in tasks]
        start = _used()
        for scorer, text in scorers:
            scorer.score(text)
        costs.append(_used() - start)
    return median(costs)


def reference_logic(tasks: Sequence[TransitionTask], python: Path) -> float:
    """The reference's own worker on the same answers, one process, with a planner that fails at once."""
    subprocess.run(
        [str(python), "-m", "pip", "install", "--quiet", *NEEDED], check=True, stdout=subprocess.DEVNULL
    )
    responses = [{"identifier": task.id, "llm_output": gold_answer(task)} for task in tasks]
    root = package_folder(python) / "resources" / "virtualhome"
    with tempfile.TemporaryDirectory(prefix="eai-bench-") as folder:
        done = subprocess.run(
            [str(python), "-W", "ignore", "-c", CHILD, str(root), folder],
            input=json.dumps(responses),
            check=True,
            stdout=subprocess.PIPE,
            text=True,
        )
    return float(done.stdout.splitlines()[-1])


def reference_planner(tasks: Sequence[TransitionTask], header: str) -> float:
    """The planner's own command on each task, with all gold operators."""
    binaries = FastDownward.installed().binaries
    driver = binaries.parents[2] / "fast-downward.py"
    with tempfile.TemporaryDirectory(prefix="eai-bench-") as name:
        folder = Path(name)
        operators = "\n".join(operator.pddl for operator in tasks[0].domain.operators.values())
        (folder / "domain.pddl").write_text(f"{header}\n{operators})")

        def plan_all() -> None:
            for task in tasks:
                (folder / "problem.pddl").write_text(task.problem_text)
                command = [
                    sys.executable,
                    str(driver),
                    "--alias",
                    "lama-first",
                    "domain.pddl",
                    "problem.pddl",
                ]
                subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)

        return cpu_seconds(plan_all)


def report(name: str, count: int, mine: float, theirs: float, limit: float) -> bool:
    """Print one comparison; whether its limit is kept."""
    ratio = theirs / mine
    print(f"{name}: reference {count / theirs:.1f}, eai {count / mine:.1f} tasks per CPU s ({count} tasks)")
    print(f"{'kept  ' if ratio >= limit else 'MISSED'}  ratio {ratio:.0f}, at least {limit:.0f}")
    return ratio >= limit


def main() -> int:
    """Run both sides and print the comparison."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cache", type=Path, default=CACHE, help="where the reference's environment is kept")
    arguments = parser.parse_args()
    python = environment(arguments.cache)
    tasks = list(open_virtualhome().values())
    some = tasks[::EVERY]
    header = (package_folder(python) / "resources" / "virtualhome" / "virtualhome_pd.pddl").read_text()
    print(f"gold operators, {REFERENCE}")
    logic = report("logic", len(tasks), ours(tasks, None), reference_logic(tasks, python), LOGIC_RATIO)
    planner = make_planner(PlannerChoice.FULL, 100)
    theirs = reference_planner(some, header)
    planned = report("logic and planner", len(some), ours(some, planner), theirs, PLANNER_RATIO)
    return 0 if logic and planned else 1


if __name__ == "__main__":
    raise SystemExit(main())
