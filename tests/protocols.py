"""The installed protocols, for tests that run under each of them."""

from __future__ import annotations

import pytest

from eai.abilities.protocol import Protocol, find_protocol_entry_points

PROTOCOLS = (Protocol.STRICT, *map(Protocol, find_protocol_entry_points()))
EACH_PROTOCOL = pytest.mark.parametrize("protocol", PROTOCOLS, ids=str)
