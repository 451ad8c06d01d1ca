"""Tests that each kind of error has everything that the package keeps by kind."""

from __future__ import annotations

import pytest

import eai.logic.formula as f
from eai.abilities.declaration import AnswerOutcome
from eai.base.errors import DomainError
from eai.results.plots import OUTCOME_COLORS
from eai.tasks.prompts.template import list_template_names
from eai.world.fault import FAULT_PRECEDENCE, NOT_EXECUTED, FaultKind
from eai.world.operator import Check


@pytest.mark.parametrize("kind", FaultKind)
def test_each_kind_of_error_has_an_outcome_a_colour_and_feedback(kind: FaultKind) -> None:
    assert AnswerOutcome(kind.value) in OUTCOME_COLORS
    assert f"feedback/{kind.value}.txt" in list_template_names()


@pytest.mark.parametrize("kind", FaultKind)
def test_a_tried_step_has_a_precedence_unless_it_slips(kind: FaultKind) -> None:
    assert (kind in FAULT_PRECEDENCE) is (kind not in NOT_EXECUTED and kind is not FaultKind.SLIP)


@pytest.mark.parametrize("kind", [*sorted(NOT_EXECUTED), FaultKind.WRONG_ORDER, FaultKind.SLIP])
def test_no_check_finds_an_error_of_reading_order_or_chance(kind: FaultKind) -> None:
    with pytest.raises(DomainError, match=f"has the fault kind {kind.value}: expected uncategorised"):
        Check(f.TRUE, kind, "too heavy")
