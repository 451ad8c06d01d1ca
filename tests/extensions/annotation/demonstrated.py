"""A small world with demonstrations, written by hand."""

from __future__ import annotations

from dataclasses import replace

import eai.world as w
from eai.benchmarks.benchmark import Benchmark
from eai.logic.formula import Constant
from eai.tasks.goal_text import make_task
from eai.tasks.source import use_tasks
from eai.tasks.task import Task, goal
from eai.world.action import Action

X, Y = w.Variable("x"), w.Variable("y")
LIT, NEAR, ON = w.Predicate("lit", 1), w.Predicate("near", 2), w.Predicate("on", 2)
BRIGHT, SMALL = w.Predicate("bright", 1, static=True), w.Predicate("small", 1, static=True)
DOMAIN = w.Domain(
    "shelves",
    w.Vocabulary((LIT, NEAR, ON, BRIGHT, SMALL)),
    (
        w.Operator(
            "GO",
            (X,),
            (w.additional_step(~NEAR(w.AGENT, X), "near {x} already"),),
            (w.Delete(NEAR(w.AGENT, w.ANYTHING)), w.Add(NEAR(w.AGENT, X))),
        ),
        w.Operator(
            "LIGHT",
            (X,),
            (w.affordance(BRIGHT(X), "{x} is no light"), w.missing_step(NEAR(w.AGENT, X), "far from {x}")),
            (w.Add(LIT(X)),),
        ),
        w.Operator("PUT", (X, Y), (w.missing_step(NEAR(w.AGENT, Y), "far from {y}"),), (w.Add(ON(X, Y)),)),
    ),
)
THINGS = {
    "robot": ("robot", ()),
    "lamp_1": ("lamp", ("bright",)),
    "lamp_2": ("lamp", ("bright",)),
    "cup": ("cup", ("small",)),
    "jar": ("jar", ("small",)),
    "shelf": ("shelf", ()),
}
SCENE = w.Scene(DOMAIN.vocabulary, [w.WorldObject(name, kind) for name, (kind, _) in THINGS.items()], agent=0)
START = SCENE.state([(name, (index,)) for index, (_, names) in enumerate(THINGS.values()) for name in names])


def shown(name: str, plan: str, *goals: str, title: str = "Tidy up") -> Task:
    """A demonstration: steps with semicolons between; goals as ``lit lamp_1``."""
    words = [step.split() for step in plan.split(";")]
    script = tuple(Action(step[0], tuple(SCENE.index[each] for each in step[1:])) for step in words)
    predicates = {each.name: each for each in (LIT, NEAR, ON)}
    wanted = [predicates[text.split()[0]](*map(Constant, text.split()[1:])) for text in goals]
    return replace(
        make_task(name, "Tidy up.", START, title=title), script=script, goals=tuple(map(goal, wanted))
    )


CUP = shown("cup", "GO shelf; PUT cup shelf", "on cup shelf")
JAR = shown("jar", "GO lamp_1; LIGHT lamp_1; GO shelf; PUT jar shelf", "on jar shelf")
LAMP = shown("lamp", "GO lamp_1; LIGHT lamp_1; GO lamp_2; LIGHT lamp_2", "lit lamp_1")


def shelves() -> Benchmark:
    """The benchmark with three demonstrations."""
    return Benchmark("shelves", DOMAIN, use_tasks(CUP, JAR, LAMP))
