"""Marks for sweeps over all data: the default set runs an example of each; `make test-all` and CI run all."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest
from hypothesis import settings

sweep = pytest.mark.sweep

FEW, THOROUGH = 30, 100
"""Numbers of Hypothesis examples of a property: in the default set, and in the full test run."""


def swept(*values: Any) -> list[Any]:
    """Return values of a parameter that the default set leaves out; a tuple holds several parameters."""
    return [pytest.param(*(each if isinstance(each, tuple) else (each,)), marks=sweep) for each in values]


def first_of(values: Iterable[Any]) -> list[Any]:
    """Return the values of a parameter; the default set has only the first."""
    first, *rest = values
    return [first, *swept(*rest)]


def every(step: int) -> pytest.MarkDecorator:
    """Give a test the parameter `every`: a step through the data, which is 1 in the full run."""
    return pytest.mark.parametrize("every", [step, *swept(1)])


def examples(number: int) -> int:
    """Return the number of examples of a property: `number` in the full run, fewer in the default set."""
    return number * settings().max_examples // THOROUGH
