"""Records are group_pairs by the ids of checks, so an id stays when the reason is reworded."""

from __future__ import annotations

from pathlib import Path

import pytest

from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.world.domain import Domain
from eai.world.operator import Check, missing_step
from eai.world.vocabulary import Predicate

DOMAINS = (
    virtualhome.make_domain_with_checks_in_paper_order(),
    behavior.make_domain_with_checks_in_paper_order(),
)
KNOWN = Path(__file__).with_name("checks.txt").read_text(encoding="utf-8").split()


def list_checks(domain: Domain) -> list[Check]:
    return [
        check
        for operator in domain.operators
        for check in (
            *operator.checks,
            *(check for option in operator.alternatives for check in option.checks),
        )
    ]


def test_the_ids_of_checks_equal_the_listed_ids() -> None:
    ids = {f"{domain.name}/{check.id}" for domain in DOMAINS for check in list_checks(domain)}
    reworded = "a reworded check keeps its id (Check.id); list new ids in checks.txt"
    assert sorted(ids) == KNOWN, reworded


@pytest.mark.parametrize("domain", DOMAINS, ids=lambda domain: domain.name)
def test_checks_with_one_id_have_one_reason_except_for_the_objects(domain: Domain) -> None:
    reasons: dict[str, set[str]] = {}
    for check in list_checks(domain):
        words = check.reason.replace("{y}", "{x}")
        reasons.setdefault(check.id, set()).add(words)
    assert [name for name, words in reasons.items() if len(words) > 1] == []


def test_an_id_is_given_or_made_from_the_words_of_the_reason() -> None:
    ready = Predicate("ready", 0)()
    check = missing_step(ready, "{x}'s lid is not on {y}, nor near {x}")
    assert (check.id, check.mentioned_parameters) == ("s_lid_is_not_on_nor_near", ("x", "y"))
    assert Check(ready, check.fault, "the lid is off", id="lid_off").id == "lid_off"
