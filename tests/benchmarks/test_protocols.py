"""Protocols are found by name, and the package does without those that are taken out of it."""

from __future__ import annotations

import pytest

from eai.abilities.protocol import Ability, Protocol, registered_protocols
from eai.base.errors import InputError
from eai.benchmarks import protocols
from eai.benchmarks.suite import open_suite


def test_protocols_are_found_by_name() -> None:
    assert [*registered_protocols()] == ["eai-1.0.5"]
    assert isinstance(protocols.implementation_of("eai-1.0.5"), protocols.Implementation)
    assert protocols.implementation_of("eai-1.0.6") is None


def test_a_benchmark_that_a_protocol_does_not_score_is_refused() -> None:
    with pytest.raises(InputError, match=r"virtualhome-rules is not scored under eai-1\.0\.5"):
        open_suite("rules:virtualhome", Ability.ACTION_SEQUENCING, Protocol("eai-1.0.5"))
