"""Judge answers one by one with the reference package, for `compare_with_reference.py`.

`python compare_with_reference_child.py DOMAIN ABILITY ROWS`, with PYTHONHASHSEED=0. ROWS is a JSON file with
`rows`, each a task's id and an answer, and with the `scenes` of BEHAVIOR. Each printed line is the verdict on
a row as a JSON object, in order. A line with `crash` names the exception that would have ended the whole run.

The package is unmodified, and its own functions judge. Replacements in memory change only order and speed.
If the package depends on the order of a set of strings or on chance, it gets the order and the seed that
`eai-1.0.5` has. Objects that are never changed are not copied, because copying takes most of the package's
time. `EAI_EVERY_COPY=1` makes all copies, to verify that they change no verdict.
"""

# mypy: ignore-errors
# It calls a package that has no types, and runs in an environment without ours.

import builtins
import copy
import functools
import importlib
import io
import json
import os
import random
import re
import signal
import sys
import tempfile
import types
from contextlib import contextmanager, redirect_stdout, suppress
from pathlib import Path

MAX_SECONDS = 60
"""Maximum processor seconds of an answer: ways to execute subgoals double with each alternative."""

SEED = 0
FOLDER = tempfile.TemporaryDirectory(prefix="eai-bench-")
"""Temporary folder for files that the package reads and writes."""

COUNTED = {
    "Parsing wrong": "parsing",
    "Hallucination": "hallucination",
    "Parameter wrong": "argument_number",
    "Wrong order": "wrong_order",
    "Missing step": "missing_step",
    "Affordance error": "affordance",
    "Additional step": "additional_step",
}
"""Kinds of error of plans, by their names in the package's log."""

KINDS = {
    "AFFORDANCE_ERROR": "affordance",
    "WRONG_TEMPORAL_ORDER": "wrong_order",
    "MISSING_STEP": "missing_step",
    "ADDITIONAL_STEP": "additional_step",
    "hullucination": "hallucination",
    "arguments": "argument_number",
}
"""Kinds of error that have another name in the package."""

CATEGORIES = {"GoalUnreachable": "goal_unreachable", "NotParseable": "not_parseable"}
VIRTUALHOME = "virtualhome_eval"
GRAPHS = VIRTUALHOME + ".simulation.evolving_graph"


class OverlongError(BaseException):
    """An answer took more than `MAX_SECONDS`."""


@contextmanager
def time_limit():
    """Raise `OverlongError` in a block that exceeds `MAX_SECONDS` of this process's time."""

    def stop(number, frame):
        raise OverlongError

    signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, MAX_SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)


class Journal:
    """Replaces a module's logger and keeps the lines."""

    def __init__(self):
        self.lines = []

    def info(self, text, *args):
        """Keep a line."""
        self.lines.append(str(text))

    warning = error = debug = info

    def numbers(self, pattern):
        """Return the groups of the last line that has the pattern as numbers, or None if no line has it."""
        for line in reversed(self.lines):
            found = re.search(pattern, line)
            if found:
                return [int(group) for group in found.groups()]
        return None

    def number(self, pattern):
        """Return the only group of the last line that has the pattern as a number, or 0 if no line has it."""
        found = self.numbers(pattern)
        return found[0] if found else 0

    def has(self, text):
        """Return whether a line has a text."""
        return any(text in line for line in self.lines)


def without_copies():
    """Return a replacement of the module `copy` that shares read-only values and the graphs of states."""

    def share(value):
        if isinstance(value, dict):
            return value
        return list(value) if isinstance(value, list) else copy.deepcopy(value)

    return types.SimpleNamespace(deepcopy=share, copy=copy.copy)


def prepare_virtualhome(*modules):
    """Share values that are never changed: graphs, and values that the modules copy."""
    if os.environ.get("EAI_EVERY_COPY"):
        return
    environment = importlib.import_module(GRAPHS + ".environment")
    environment.EnvironmentGraph.__deepcopy__ = lambda self, memo: self
    for module in modules:
        module.copy = without_copies()
    utils = importlib.import_module(GRAPHS + ".utils")
    for name in ("load_name_equivalence", "load_properties_data", "load_object_placing"):
        table = getattr(utils, name)()
        setattr(utils, name, lambda table=table: table)


def virtualhome_arguments(ability, folder):
    """Return the arguments that the package's command line passes to an evaluation."""
    package = Path(importlib.import_module(VIRTUALHOME).__path__[0])
    return types.SimpleNamespace(
        mode="evaluate_results",
        eval_type=ability,
        dataset="virtualhome",
        llm_response_path=folder,
        output_dir=folder + "/out",
        scene_id=1,
        num_workers=1,
        resource_dir=str(package / "resources"),
        dataset_dir=str(package / "dataset"),
        evaluation_dir=str(package / "evaluation"),
    )


