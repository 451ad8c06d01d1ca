"""State formulas read on demand: compiled once each, for whatever variables are free in them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeAlias

import eai.logic.formula as f
from eai.logic.traversal import free_variables
from eai.world.condition import Conditions
from eai.world.frame import UNBOUND, Extension, Frame, Truth
from eai.world.relation import bits
from eai.world.state import State
from eai.world.vocabulary import Vocabulary

Scope: TypeAlias = Mapping[str, int]
"""Object indices by the names of the variables that stand for them."""


class Readings:
    """The compiled formulas of one vocabulary. They are distinguished by identity, so that none is hashed."""

    def __init__(self, vocabulary: Vocabulary) -> None:
        self._vocabulary = vocabulary
        self._truths: dict[int, tuple[f.Formula, tuple[str, ...], Frame, Truth]] = {}
        self._extensions: dict[tuple[int, str], tuple[f.Formula, tuple[str, ...], Frame, Extension]] = {}

    def names(self, formula: f.Formula) -> tuple[str, ...]:
        """The names of the free variables of a formula, in alphabetical order."""
        return self._read(formula)[1]

    def holds(self, formula: f.Formula, scope: Scope, state: State) -> bool:
        """Whether a formula holds in a state, its free variables standing for the objects in ``scope``."""
        _, names, frame, truth = self._truths.get(id(formula)) or self._read(formula)
        return truth(state, frame.bind(state.scene, [scope[name] for name in names]))

    def _read(self, formula: f.Formula) -> tuple[f.Formula, tuple[str, ...], Frame, Truth]:
        found = self._truths.get(id(formula))
        if found is None:
            names = tuple(sorted(free_variables(formula)))
            frame = Frame([f.Variable(name) for name in names])
            truth = Conditions(self._vocabulary, frame).truth(formula)
            found = self._truths[id(formula)] = (formula, names, frame, truth)
        return found

    def witnesses(self, variable: f.Variable, body: f.Formula, scope: Scope, state: State) -> Iterator[int]:
        """The values of a quantified variable for which the body of the quantifier holds."""
        key = (id(body), variable.name)
        found = self._extensions.get(key)
        if found is None:
            names = tuple(sorted(free_variables(body) - {variable.name}))
            frame = Frame([f.Variable(name) for name in (*names, variable.name)])
            conditions = Conditions(self._vocabulary, frame)
            extension = conditions.extension(body, len(names) + 1, frame.scope)
            found = self._extensions[key] = (body, names, frame, extension)
        _, names, frame, extension = found
        binding = frame.bind(state.scene, [*[scope[name] for name in names], UNBOUND])
        return bits(extension(state, binding, state.scene.category(variable.category)))
