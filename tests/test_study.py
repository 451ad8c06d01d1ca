"""The study of the paper's claims is what the tool makes of the answers now."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from eai.abilities.protocol import Ability
from eai.data.store import Store
from oracle import MODELS, read_oracle

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "study.md"
PLACES = (str(ROOT / "tools" / "study"), str(ROOT / "tools"))
MODULES = ("claim", "evidence", "difficulty", "errors", "elsewhere", "printed", "page", "published_scores")


@pytest.fixture(scope="module")
def study() -> Iterator[ModuleType]:
    """The tool, as a module."""
    import importlib.util

    pytest.importorskip("scipy")
    sys.path[:0] = PLACES
    spec = importlib.util.spec_from_file_location("study", ROOT / "tools" / "study" / "__main__.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    yield module
    sys.path[:] = [place for place in sys.path if place not in PLACES]
    for name in MODULES:
        sys.modules.pop(name, None)


def sections(study: ModuleType, evidence: object, keys: str) -> dict[str, str]:
    """The sections of some claims as they come out now."""
    page = sys.modules["page"]
    chosen = [claim for claim in study.CLAIMS if claim.key in keys.split()]
    return {claim.key: "\n".join(page.section(claim, claim.find(evidence))) for claim in chosen}


def test_every_claim_is_on_the_page_once(study: ModuleType) -> None:
    text = PAGE.read_text(encoding="utf-8")
    keys = [claim.key for claim in study.CLAIMS]
    assert len(set(keys)) == len(keys)
    lines = text.splitlines()
    for claim in study.CLAIMS:
        name = f"{claim.key} {claim.title}"
        is_there = lines.count(f"## {name}") == 1 and f"](#{sys.modules['page'].anchor(claim)})" in text
        is_left_out = sum(line.startswith(f"* {name}: takes ") for line in lines) == 1
        assert is_there != is_left_out
        assert is_there or claim.plans


def test_claims_that_need_no_answers_come_out_as_on_the_page(study: ModuleType, data_store: Store) -> None:
    evidence = sys.modules["evidence"].Evidence(study.Source(data_store))
    found = sections(study, evidence, "D1 D2 D3 E1 F1 G1 H1 I1 I2 I3 J1 K1 K2 K3")
    assert len(found) == 14
    text = PAGE.read_text(encoding="utf-8")
    assert [key for key, section in found.items() if section not in text] == []


@pytest.mark.parametrize(
    ("domain", "ability", "keys"),
    [
        ("behavior", Ability.ACTION_SEQUENCING, "A1 A2 A3 A4 A5 A6 A7 A8 A9"),
        ("behavior", Ability.GOAL_INTERPRETATION, "B5 B6"),
        ("virtualhome", Ability.GOAL_INTERPRETATION, "B8"),
    ],
)
def test_the_page_is_current(
    study: ModuleType, data_store: Store, domain: str, ability: Ability, keys: str
) -> None:
    for model in MODELS:
        read_oracle(domain, ability.value, model)
    evidence = study.from_answers(domains=[domain], abilities=[ability])
    found = sections(study, evidence, keys)
    text = PAGE.read_text(encoding="utf-8")
    assert [key for key, section in found.items() if section not in text] == []


def test_without_records_the_page_says_what_is_missing(study: ModuleType, data_store: Store) -> None:
    evidence = sys.modules["evidence"].Evidence(study.Source(data_store))
    text = sys.modules["page"].page_of(study.CLAIMS, evidence)
    assert "## Left out" in text
    assert (
        "* A1 Success falls with the length of the annotated plan: takes BEHAVIOR, action sequencing" in text
    )