def evaluation_of(ability):
    """Return the module of an evaluation, and a function that runs it on an answer and returns its log."""
    evaluation = importlib.import_module(VIRTUALHOME + ".evaluation." + ability + ".scripts.evaluate_results")
    library = importlib.import_module(GRAPHS + ".eval_utils")
    prepare_virtualhome(evaluation)
    folder = tempfile.mkdtemp(dir=FOLDER.name)
    path = Path(folder) / "virtualhome" / ability / "model_outputs.json"
    path.parent.mkdir(parents=True)
    arguments = virtualhome_arguments(ability, folder)

    def run(task_id, text):
        path.write_text(json.dumps([{"identifier": task_id, "llm_output": text}]))
        evaluation.logger = library.logger = journal = Journal()
        with suppress(ZeroDivisionError):  # the task may have no goal of a kind
            evaluation.evaluate_results(arguments)
        return journal

    return evaluation, run


def virtualhome_action_sequencing(given):
    """Return the judge of VirtualHome plans, which reads the verdict from the log.

    Two action goals come in alphabetical order.
    """
    evaluation, run = evaluation_of("action_sequencing")
    evaluation.set = lambda values: sorted(builtins.set(values))

    def judge(task_id, text):
        journal = run(task_id, text)
        if journal.has("did not pass gold test"):
            return {"excluded": True}
        goals = r"Predicted: node_match_num=(\d+), edge_match_num=(\d+), action_match_num=(-?\d+)"
        counts = {kind: journal.number(name + r": (\d+), rate") for name, kind in COUNTED.items()}
        return {
            "excluded": False,
            "executable": bool(journal.number(r"Executable plan: (\d+), rate")),
            "success": bool(journal.number(r"Correct plan: (\d+), rate")),
            "errors": {kind: count for kind, count in counts.items() if count},
            "goals": journal.numbers(goals) or [0, 0, 0],
        }

    return judge


def virtualhome_goal_interpretation(given):
    """Return the judge of VirtualHome goals, which reads the verdict from the log.

    If a class has several objects, the object with the largest id comes last.
    """
    _, run = evaluation_of("goal_interpretation")
    planner = importlib.import_module(GRAPHS + ".motion_planner").MotionPlanner
    in_any_order = planner.get_relevant_nodes
    planner.get_relevant_nodes = lambda self, script_id=None: sorted(in_any_order(self, script_id))

    def judge(task_id, text):
        journal = run(task_id, text)
        kinds = {"state": "Node", "relation": "Edge", "action": "Action", "all": "All"}
        found = {
            kind: journal.numbers(name + r": TP: (-?\d+), FP: (-?\d+), FN: (-?\d+)")
            for kind, name in kinds.items()
        }
        unreadable = journal.has("has format wrong output") and not journal.has("predicted output=")
        return {
            "ends the run": False,
            **found,
            "unreadable": unreadable,
            "ill-formed": journal.number(r"Format wrong num is (\d+), Total") - unreadable,
            "hallucinated": journal.number(r"Hallucination num is (\d+), Total"),
        }

    return judge


def virtualhome_subgoal_decomposition(given):
    """Return the judge of VirtualHome subgoals: category, kinds of error, goals."""
    simulation = importlib.import_module(VIRTUALHOME + ".evaluation.subgoal_decomposition.subgoal_sim_utils")
    checkers = importlib.import_module(VIRTUALHOME + ".evaluation.subgoal_decomposition.checkers")
    prepare_virtualhome(checkers)
    logic = importlib.import_module(VIRTUALHOME + ".tl_formula.simple_tl")
    logic.has_id = functools.lru_cache(maxsize=None)(logic.has_id)  # the result depends on the name alone
    arguments = virtualhome_arguments("subgoal_decomposition", tempfile.gettempdir())
    vocabulary = arguments.resource_dir + "/vocabulary.json"

    def judge(task_id, text):
        random.seed(SEED)
        verdict, report = told(
            simulation.evaluate_task(vocabulary, 1, task_id, text, arguments), misused=True
        )
        if isinstance(report, dict):
            verdict["goals"] = [report[name + "_success_num"] for name in ("node", "edge", "action")]
        return verdict

    return judge


def told(report, misused):
    """Return the category and kinds of error in a report on subgoals, and its part on goals.

    ``misused`` is the value that reports a wrong number of objects. The package has one value for VirtualHome
    and another for BEHAVIOR.
    """
    category, *rest = report
    verdict = {"category": CATEGORIES.get(category, category.lower())}
    if category == "Hallucination":
        wrong_number = rest[0].get("IncorrectParamLength") is misused
        verdict["errors"] = ["argument_number" if wrong_number else "hallucination"]
    elif category != "NotParseable":
        kinds = [str(kind) for entry in rest[-2] for kind in entry["error_info"]["error_type"]]
        verdict["errors"] = [KINDS[kind.rpartition(".")[2]] for kind in kinds if "GOAL_FAILED" not in kind]
    return verdict, rest[-1]


