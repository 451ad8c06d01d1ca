"""An example of an own world: a robot that switches lamps on and packs boxes."""

import eai.world as w
from eai import Benchmark, make_task, use_tasks

x, y = w.Variable("x"), w.Variable("y")
at, inside, holds = w.Predicate("at", 2), w.Predicate("inside", 2), w.Predicate("holds", 2)
lit, is_open = w.Predicate("lit", 1), w.Predicate("is_open", 1)

is_lamp = w.affordance(w.is_a(x, "lamp"), "{x} is no lamp")
is_box = w.affordance(w.is_a(x, "box"), "{x} is no box")
is_ball = w.affordance(w.is_a(x, "ball"), "{x} cannot be taken")
away = w.additional_step(~at(w.AGENT, x), "the robot is at {x} already")
unlit = w.additional_step(~lit(x), "{x} is lit already")
closed = w.additional_step(~is_open(x), "{x} is open already")
near = w.missing_step(at(w.AGENT, x), "the robot is not at {x}")
free = w.missing_step(~w.Exists(y, holds(w.AGENT, y)), "the robot's hand is full")
can_put = (
    w.affordance(w.is_a(y, "box"), "{y} is no box"),
    w.missing_step(holds(w.AGENT, x), "the robot does not hold {x}"),
    w.missing_step(at(w.AGENT, y), "the robot is not at {y}"),
    w.missing_step(is_open(y), "{y} is closed"),
)
operators = (
    w.Operator("GO", (x,), (away,), (w.Delete(at(w.AGENT, w.ANYTHING)), w.Add(at(w.AGENT, x)))),
    w.Operator("PRESS", (x,), (is_lamp, unlit, near), (w.Add(lit(x)),)),
    w.Operator("OPEN", (x,), (is_box, closed, near, free), (w.Add(is_open(x)),)),
    w.Operator("TAKE", (x,), (is_ball, near, free), (w.Add(holds(w.AGENT, x)),)),
    w.Operator("PUT", (x, y), can_put, (w.Delete(holds(w.AGENT, x)), w.Add(inside(x, y)))),
)
domain = w.Domain("lamps", w.Vocabulary((at, inside, holds, lit, is_open)), operators)

kinds = {"robot": "robot", "lamp_1": "lamp", "lamp_2": "lamp", "ball": "ball", "box": "box"}
start = w.Scene(domain.vocabulary, kinds, agent="robot").state([])

tasks = use_tasks(
    make_task("light", "Switch both lamps on.", start, "forall l: lamp. (lit(l))"),
    make_task("pack", "Put the ball into the box.", start, "inside(ball, box)"),
)
lamps = Benchmark("lamps", domain, tasks)
