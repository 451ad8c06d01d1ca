"""Whole-data sweeps: the default set runs one representative of each, `make test-all` and CI run all."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest
from hypothesis import settings

sweep = pytest.mark.sweep

FEW, THOROUGH = 30, 100
"""How many examples Hypothesis tries of a property, in the default set and where all is tested."""


def swept(*values: Any) -> list[Any]:
    """Values of a parameter that the default set leaves out; several parameters are a tuple."""
    return [pytest.param(*(each if isinstance(each, tuple) else (each,)), marks=sweep) for each in values]


def first_of(values: Iterable[Any]) -> list[Any]:
    """The values of a parameter, of which the default set has the first alone."""
    first, *rest = values
    return [first, *swept(*rest)]


def every(step: int) -> pytest.MarkDecorator:
    """Gives a test the parameter `every`: the step in which the default set goes through the data, or 1."""
    return pytest.mark.parametrize("every", [step, *swept(1)])


def examples(number: int) -> int:
    """So many examples of a property where all is tested; in the default set a share of them."""
    return number * settings().max_examples // THOROUGH
