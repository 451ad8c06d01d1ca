from __future__ import annotations

from collections.abc import Callable

import pytest

from eai.base.errors import DomainError
from eai.logic.formula import Atom, Constant, Variable
from eai.world.derived import ComputedPredicate
from eai.world.state import Scene
from eai.world.vocabulary import Predicate, Vocabulary

DERIVED = ComputedPredicate("d", 1, lambda state, objects: True, reads=())
P, Q = Predicate("P", 1), Predicate("Q", 2)


@pytest.mark.parametrize(
    ("declare", "message"),
    [
        (lambda: Vocabulary((P, P)), "predicate P is declared twice"),
        (lambda: Vocabulary((Predicate("R", -1),)), "predicate R: arity -1 is negative"),
        (
            lambda: Vocabulary((P,), (ComputedPredicate("d", 1, lambda state, objects: True, reads=("Q",)),)),
            "d reads Q, which is not declared",
        ),
        (lambda: Vocabulary((P,), parents={"a": "b", "b": "a"}), "parents: the kind a contains itself"),
        (lambda: Vocabulary((P,), parents={"c": "a", "a": "a"}), "parents: the kind a contains itself"),
        (lambda: Q(Variable("x")), "Q takes 2 arguments, not 1"),
        (lambda: Vocabulary(P), r"^predicates: expected a tuple; write .* with a comma, \(x,\)$"),
        (lambda: Vocabulary(("P",)), "^predicates: expected Predicate, found str$"),
        (
            lambda: Vocabulary((P,), (DERIVED)),
            "^derived predicates: expected a tuple; write a tuple of one value ",
        ),
        (lambda: Vocabulary((P,), 3), "^derived predicates: expected a tuple of DerivedPredicate, found int"),
    ],
)
def test_a_declaration_that_contradicts_itself_is_an_error(
    declare: Callable[[], object], message: str
) -> None:
    with pytest.raises(DomainError, match=message):
        declare()


def test_a_predicate_is_visible_and_changeable_by_default() -> None:
    assert (P.static, P.visible, P.single) == (False, True, False)


def test_a_term_may_be_the_name_of_an_object() -> None:
    assert Q("a", Variable("x")) == Atom("Q", (Constant("a"), Variable("x")))


def test_an_object_belongs_to_all_kinds_that_contain_its_kind() -> None:
    vocabulary = Vocabulary((P,), parents={"cup": "vessel", "vessel": "thing"})
    scene = Scene(vocabulary, {"mug": "cup", "pot": "vessel", "door": "way"})
    assert vocabulary.list_kind_with_ancestors("cup") == ("cup", "vessel", "thing")
    assert [scene.names_of_category(kind) for kind in ("cup", "vessel", "thing", "way")] == [
        ("mug",),
        ("mug", "pot"),
        ("mug", "pot"),
        ("door",),
    ]
    assert [*scene.object_mask_by_kind] == ["cup", "vessel", "thing", "way"]
