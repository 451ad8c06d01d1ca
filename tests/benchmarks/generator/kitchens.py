"""Small kitchens for tests of scenes of generated tasks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from benchmarks.generator.worlds import NOTHING_IS_USUAL
from eai.benchmarks.generator.usual_goals import LiteralPattern, UsualGoalsOfDataSet
from eai.tasks.goal_text import make_task
from eai.tasks.task import Task
from eai.world import Predicate, Scene, Vocabulary, WorldObject
from eai.world.state import Fact

VOCABULARY = Vocabulary(
    (
        Predicate("on", 2),
        Predicate("near", 2),
        Predicate("part_of", 2, static=True),
        Predicate("clean", 1),
        Predicate("robot_here", 1),
        Predicate("night", 0),
    )
)
ON_TABLE = LiteralPattern("on", ("cup", "table"), True)
KITCHEN: dict[str, Any] = {
    "patterns": {("on", True): {ON_TABLE: 1.0}},
    "taken_categories": frozenset({"cup", "plate"}),
    "place_relations": ("on",),
    "part_relations": ("part_of",),
}


def usual(**changes: Any) -> UsualGoalsOfDataSet:
    return replace(NOTHING_IS_USUAL, **{**KITCHEN, **changes})


def task(things: Sequence[str], *facts: tuple[str, ...], relevant: Sequence[str] = ()) -> Task:
    """Return a task. Names of its objects begin with their category: ``cup.1``. The agent is ``me.0``."""
    objects = [WorldObject(name, name.partition(".")[0]) for name in things]
    scene = Scene(VOCABULARY, objects, things.index("me.0") if "me.0" in things else None)
    state = scene.state([Fact(name, tuple([things.index(each) for each in about])) for name, *about in facts])
    made = make_task("t", "-", state)
    return replace(made, relevant=tuple([things.index(name) for name in relevant or things]))


def told(facts: Sequence[Fact], scene: Scene) -> set[str]:
    return {" ".join([name, *(scene.objects[i].name for i in about)]) for name, about in facts}
