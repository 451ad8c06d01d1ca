from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from eai.world.relation import InitialRelation, Relation, iterate_bits

SIZE = 7
indices = st.integers(0, SIZE - 1)
pairs = st.frozensets(st.tuples(indices, indices))
changes = st.lists(
    st.one_of(
        st.tuples(st.sampled_from(["row", "column"]), indices, st.integers(0, 2**SIZE - 1)),
        st.tuples(st.just("flip"), indices, indices),
    ),
    max_size=12,
)


def changed(relation: Relation, plain: set[tuple[int, int]], change: tuple[str, int, int]) -> Relation:
    """Make one change to a copy of a relation, and to the set of pairs that it is compared with."""
    copy = relation.copy()
    match change:
        case "row", source, mask:
            plain -= {p for p in plain if p[0] == source}
            plain |= {(source, y) for y in iterate_bits(mask)}
            copy.set_row(source, mask)
        case "column", target, mask:
            plain -= {p for p in plain if p[1] == target}
            plain |= {(x, target) for x in iterate_bits(mask)}
            copy.set_column(target, mask)
        case "flip", source, target:
            plain ^= {(source, target)}
            copy.toggle_pair(source, target)
    return copy


@given(pairs, changes)
def test_a_relation_behaves_like_a_set_of_pairs(
    start: frozenset[tuple[int, int]], script: list[tuple[str, int, int]]
) -> None:
    relation, plain = Relation(InitialRelation.from_pairs(SIZE, start)), set(start)
    for change in script:
        relation = changed(relation, plain, change)
    assert list(relation.pairs()) == sorted(plain)
    for mask in (0, 0b1010110, 2**SIZE - 1):
        assert list(relation.pairs(mask)) == [
            (x, y) for x, y in sorted(plain) if mask >> x & 1 and mask >> y & 1
        ]
    assert len(relation) == len(plain)
    for i in range(SIZE):
        assert set(iterate_bits(relation.row(i))) == {y for x, y in plain if x == i}
        assert set(iterate_bits(relation.column(i))) == {x for x, y in plain if y == i}
        assert all(relation.has(i, j) == ((i, j) in plain) for j in range(SIZE))
    assert {x for x, _ in plain} <= set(iterate_bits(relation.sources))
    assert {y for _, y in plain} <= set(iterate_bits(relation.targets))


@given(pairs, changes, changes)
def test_equal_relations_have_the_same_pairs_and_others_list_their_differences(
    start: frozenset[tuple[int, int]], one: list[tuple[str, int, int]], other: list[tuple[str, int, int]]
) -> None:
    base = InitialRelation.from_pairs(SIZE, start)
    left, right = Relation(base), Relation(base)
    left_plain, right_plain = set(start), set(start)
    for change in one:
        left = changed(left, left_plain, change)
    for change in other:
        right = changed(right, right_plain, change)
    assert (left == right) == (left_plain == right_plain)
    assert left != right or hash(left) == hash(right)
    assert left.find_sources_with_changed_targets(right) == sorted({x for x, _ in left_plain ^ right_plain})


def test_a_relation_is_compared_as_it_is_after_its_last_change() -> None:
    start = Relation(InitialRelation.from_pairs(SIZE, [(0, 1)]))
    relation = start.copy()
    assert (relation, hash(relation)) == (start, hash(start))
    relation.toggle_pair(1, 2)
    assert (relation == start, hash(relation) == hash(start)) == (False, False)
    relation.set_column(2, 0)
    assert (relation, hash(relation)) == (start, hash(start))


def test_relations_on_different_matrices_are_never_equal() -> None:
    assert Relation(InitialRelation.from_pairs(SIZE, [])) != Relation(InitialRelation.from_pairs(SIZE, []))


def test_relations_with_equal_hashes_are_distinguished() -> None:
    base = InitialRelation.from_pairs(SIZE, [])
    one, other = Relation(base).copy(), Relation(base).copy()
    one.toggle_pair(0, 2)
    other.toggle_pair(2, 0)
    assert hash(one) == hash(other)
    assert one != other


@given(pairs, changes)
def test_changing_a_copy_does_not_change_the_original(
    start: frozenset[tuple[int, int]], script: list[tuple[str, int, int]]
) -> None:
    relation = Relation(InitialRelation.from_pairs(SIZE, start))
    history, contents = [relation], [set(start)]
    for change in script:
        plain = set(contents[-1])
        history.append(changed(history[-1], plain, change))
        contents.append(plain)
    assert [set(r.pairs()) for r in history] == contents


def test_bits_are_listed_in_ascending_order() -> None:
    assert list(iterate_bits(0b101001)) == [0, 3, 5]
    assert list(iterate_bits(0)) == []
