"""Frozen values are copied and pickled in every protocol."""

import copy
import pickle
from collections.abc import Callable
from dataclasses import FrozenInstanceError, fields
from typing import Any

import pytest

from eai.logic.formula import And, Atom, Constant, Exactly, Formula, ForPairs, Not, Variable
from eai.world.action import Fault
from eai.world.effect import Add, When
from eai.world.fault import FaultKind
from eai.world.operator import Check, Operator
from eai.world.state import WorldObject
from eai.world.vocabulary import Predicate

X = Variable("x", "cup")
ON: Formula = And((Atom("on", (X, Constant("table_1"))), Not(Exactly(2, X, Atom("full", (X,))))))
CHECK = Check(ON, FaultKind.MISSING_STEP, "{x} is not on it")
VALUES: tuple[Any, ...] = (
    X,
    ON,
    ForPairs(X, Variable("y", "lid"), ON, 3),
    Predicate("on", 2),
    WorldObject("cup_1", "cup"),
    CHECK,
    Operator("take", (X,), (CHECK,), (When(ON, (Add(Atom("held", (X,))),)),)),
    Fault(FaultKind.WRONG_ORDER, CHECK, 3),
)

COPIERS: tuple[Callable[[Any], Any], ...] = (
    copy.copy,
    copy.deepcopy,
    lambda value: pickle.loads(pickle.dumps(value)),  # noqa: S301 - its own bytes
    lambda value: pickle.loads(pickle.dumps(value, protocol=0)),  # noqa: S301 - its own bytes
)


@pytest.mark.parametrize("value", VALUES, ids=lambda value: type(value).__name__)
@pytest.mark.parametrize("copy_value", COPIERS, ids=["copy", "deepcopy", "pickle", "oldest pickle"])
def test_a_copied_or_pickled_value_is_equal_and_frozen(value: Any, copy_value: Callable[[Any], Any]) -> None:
    made = copy_value(value)
    assert made == value
    assert type(made) is type(value)
    assert hash(made) == hash(value)
    with pytest.raises(FrozenInstanceError):
        setattr(made, fields(made)[0].name, None)
