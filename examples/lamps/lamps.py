"""A world of one's own: a robot that switches lamps on and packs boxes."""

from eai import Benchmark, given, make_task
from eai.world import (
    AGENT,
    ANYTHING,
    Add,
    Constant,
    Delete,
    Domain,
    Exists,
    ForAll,
    Operator,
    Predicate,
    Scene,
    Variable,
    Vocabulary,
    WorldObject,
    additional,
    affordance,
    is_a,
    missing,
)  # fmt: skip

x, y, lamp = Variable("x"), Variable("y"), Variable("l", "lamp")
at, inside, holds = Predicate("at", 2), Predicate("inside", 2), Predicate("holds", 2)
lit, open_ = Predicate("lit", 1), Predicate("open", 1)

near = missing(at(AGENT, x), "the robot is not at {x}")
free = missing(~Exists(y, holds(AGENT, y)), "the robot's hand is full")

go = (additional(~at(AGENT, x), "the robot is at {x} already"),)
press = (affordance(is_a(x, "lamp"), "{x} is no lamp"), additional(~lit(x), "{x} is lit already"), near)
uncover = (affordance(is_a(x, "box"), "{x} is no box"), additional(~open_(x), "{x} is open"), near, free)
take = (affordance(is_a(x, "ball"), "{x} cannot be taken"), near, free)
put = (
    affordance(is_a(y, "box"), "{y} is no box"),
    missing(holds(AGENT, x), "the robot does not hold {x}"),
    missing(at(AGENT, y), "the robot is not at {y}"),
    missing(open_(y), "{y} is closed"),
)
operators = (
    Operator("GO", (x,), go, (Delete(at(AGENT, ANYTHING)), Add(at(AGENT, x)))),
    Operator("PRESS", (x,), press, (Add(lit(x)),)),
    Operator("OPEN", (x,), uncover, (Add(open_(x)),)),
    Operator("TAKE", (x,), take, (Add(holds(AGENT, x)), Delete(inside(x, ANYTHING)))),
    Operator("PUT", (x, y), put, (Delete(holds(AGENT, x)), Add(inside(x, y)))),
)
domain = Domain("lamps", Vocabulary((at, inside, holds, lit, open_)), operators)

kinds = {"robot": "robot", "lamp_1": "lamp", "lamp_2": "lamp", "ball": "ball", "box": "box"}
scene = Scene(domain.vocabulary, [WorldObject(name, kind) for name, kind in kinds.items()], agent=0)
start = scene.state([])

lamps = Benchmark(
    "lamps",
    domain,
    given(
        make_task("light", "Switch both lamps on.", start, ForAll(lamp, lit(lamp))),
        make_task("pack", "Put the ball into the box.", start, inside(Constant("ball"), Constant("box"))),
    ),
)
