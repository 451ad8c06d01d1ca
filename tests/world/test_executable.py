from __future__ import annotations

from itertools import product

from hypothesis import given

from eai.world.executable import compile_argument_finder
from world import toy
from world.random_domains import Case, cases


def no_limit() -> bool:
    return False


@given(cases())
def test_exactly_the_arguments_without_a_failing_check_are_found(case: Case) -> None:
    objects = [2, 0, 1]
    for operator in case.domain.operators:
        compiled = case.domain.compiled_operators[operator.name]
        assert list(
            case.domain.argument_finder_by_operator[operator.name](case.initial, objects, no_limit)
        ) == [
            arguments
            for arguments in product(objects, repeat=operator.arity)
            if compiled.is_possible(case.initial, compiled.bind(case.initial, arguments))
        ]


def test_arguments_are_searched_among_the_given_objects_only() -> None:
    start = toy.initial()
    hall, shed = (start.scene.index[name] for name in ("hall", "shed"))
    go = compile_argument_finder(toy.GO, toy.DOMAIN.vocabulary)
    assert list(go(start, [hall, shed], no_limit)) == [(shed,)]
    assert list(go(start, [hall], no_limit)) == []
