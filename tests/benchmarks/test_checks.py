"""The ids of declared checks, by which records are grouped: they stay as they are when words change."""

from __future__ import annotations

from pathlib import Path

import pytest

from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.world.domain import Domain
from eai.world.operator import Check, missing
from eai.world.vocabulary import Predicate

DOMAINS = (virtualhome.as_meant(), behavior.as_meant())
KNOWN = Path(__file__).with_name("checks.txt").read_text(encoding="utf-8").split()


def checks(domain: Domain) -> list[Check]:
    return [
        check
        for operator in domain.operators
        for check in (*operator.checks, *(check for each in operator.tries for check in each.checks))
    ]


def test_the_ids_are_those_that_records_have() -> None:
    ids = {f"{domain.name}/{check.id}" for domain in DOMAINS for check in checks(domain)}
    reworded = "a check that is worded anew keeps its id (Check.id); new ones are listed in checks.txt"
    assert sorted(ids) == KNOWN, reworded


@pytest.mark.parametrize("domain", DOMAINS, ids=lambda domain: domain.name)
def test_one_id_is_one_reason_up_to_the_objects(domain: Domain) -> None:
    reasons: dict[str, set[str]] = {}
    for check in checks(domain):
        words = check.reason.replace("{y}", "{x}")
        reasons.setdefault(check.id, set()).add(words)
    assert [name for name, words in reasons.items() if len(words) > 1] == []


def test_an_id_is_the_words_without_the_objects_or_what_is_given() -> None:
    ready = Predicate("ready", 0)()
    check = missing(ready, "{x}'s lid is not on {y}, nor near {x}")
    assert (check.id, check.mentioned_parameters) == ("s_lid_is_not_on_nor_near", ("x", "y"))
    assert Check(ready, check.fault, "the lid is off", id="lid_off").id == "lid_off"
