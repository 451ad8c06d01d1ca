"""Made-up tasks in the small flat."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from benchmarks.virtualhome import flat
from eai.benchmarks.virtualhome.predicates import VOCABULARY
from eai.benchmarks.virtualhome.records import GraphDelta, TaskRecord
from eai.benchmarks.virtualhome.tasks import VirtualHomeTask
from eai.logic.formula import Atom, Constant, Occurs, Or
from eai.tasks.task import Goal, GoalKind
from eai.world.state import Scene, WorldObject


def make_task(
    *changes: str,
    goals: Sequence[str] = ("state OPEN fridge.10",),
    final: Iterable[str] | None = None,
    script: Sequence[str] = (),
    relevant: Sequence[str] | None = None,
    more_objects: Sequence[str] = (),
) -> VirtualHomeTask:
    """Return a task in the flat.

    Args:
        changes: changes of the initial facts (``HOLDS_RH character.65 cup.13``, ``-CLOSED fridge.10``).
        goals: ``state OPEN fridge.10``, ``relation ONTOP cup.13 bed.20`` or ``action LOOKAT|WATCH``.
        final: changes from the initial to the annotated final state; if None, all goals hold in it.
        script: the annotated plan (``WALK fridge.10``).
        relevant: the objects that an answer may name without an id, in order; all if None.
        more_objects: further objects, without facts except those in ``changes``.
    """
    objects = [*flat.PROPERTIES, *more_objects]
    scene = Scene(
        VOCABULARY,
        [WorldObject(name, name.rpartition(".")[0]) for name in objects],
        agent=objects.index("character.65"),
    )
    initial = flat.make_state(*changes, over=scene)
    if final is None:
        final = [goal.partition(" ")[2] for goal in goals if not goal.startswith("action")]
    about = objects if relevant is None else relevant
    return VirtualHomeTask(
        id="1_1",
        title="Made up",
        instruction="Do it.",
        initial=initial,
        annotated_final=flat.make_state(*changes, *final, over=scene),
        script=tuple(flat.parse_action(step, scene) for step in script),
        goals=tuple(_parse_goal(text) for text in goals),
        temporal_goal=None,
        relevant=tuple(scene.index[name] for name in about),
        record=_make_record(about),
    )


def _make_record(relevant: Sequence[str]) -> TaskRecord:
    unchanged = GraphDelta((), (), (), (), ())
    ids = tuple(int(name.rpartition(".")[2]) for name in relevant)
    return TaskRecord("1_1", "Made up", "Do it.", (), (), (), (), None, unchanged, unchanged, ids, ())


def _parse_goal(text: str) -> Goal:
    kind, predicate, *names = text.split()
    if kind == GoalKind.ACTION.value:
        return Goal(GoalKind.ACTION, Or(tuple(Occurs(word) for word in predicate.split("|"))))
    return Goal(GoalKind(kind), Atom(predicate, tuple(Constant(name) for name in names)))
