"""Run the reference package's symbolic evaluation of BEHAVIOR, for `compare_with_reference_child.py`.

It runs in an environment with `eai-eval`, networkx and PyYAML. Stand-in objects replace the simulator and
report the recorded state of each task. The evaluation itself is the package's own, unmodified.
"""

# mypy: ignore-errors
# It stands in for modules of packages that have no types, and runs in an environment without ours.

import importlib
import importlib.abc
import importlib.machinery
import json
import sys
import tempfile
import types
from pathlib import Path

FOLDER = tempfile.TemporaryDirectory(prefix="eai-bench-")
"""Temporary folder for answers that the package reads from files."""

ABSENT = ("igibson", "gym", "bddl", "pybullet", "pyquaternion")


class Anything(types.ModuleType):
    """A module of a package that is not installed. Each name in it is a separate class."""

    __path__ = ()

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        value = type(name, (), {})
        setattr(self, name, value)
        return value


class Absent(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds modules of packages that are not installed."""

    def find_spec(self, fullname, path=None, target=None):
        if fullname.split(".")[0] in ABSENT:
            return importlib.machinery.ModuleSpec(fullname, self, is_package=True)
        return None

    def create_module(self, spec):
        return Anything(spec.name)

    def exec_module(self, module):
        pass


sys.meta_path.insert(0, Absent())
object_states = importlib.import_module("igibson.object_states")
URDFObject = importlib.import_module("igibson.objects.articulated_object").URDFObject
ObjectMultiplexer = importlib.import_module("igibson.objects.multi_object_wrappers").ObjectMultiplexer
RoomFloor = importlib.import_module("igibson.object_states.on_floor").RoomFloor
NOT_YET = {"all_goal_satisfied_graph": None}
RELATIONS = {"inside": "Inside", "ontop": "OnTop", "onfloor": "OnFloor", "under": "Under", "nextto": "NextTo"}


class Value:
    """A state of an object, in the simulator's interface."""

    def __init__(self, value):
        self.value = value

    def get_value(self, other=None):
        """Return the value, or whether the relation to another object holds."""
        return self.value if other is None else other.name in self.value


class Condition:
    """An initial fact or a goal, in the form that the reference package expects."""

    def __init__(self, terms, options=()):
        self.terms = terms
        self.flattened_condition_options = options


class Nothing:
    """Stand-in for the simulator's transition model: an action has no cost and no effect."""

    def apply_action(self, action, objects):
        """Do nothing."""

    def final_step(self):
        """Do nothing."""


def make_object(described):
    """Return a stand-in for a simulator's object, with the recorded states."""
    thing = (RoomFloor if described["floor"] else URDFObject)()
    thing.name = described["name"]
    thing.bounding_box = (described["volume"], 1.0, 1.0)
    thing.states = {getattr(object_states, name): Value(value) for name, value in described["states"].items()}
    for relation, name in RELATIONS.items():
        thing.states[getattr(object_states, name)] = Value(set(described["relations"].get(relation, ())))
    return thing


def make_task(scene):
    """Return a stand-in for a simulator's task, with the attributes that the evaluation reads."""
    objects = {described["name"]: make_object(described) for described in scene["objects"]}
    task = types.SimpleNamespace(behavior_activity=scene["activity"])
    task.initial_conditions = [Condition(terms) for terms in scene["initial"]]
    task.goal_conditions = [Condition(goal["terms"], goal["options"]) for goal in scene["goals"]]
    task.check_success = lambda: (False, {"satisfied": []})
    task.object_scope = {}
    for instance, names in scene["scope"]:
        task.object_scope[instance] = objects[names[0]]
        if len(names) > 1:
            whole = ObjectMultiplexer()
            whole.name = names[0]
            whole._multiplexed_objects = [objects[name] for name in names]
            task.object_scope[instance] = whole
    return task


def action_sequencing(scene, plan):
    """Return a function that evaluates a plan and returns the evaluator with its results."""
    module = importlib.import_module("behavior_eval.evaluation.action_sequencing.action_sequence_evaluator")
    task = make_task(scene)

    def evaluate():
        evaluator = object.__new__(module.ActionSequenceEvaluator)
        evaluator.task = task
        evaluator.transition_model = Nothing()
        evaluator.evolving_graph = module.EvalGraphEnv(task=task)
        evaluator.get_name_mapping()
        evaluator.evaluation_info = {"error_type": {"execution_success": True}, "goal_rst": dict(NOT_YET)}
        evaluator.object_name = set(evaluator.evolving_graph.obj_name_to_obj)
        evaluator.action_name = {action.name for action in module.EvalActions}
        evaluator.evaluate_all(plan)
        return evaluator

    return evaluate


def subgoal_decomposition(scene, subgoals):
    """Return a function that evaluates subgoals and returns the package's report."""
    module = importlib.import_module("behavior_eval.evaluation.subgoal_decomposition.subgoal_sim_utils")
    task = make_task(scene)
    path = Path(tempfile.mkdtemp(dir=FOLDER.name)) / "plan.json"
    path.write_text(json.dumps([{"identifier": scene["activity"], "llm_output": subgoals}]))

    def evaluate():
        evaluator = object.__new__(module.EvalSubgoalPlan)
        evaluator.env = module.EvalGraphEnv(task=task)
        named = list(evaluator.env.get_name_mapping())
        evaluator.category_map = evaluator.get_tl_category(named)
        evaluator.tl_name_mapping = evaluator.get_tl_name_mapping(named, evaluator.category_map)
        evaluator.tl_relevant_objects = [each["name"] for each in evaluator.tl_name_mapping]
        evaluator.subgoal_plan = module.SubgoalPlanHalfJson(str(path), scene["activity"])
        return evaluator.evaluate_subgoal_plan()

    return evaluate
