"""The executed steps, as the semantics of temporal formulas asks for them: objects go by their names."""

from __future__ import annotations

from collections.abc import Sequence

from eai.logic.formula import Atom, Variable
from eai.logic.trace import TakenAction, Trace
from eai.world.execution import Trajectory
from eai.world.reading import Readings
from eai.world.state import Scene, State


def timeline(trajectory: Trajectory) -> Trace:
    """The states of a trajectory and the actions between them."""
    scene = trajectory.states[0].scene
    atoms = _Atoms(scene)
    actions = [
        TakenAction(a.operator, tuple([scene.objects[i].name for i in a.arguments]))
        for a in trajectory.executed
    ]
    return Trace([_Seen(state, atoms) for state in trajectory.states], actions)


class _Atoms:
    """The atoms of a scene, stored and derived."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._readings = Readings(scene.vocabulary)
        self._atoms: dict[str, Atom] = {}

    def holds(self, state: State, predicate: str, arguments: tuple[str, ...]) -> bool:
        index, vocabulary = self.scene.index, self.scene.vocabulary
        if vocabulary.arity(predicate) != len(arguments) or any(name not in index for name in arguments):
            return False
        things = [index[name] for name in arguments]
        if vocabulary.stored(predicate) is not None:
            return state.has(predicate, *things)
        names = [f"argument {i}" for i in range(len(things))]
        if predicate not in self._atoms:
            self._atoms[predicate] = Atom(predicate, tuple([Variable(name) for name in names]))
        return self._readings.holds(self._atoms[predicate], dict(zip(names, things, strict=True)), state)


class _Seen:
    """One state, as a formula asks for it."""

    __slots__ = ("_atoms", "_state")

    def __init__(self, state: State, atoms: _Atoms) -> None:
        self._state = state
        self._atoms = atoms

    def holds(self, predicate: str, arguments: tuple[str, ...]) -> bool:
        """Whether an atom is true."""
        return self._atoms.holds(self._state, predicate, arguments)

    def objects(self, category: str | None) -> Sequence[str]:
        """The objects of a category, in the order of the scene."""
        return self._atoms.scene.named(category)