def transition_modeling(given):
    """Return the judge of operators: counts by category, without a planner."""
    failing = types.ModuleType("fd")
    failing.FD = type("FD", (), {"plan_from_pddl": lambda self, *args, **kwargs: 1 / 0})
    sys.modules[GRAPHS + ".pddlgym_planners.fd"] = failing
    module = importlib.import_module(VIRTUALHOME + ".evaluation.transition_modeling.scripts.evaluate_results")
    package = Path(importlib.import_module(VIRTUALHOME).__path__[0])
    root, domain = package / "resources" / given["domain"], given["domain"]

    def read(name):
        return json.loads((root / (name + ".json")).read_text())

    actions, categories = read("id2action"), read("predicates_category")
    shared = [
        "model",
        domain,
        100,
        str(root),
        tempfile.mkdtemp(dir=FOLDER.name),
        str(root / "problem_pddl"),
        actions,
        read("id2category_2"),
        read("id2task"),
        read("success_task"),
        categories,
        read("gold_action"),
        set(categories.values())
        | {"object_tools", *(c for cs in read("id2category_2").values() for c in cs)},
        {name for names in actions.values() for name in names},
        set(categories),
    ]

    def judge(task_id, text):
        result, _ = module.worker_process(({"identifier": task_id, "llm_output": text}, *shared))
        if result.get("format_wrong_num"):
            return {"excluded": True}
        sides = {"precondition": "precond_predicate_type_res", "effect": "effect_predicate_type_res"}
        return {
            "excluded": False,
            **{
                side: {category.replace("-", "_"): n for category, n in result[key].items() if any(n)}
                for side, key in sides.items()
            },
            "hallucinated": result["hallucination_num"],
            "written": result["total_predict_action_num"],
        }

    return judge


virtualhome_transition_modeling = behavior_transition_modeling = transition_modeling


def behavior_goal_interpretation(given):
    """Return the judge of BEHAVIOR goals, which uses the package's detailed analysis."""
    importlib.import_module("behavior_reference_child")
    module = importlib.import_module("behavior_eval.evaluation.goal_interpretation.scripts.evaluate_results")
    data = module.goal_interpretation_data()

    def judge(task_id, text):
        said, unreadable = module.parse_json(text, "model")
        found = module.evaluate_goals(said, data.demo_to_conds[task_id]["goal_conditions"])
        analysis = module.per_demo_error_analysis(task_id, *found, data)
        keys = ("num_satisfied_conditions", "num_false_positive_conditions", "num_unsatisfied_conditions")
        kinds = {"state": "state_goal", "relation": "relation_goal", "all": "overall"}
        errors = analysis["grammatical_errors"]
        return {
            "ends the run": False,
            **{kind: [analysis[name][key] for key in keys] for kind, name in kinds.items()},
            "unreadable": unreadable is not None,
            "ill-formed": errors["format_error_num"],
            "hallucinated": errors["object_hallucination_num"],
            "unknown predicates": errors["state_hallucination_num"],
        }

    return judge


def behavior_action_sequencing(given):
    """Return the judge of BEHAVIOR plans in the symbolic scene."""
    child = importlib.import_module("behavior_reference_child")

    def judge(task_id, text):
        evaluator = child.action_sequencing(given["scenes"][task_id], text)()
        info, state = evaluator.evaluation_info, evaluator.evolving_graph.action_env.cur_state
        flags, reached = info["error_type"], state.check_success(evaluator.task)["subgoal_success"]
        kinds = [name.rpartition(".")[2] for name, said in flags.items() if said]
        errors = {KINDS.get(kind, kind): 1 for kind in kinds if kind != "execution_success"}
        if "unknown_execution_error" in info:
            errors["uncategorised"] = 1
        return {
            "executable": flags["execution_success"],
            "success": all(reached),
            "errors": errors,
            "goals met": reached,
        }

    return judge


def behavior_subgoal_decomposition(given):
    """Return the judge of BEHAVIOR subgoals in the symbolic scene."""
    child = importlib.import_module("behavior_reference_child")

    def judge(task_id, text):
        scene = given["scenes"][task_id]
        random.seed(SEED)
        try:
            report = child.subgoal_decomposition(scene, text)()
        except UnboundLocalError:  # the stand-ins may have no relation left, unlike the simulator
            raise
        except Exception as error:  # as `evaluate_task` does
            report = ("NotParseable", str(error), None)
        verdict, goals = told(report, misused=False)
        if isinstance(goals, dict):
            verdict["goals met"] = goals["subgoal_success"]
        return verdict

    return judge


def main(domain, ability, path):
    """Judge every row and print the verdicts."""
    given = dict(json.loads(Path(path).read_text()), domain=domain)
    sys.path.insert(0, str(Path(__file__).parent))
    printed, sys.stdout = sys.stdout, io.StringIO()
    judge = globals()[domain + "_" + ability](given)
    for task_id, text in given["rows"]:
        try:
            with time_limit(), redirect_stdout(io.StringIO()):
                verdict = judge(task_id, text)
        except OverlongError:
            verdict = {"overlong": MAX_SECONDS}
        except Exception as error:
            verdict = {"crash": type(error).__name__ + ": " + str(error)[:200]}
        print(json.dumps(verdict), file=printed, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
