from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.tasks.short_lists import (
    expand_shortened_lists,
    join_names_with_number_ranges,
    write_similar_facts_on_one_line,
)
from eai.world.state import Fact

NAMES = (
    "jar_0",
    "jar_1",
    "jar_2",
    "jar_3",
    "jar_07",
    "jar_08",
    "jar_9",
    "hall",
    "b2c",
    "loc1-1",
    "loc1-2",
    "7",
)


def write(predicate: str, names: object) -> str:
    return f"{predicate}({', '.join(names)})"  # type: ignore[call-overload]


def test_facts_that_differ_in_one_name_share_a_line() -> None:
    facts = [
        *(Fact("clean", (i,)) for i in (0, 1, 2, 7)),
        *(Fact("in", (i, 7)) for i in (0, 1)),
        *(Fact("in", (8, i)) for i in (4, 5)),
        Fact("in", (3, 8)),
        Fact("between", (0, 1, 7)),
        Fact("between", (2, 1, 7)),
        Fact("raining", ()),
    ]
    assert [*write_similar_facts_on_one_line(facts, NAMES, write)] == [
        "clean(*): jar_0..2, hall",
        "in(*, hall): jar_0, jar_1",
        "in(b2c, *): jar_07, jar_08",
        "in(jar_3, b2c)",
        "between(*, jar_1, hall): jar_0, jar_2",
        "raining()",
    ]


@pytest.mark.parametrize("stem", ["cup ", "cup)", "(cup", "cup,"])
def test_names_that_no_range_can_be_read_with_are_listed(stem: str) -> None:
    names = [f"{stem}{number}" for number in (1, 2, 3)]
    assert join_names_with_number_ranges(names) == ", ".join(names)


@given(st.lists(st.integers(0, len(NAMES) - 1)))
def test_short_lists_of_names_can_be_spelled_out(chosen: list[int]) -> None:
    names = [NAMES[i] for i in chosen]
    assert expand_shortened_lists(join_names_with_number_ranges(names)) == ", ".join(names)


arguments = st.integers(0, len(NAMES) - 1)
facts = st.one_of(
    st.builds(Fact, st.just("raining"), st.just(())),
    st.builds(Fact, st.sampled_from(["clean", "in"]), st.tuples(arguments)),
    st.builds(Fact, st.sampled_from(["on", "by"]), st.tuples(arguments, arguments)),
    st.builds(Fact, st.just("between"), st.tuples(arguments, arguments, arguments)),
)


@given(st.lists(facts, unique=True), st.sampled_from(["", "+ ", "- "]))
def test_short_lists_of_facts_can_be_spelled_out(chosen: list[Fact], sign: str) -> None:
    chosen = sorted(chosen, key=lambda fact: fact.predicate)
    lines = [f"{sign}{line}" for line in write_similar_facts_on_one_line(chosen, NAMES, write)]
    told = expand_shortened_lists("\n".join(lines)).splitlines()
    assert sorted(told) == sorted(
        f"{sign}{write(fact.predicate, [NAMES[i] for i in fact.arguments])}" for fact in chosen
    )


@pytest.mark.parametrize("name", ["jar..3", "jar_0..999999999", f"jar_0..{'9' * 5000}"])
def test_a_name_that_looks_like_a_range_is_not_spelled_out(name: str) -> None:
    assert expand_shortened_lists(f"clean({name})") == f"clean({name})"


def test_objects_of_a_kind_are_spelled_out() -> None:
    text = "Objects [kind]: properties\njar_0..2, hall [thing]: OPEN, CLEAN\nlamp [lamp]: -\n\nNow:\n-"
    told = "Objects [kind]: properties\njar_0 [thing]: OPEN, CLEAN\njar_1 [thing]: OPEN, CLEAN\n"
    told += "jar_2 [thing]: OPEN, CLEAN\nhall [thing]: OPEN, CLEAN\nlamp [lamp]: -\n\nNow:\n-"
    assert expand_shortened_lists(text) == told
