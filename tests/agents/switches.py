"""A small benchmark for episodes: a robot, two rooms, a box and two lamps, one of them shut in the box."""

from __future__ import annotations

import json
from collections.abc import Sequence

import eai.world as w
from eai import Benchmark, Shaping, Task, make_task, use_tasks
from eai.logic.formula import Occurs, Or

x, y, r = w.Variable("x"), w.Variable("y"), w.Variable("r")
at, inside = w.Predicate("at", 2), w.Predicate("inside", 2)
lit, shut = w.Predicate("lit", 1), w.Predicate("shut", 1)
room = w.Predicate("room", 1, static=True)
beside = w.DefinedPredicate("beside", (x,), w.Exists(r, at(w.AGENT, r) & at(x, r)))

GO = w.Operator(
    "GO",
    (x,),
    (
        w.affordance(room(x), "{x} is no room"),
        w.additional_step(~at(w.AGENT, x), "the robot is in {x} already"),
    ),
    (w.Delete(at(w.AGENT, w.ANYTHING)), w.Add(at(w.AGENT, x))),
)
OPEN = w.Operator(
    "OPEN", (x,), (w.missing_step(beside(x), "the robot is not beside {x}"),), (w.Delete(shut(x)),)
)
PRESS = w.Operator(
    "PRESS",
    (x,),
    (
        w.affordance(w.is_a(x, "lamp"), "{x} is no lamp"),
        w.missing_step(beside(x), "the robot is not beside {x}"),
    ),
    (w.When(lit(x), (w.Delete(lit(x)),)), w.When(~lit(x), (w.Add(lit(x)),))),
)
WAVE = w.Operator("WAVE", (), (), ())
DOMAIN = w.Domain(
    "switches",
    w.Vocabulary((at, inside, lit, shut, room), (beside,)),
    (GO, OPEN, PRESS, WAVE),
    visible=(beside(x) & ~w.Exists(y, inside(x, y) & shut(y))) | (room(x) & at(w.AGENT, x)),
    landmarks=room(x),
)
KINDS = {"robot": "robot", "hall": "room", "shed": "room", "box": "box", "lamp": "lamp", "torch": "lamp"}
SCENE = w.Scene(DOMAIN.vocabulary, [w.WorldObject(name, kind) for name, kind in KINDS.items()], agent=0)


def initial() -> w.State:
    """Return a state with robot and lamp in the hall, and the torch in the box in the shed."""
    index = SCENE.index
    places = {"robot": "hall", "lamp": "hall", "box": "shed", "torch": "shed"}
    return SCENE.state(
        [
            *[("at", (index[thing], index[place])) for thing, place in places.items()],
            ("inside", (index["torch"], index["box"])),
            ("shut", (index["box"],)),
            ("room", (index["hall"],)),
            ("room", (index["shed"],)),
        ]
    )


def tasks() -> list[Task]:
    lamp, torch, box = w.Constant("lamp"), w.Constant("torch"), w.Constant("box")
    wave_and_press = Or((Occurs("WAVE"), Occurs("GO"))), Occurs("PRESS")
    return [
        make_task("both", "Switch both on.", initial(), lit(lamp), lit(torch)),
        make_task("greet", "Wave or go, then press.", initial(), *wave_and_press, lit(torch)),
        make_task("half", "Switch the lamp on, leave the box shut.", initial(), lit(lamp), shut(box)),
        make_task("done", "Leave the box shut.", initial(), shut(box)),
        make_task("none", "Do as you like.", initial()),
    ]


SWITCHES = Benchmark("switches", DOMAIN, use_tasks(*tasks()))

WON = ("PRESS(lamp)", "GO(shed)", "OPEN(box)", "PRESS(torch)")
"""Commands that win the task ``both``, even in a partial view."""

CASES = (
    ("both", (), (0, 0, 0, 0, 0, 0)),
    ("both", ("PRESS(lamp)",), (0, 1 / 2, 1 / 2, 1 / 2, 1 / 3, 1 / 2)),
    ("both", ("PRESS(lamp)", "PRESS(lamp)"), (0, 0, 0, 0, 1 / 3, 0)),
    ("both", ("PRESS(lamp)", "GO(hall)"), (0, 1 / 2, 1 / 2, 1 / 4, 1 / 3, 1 / 2)),
    ("both", ("PRESS(lamp)", "PRESS(torch)"), (0, 0, 1 / 2, 1 / 4, 2 / 3, 1 / 2)),
    ("both", ("PRESS(lamp)", "GO(hall)", "PRESS(torch)"), (0, 0, 1 / 2, 1 / 6, 2 / 3, 1 / 2)),
    ("both", ("OPEN(box)",), (0, 0, 0, 0, 0, 0)),
    ("both", WON, (1, 1, 1, 1, 1, 1)),
    ("both", ("GO(hall)", *WON), (1, 1, 1, 1 / 2, 1, 1)),
    ("half", ("WAVE()",), (0, 0, 0, 0, 0, 0)),
    ("half", ("PRESS(lamp)",), (1, 1, 1, 1, 1, 1)),
    ("half", ("GO(shed)", "OPEN(box)"), (0, 0, 0, 0, 0, 0)),
    ("greet", ("PRESS(lamp)", "WAVE()"), (0, 1 / 3, 1 / 3, 1 / 3, 0, 0)),
)
"""A task, actions until one fails or all goals are reached, and the values of these by each `eai.Shaping`.

Every interface to the reward must pay these values, those of the packages too.
"""

CASES_BY_SHAPING = [
    (task, actions, shaping, worth)
    for task, actions, by_shaping in CASES
    for shaping, worth in zip(Shaping, by_shaping, strict=True)
]


def reference(task_id: str) -> str:
    return f"agents.switches:SWITCHES/action_sequencing/{task_id}"


def as_plan(commands: Sequence[str]) -> str:
    steps = [command.rstrip(")").split("(") for command in commands]
    return json.dumps([{"action": name, "object": [thing] if thing else []} for name, thing in steps])
