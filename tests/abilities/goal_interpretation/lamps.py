"""A small domain of lamps and boxes, for the default notation of goals."""

from __future__ import annotations

from eai.logic.formula import Atom, Constant, Exists, ForAll, Formula, Not, Occurs, Or, Variable
from eai.tasks.task import Goal, GoalKind, Task
from eai.world.derived import DefinedPredicate
from eai.world.domain import Domain
from eai.world.operator import Operator
from eai.world.state import Scene, WorldObject
from eai.world.vocabulary import Predicate, Vocabulary

lit = Predicate("lit", 1)
opened = Predicate("open", 1)
inside = Predicate("inside", 2)
heavy = Predicate("heavy", 1, static=True)
memory = Predicate("memory", 1, visible=False)
x, y, z = Variable("x"), Variable("y"), Variable("z")
together = DefinedPredicate("together", (x, y), Exists(z, inside(x, z) & inside(y, z)))

VOCABULARY = Vocabulary((lit, opened, inside, heavy, memory), (together,))
DOMAIN = Domain("lamps", VOCABULARY, (Operator("PRESS", (x,), (), ()), Operator("OPEN", (x,), (), ())))
OBJECTS = ("lamp_0", "lamp_1", "box_0", "box_1", "ball_0")


def atom(predicate: str, *names: str) -> Atom:
    return Atom(predicate, tuple(map(Constant, names)))


GOALS: tuple[Goal, ...] = (
    Goal(GoalKind.STATE, ForAll(Variable("l", "lamp"), Atom("lit", (Variable("l"),)))),
    Goal(GoalKind.STATE, Not(atom("open", "box_0"))),
    Goal(
        GoalKind.RELATION,
        Exists(Variable("b", "box"), Atom("inside", (Constant("ball_0"), Variable("b")))),
    ),
    Goal(GoalKind.ACTION, Or((Occurs("PRESS"), Occurs("OPEN")))),
)


def make_task(*formulas: Formula) -> Task:
    """Return a task in a room of five objects, with these goals or with `GOALS`."""
    scene = Scene(VOCABULARY, [WorldObject(name, name.partition("_")[0]) for name in OBJECTS])
    goals = tuple(Goal(GoalKind.STATE, formula) for formula in formulas) or GOALS
    return Task(
        id="1",
        title="Light",
        instruction="Light all lamps.",
        initial=scene.state(()),
        goals=goals,
        relevant=tuple(range(len(OBJECTS))),
    )
