"""A small world: a robot puts a cup into a box and a box onto a table, and lights a lamp."""

from __future__ import annotations

import eai.world as w
from eai import Benchmark, Task, make_task, use_tasks
from eai.studies.perception.scene_graph import SceneGraph, SceneGraphFact, SceneGraphVocabulary

X, Y = w.Variable("x"), w.Variable("y")
HOLDS = w.Predicate("holds", 2)
IN = w.Predicate("in", 2)
ON = w.Predicate("on", 2)
LIT = w.Predicate("lit", 1)
CAN_LIGHT = w.Predicate("can_light", 1, static=True)
free = w.missing_step(~w.Exists(Y, HOLDS(w.AGENT, Y)), "the hand is full")
held = w.missing_step(HOLDS(w.AGENT, X), "{x} is not held")
TAKE = w.Operator(
    "TAKE",
    (X,),
    (free,),
    (w.Delete(IN(X, w.ANYTHING)), w.Delete(ON(X, w.ANYTHING)), w.Add(HOLDS(w.AGENT, X))),
)
PUT_IN = w.Operator("PUT_IN", (X, Y), (held,), (w.Delete(HOLDS(w.AGENT, X)), w.Add(IN(X, Y))))
PUT_ON = w.Operator("PUT_ON", (X, Y), (held,), (w.Delete(HOLDS(w.AGENT, X)), w.Add(ON(X, Y))))
LIGHT = w.Operator("LIGHT", (X,), (w.affordance(CAN_LIGHT(X), "{x} is no lamp"),), (w.Add(LIT(X)),))
DOMAIN = w.Domain("kitchen", w.Vocabulary((HOLDS, IN, ON, LIT, CAN_LIGHT)), (TAKE, PUT_IN, PUT_ON, LIGHT))


def kitchen_task() -> Task:
    """Return a task: light two lamps, and put a cup from a box onto the table."""
    names = ("robot", "cup_1", "box_1", "table_1", "lamp_1", "lamp_2")
    scene = w.Scene(DOMAIN.vocabulary, [w.WorldObject(n, n.partition("_")[0]) for n in names], agent=0)
    facts = [("in", (1, 2)), ("on", (2, 3)), ("lit", (4,)), ("can_light", (4,)), ("can_light", (5,))]
    lamp = w.Variable("x", "lamp")
    goals = w.ForAll(lamp, LIT(X)), ON(w.Constant("cup_1"), w.Constant("table_1"))
    return make_task("1", "Light the lamps and put the cup on the table.", scene.state(facts), *goals)


KITCHEN = Benchmark("kitchen", DOMAIN, use_tasks(kitchen_task()))
WORDS = SceneGraphVocabulary(KITCHEN.observation_wording())
TRUTH = WORDS.make_true_graph(kitchen_task())


def fact(text: str) -> SceneGraphFact:
    """``in cup_1 box_1`` as a fact."""
    predicate, *arguments = text.split()
    return SceneGraphFact(predicate, tuple(arguments))


def seen(*facts: str, objects: tuple[str, ...] = TRUTH.objects) -> SceneGraph:
    """A scene graph with these facts."""
    return SceneGraph(objects, tuple(map(fact, facts)))
