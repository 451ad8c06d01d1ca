"""Tests that short texts of prompts state the facts and rules of the long texts, and keep other lines."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.tasks.prompts.short import (
    explain_symbols_in_short_fact_list,
    merge_lines_of_similar_facts,
    merge_lines_of_similar_objects,
    shorten_predicate_list,
    shorten_rules,
)
from eai.tasks.rules import explain_rule_notation
from tasks.prompts.long_form import write_long_form

NAMES = ("jar_0", "jar_1", "jar_2", "jar_3", "rag.7", "hall", "b2c")
OBJECTS = "\n".join(f"{name} [thing]: -" for name in NAMES)
PAIRS = st.lists(st.tuples(st.sampled_from(NAMES), st.sampled_from(NAMES)), unique=True)


@given(st.lists(st.sampled_from(NAMES), unique=True), PAIRS)
def test_short_facts_are_read_as_the_facts_themselves(
    states: list[str], relations: list[tuple[str, str]]
) -> None:
    facts = [*[f"clean({name})" for name in states], *[f"near({a}, {b})" for a, b in relations]]
    short = merge_lines_of_similar_facts("\n".join(facts), OBJECTS)
    question = f"{merge_lines_of_similar_objects(OBJECTS)}\n\nFacts:\n{short}\n\nGoals:\n-"
    _, _, rest = write_long_form(question).partition("Initial state:\n")
    read = rest.partition("\n\nGoals:")[0].splitlines()
    assert sorted(filter(None, read)) == sorted(facts)


def test_facts_about_most_objects_name_the_others() -> None:
    facts = "\n".join(f"clean({name})" for name in NAMES[1:])
    assert merge_lines_of_similar_facts(facts, OBJECTS) == "clean(*): all but jar_0"
    assert merge_lines_of_similar_facts(f"clean(jar_0)\n{facts}", OBJECTS) == "clean(*): all"


def test_mutual_facts_are_written_once() -> None:
    facts = "near(jar_0, hall)\nnear(hall, jar_0)\nnear(rag.7, hall)"
    lines = merge_lines_of_similar_facts(facts, OBJECTS).splitlines()
    assert lines == ["near(rag.7, hall)", "near(jar_0, hall) both ways"]
    assert explain_symbols_in_short_fact_list("\n".join(lines)) == ' "both ways" adds p(b, a) to p(a, b).'


@pytest.mark.parametrize("text", ["-", "What holds is in the picture alone.", "not a fact (at all)"])
def test_other_lines_stay_unchanged(text: str) -> None:
    assert merge_lines_of_similar_facts(text, OBJECTS) == text
    assert merge_lines_of_similar_objects(text) == text
    assert shorten_predicate_list(f"lit(x): a lamp\n{text}") == f"lit(x): a lamp\n{text}"


def test_kinds_are_left_out_only_if_the_name_states_them() -> None:
    listed = "sink_82 [sink]: -\nrag_0 [rag.n.01]: wet\nloc1 [loc1]: -\ncup.3 [cup]: -"
    assert merge_lines_of_similar_objects(listed) == "sink_82, cup.3\nrag_0 [rag.n.01]: wet\nloc1 [loc1]"


def test_a_rule_is_one_line_with_all_conditions_and_changes_in_order() -> None:
    rules = """GO(x, y): walk
  requires: is_a(x, room); at(x); not (wet(y) or far(x, y))
  needed only if: not at(y)
  becomes false: at(x), seen(x, y)
  for each z with near(z, x):
    if lit(z):
      becomes true: seen(z, y)
  becomes true: at(y)
WAIT(): pause
far(x, y) means: not near(x, y)"""
    explained = f"{explain_rule_notation(rules)}\n{rules}"
    _, go, wait, far = shorten_rules(explained).splitlines()
    assert go == (
        "GO(x:room, y) walk: at(x); not (wet(y) or far(x, y)) [not at(y)] -> not at(x), not seen(x, y), "
        "for each z with near(z, x) {if lit(z) {seen(z, y)}}, at(y)"
    )
    assert (wait, far) == ("WAIT(): pause", "far(x, y) means: not near(x, y)")


def test_reasons_of_failures_stay_words() -> None:
    rules = "OPEN(x): open it\n  impossible where: x is stuck\n  needless where: x is open"
    assert shorten_rules(rules) == "OPEN(x) open it: impossible where: x is stuck; needless where: x is open"
