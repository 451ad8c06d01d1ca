"""A small world: a robot goes to lamps, lights them with a match, and trims wicks with whatever cuts."""

from __future__ import annotations

from dataclasses import replace

import eai.world as w
from eai import Benchmark, Task, make_task, use_tasks
from eai.logic.formula import Exists, ForAll, Occurs
from eai.tasks.task import goal
from eai.world.action import Action

X, Y = w.Variable("x"), w.Variable("y")
AT, LIT, TRIMMED = w.Predicate("at", 2), w.Predicate("lit", 1), w.Predicate("trimmed", 1)
CUTS, NEAR = w.Predicate("cuts", 1, static=True), w.Predicate("near", 2)
GO = w.Operator("GO", (X,), (), (w.Delete(AT(w.AGENT, w.ANYTHING)), w.Add(AT(w.AGENT, X))))
LIGHT = w.Operator(
    "LIGHT", (X,), (w.missing_step(AT(w.AGENT, X), "the robot is not at {x}"),), (w.Add(LIT(X)),)
)
DOUSE = w.Operator("DOUSE", (X,), (), (w.Delete(LIT(X)),))
TRIM = w.Operator(
    "TRIM", (X,), (w.missing_step(Exists(Y, CUTS(Y)), "there is nothing to cut with"),), (w.Add(TRIMMED(X)),)
)
DOMAIN = w.Domain("lamps", w.Vocabulary((AT, LIT, TRIMMED, CUTS, NEAR)), (GO, LIGHT, DOUSE, TRIM))


def lamp_task() -> Task:
    """Two lamps and a knife: all lamps shall be lit; a plan lights one, trims it, and goes to the other."""
    things = ("robot", "lamp_1", "lamp_2", "knife")
    objects = [w.WorldObject(name, name.partition("_")[0]) for name in things]
    scene = w.Scene(DOMAIN.vocabulary, objects, agent=0)
    initial = scene.state([("at", (0, 3)), ("lit", (2,)), ("cuts", (3,))])
    every = w.Variable("x", "lamp")
    task = make_task("1", "Light all the lamps", initial, ForAll(every, LIT(w.Variable("x"))), title="Lamps")
    script = tuple(
        Action(name, (index,))
        for name, index in (("GO", 1), ("LIGHT", 1), ("DOUSE", 2), ("GO", 2), ("LIGHT", 2), ("TRIM", 1))
    )
    return replace(task, goals=(*task.goals, goal(Occurs("LIGHT"))), script=script)


def lamps() -> Benchmark:
    """The benchmark with that one task."""
    return Benchmark("lamps", DOMAIN, use_tasks(lamp_task()))
