"""Protocols are found by name."""

from __future__ import annotations

import pytest

from eai.abilities.protocol import Protocol, find_protocol_entry_points
from eai.benchmarks import protocols


@pytest.mark.parametrize("name", find_protocol_entry_points())
def test_protocols_are_found_by_name(name: str) -> None:
    assert Protocol(name) in Protocol.list_names()
    assert isinstance(protocols.find_implementation(name), protocols.ProtocolImplementation)


def test_a_name_that_is_not_registered_has_no_implementation() -> None:
    assert protocols.find_implementation("no-such-protocol") is None
