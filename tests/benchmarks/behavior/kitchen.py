"""A made-up BEHAVIOR task: a kitchen and a garage with an object for each action."""

from __future__ import annotations

from collections.abc import Mapping

from eai.benchmarks.behavior.evidence import UnpublishedSceneFacts, _EstimatedObjectVolumes
from eai.benchmarks.behavior.records import BehaviorObject, BehaviorRecord, GroundOption
from eai.benchmarks.behavior.tasks import BehaviorTask, build_task
from eai.pddl.bddl import parse_problem
from eai.world.action import Action
from eai.world.state import State

TASK_ID = "making_a_mess_0_Nowhere_0_int_0_2021-01-01_00-00-00"

ABILITIES: Mapping[str, str] = {
    "floor": "dustyable stainable",
    "fridge": "openable coldSource dustyable",
    "table": "dustyable stainable",
    "sink": "toggleable waterSource stainable",
    "dishwasher": "openable toggleable dustyable",
    "rag": "cleaningTool soakable dustyable stainable",
    "plate": "dustyable stainable",
    "peach": "sliceable cookable freezable",
    "carving_knife": "slicer dustyable",
    "saucepan": "dustyable stainable",
    "carton": "openable dustyable",
    "detergent": "soap",
    "car": "dustyable",
    "pebble": "",
}
"""Model category -> its abilities in the taxonomy."""

OBJECTS = {
    "room_floor_kitchen_0": "floor",
    "room_floor_garage_0": "floor",
    "fridge_1": "fridge",
    "table_1": "table",
    "sink_1": "sink",
    "dishwasher_1": "dishwasher",
    "rag_1": "rag",
    "rag_10": "rag",
    "plate_1": "plate",
    "plate_2": "plate",
    "peach_1": "peach",
    "carving_knife_1": "carving_knife",
    "saucepan_1": "saucepan",
    "carton_1": "carton",
    "detergent_1": "detergent",
    "car_1": "car",
    "pebble_1": "pebble",
}

EVIDENCE = UnpublishedSceneFacts(
    initially_open=frozenset({"carton"}),
    standing=frozenset({"fridge", "table", "sink", "dishwasher", "car"}),
    added={TASK_ID: (("nextto", "rag_1", "rag_10"),)},
    removed={TASK_ID: frozenset({("ontop", "pebble_1")})},
    listed_relations_only=frozenset(),
    volumes=_EstimatedObjectVolumes(0.1, 0.5, {"car": 12.0, "fridge": 1.0, "pebble": 0.01, "table": 1.0}, {}),
    sha256="0" * 64,
)


def get_instance(name: str) -> str:
    """Return the instance name in BDDL, such as ``plate.n.01_2`` for ``plate_2``."""
    if name.startswith("room_floor"):
        return f"floor.n.01_{1 if 'kitchen' in name else 2}"
    kind, _, number = name.rpartition("_")
    return f"{kind}.n.01_{number}"


def _make_object(name: str, kind: str) -> BehaviorObject:
    synset = f"{kind}.n.01"
    model = "room_floor" if kind == "floor" else kind
    return BehaviorObject(name, get_instance(name), synset, model, synset, tuple(ABILITIES[kind].split()))


INIT = """
(inside peach.n.01_1 fridge.n.01_1) (ontop plate.n.01_1 table.n.01_1) (ontop plate.n.01_2 table.n.01_1)
(onfloor rag.n.01_1 floor.n.01_1) (onfloor rag.n.01_10 floor.n.01_1) (ontop carving_knife.n.01_1 table.n.01_1)
(ontop saucepan.n.01_1 table.n.01_1) (onfloor carton.n.01_1 floor.n.01_2)
(ontop detergent.n.01_1 table.n.01_1)
(ontop pebble.n.01_1 table.n.01_1) (dusty plate.n.01_1) (stained plate.n.01_1) (dusty plate.n.01_2)
(inroom floor.n.01_1 kitchen) (inroom floor.n.01_2 garage) (inroom fridge.n.01_1 kitchen)
(inroom table.n.01_1 kitchen) (inroom sink.n.01_1 kitchen) (inroom dishwasher.n.01_1 kitchen)
(inroom car.n.01_1 garage) (onfloor agent.n.01_1 floor.n.01_1)
"""

CLEAN = "(forall (?plate.n.01 - plate.n.01) (not (dusty ?plate.n.01)))"
GOAL = f"(and (inside peach.n.01_1 saucepan.n.01_1) {CLEAN})"


def make_record(goal: str = GOAL) -> BehaviorRecord:
    """Return the record of the task. Its first goal of goal interpretation has two options."""
    options: tuple[tuple[GroundOption, ...], ...] = (
        ((("inside", "peach.n.01_1", "saucepan.n.01_1"),), (("inside", "peach.n.01_1", "sink.n.01_1"),)),
        ((("not", ("dusty", "plate.n.01_1")), ("not", ("dusty", "plate.n.01_2"))),),
        ((("nextto", "rag.n.01_1", "rag.n.01_10"),),),
    )
    objects = tuple(_make_object(name, kind) for name, kind in OBJECTS.items())
    declared = " ".join(f"{obj.instance} - {obj.category}" for obj in objects)
    text = (
        f"(define (problem mess) (:domain igibson) (:objects {declared} agent.n.01_1 - agent.n.01)"
        f"(:init {INIT}) (:goal {goal}))"
    )
    plan = (("OPEN", ("fridge_1",)), ("RIGHT_GRASP", ("peach_1",)))
    return BehaviorRecord(
        TASK_ID,
        "making_a_mess",
        0,
        "Nowhere_0_int",
        "Make a mess.",
        objects,
        parse_problem(text),
        plan,
        options,
    )


def make_task(goal: str = GOAL) -> BehaviorTask:
    return build_task(make_record(goal), EVIDENCE)


def parse_actions(state: State, *steps: str) -> list[Action]:
    """Return ground actions from steps such as ``RIGHT_GRASP rag_1``."""
    words = (step.split() for step in steps)
    return [Action(name, tuple(state.scene.index[a] for a in arguments)) for name, *arguments in words]
