from __future__ import annotations

from collections.abc import Callable

import pytest

from eai.errors import DomainError
from eai.logic.formula import Variable
from eai.world.derived import Computed
from eai.world.domain import Domain
from eai.world.operator import Operator
from eai.world.vocabulary import Predicate, Vocabulary

P, Q = Predicate("P", 1), Predicate("Q", 2)


@pytest.mark.parametrize(
    ("declare", "message"),
    [
        (lambda: Vocabulary((P, P)), "predicate P is declared twice"),
        (lambda: Vocabulary((Predicate("R", 3),)), "predicate R: arity 3"),
        (
            lambda: Vocabulary((P,), (Computed("d", 1, lambda state, objects: True, reads=("Q",)),)),
            "d reads Q, which is not declared",
        ),
        (lambda: Q(Variable("x")), "Q takes 2 arguments, not 1"),
        (
            lambda: Domain("d", Vocabulary((P,)), (Operator("A", (), (), ()), Operator("A", (), (), ()))),
            "operator A is declared twice",
        ),
    ],
)
def test_a_declaration_that_contradicts_itself_is_an_error(
    declare: Callable[[], object], message: str
) -> None:
    with pytest.raises(DomainError, match=message):
        declare()
