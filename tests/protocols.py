"""The installed protocols, for tests that run under each of them."""

from __future__ import annotations

import pytest

from eai.abilities.protocol import Protocol, find_protocols

PROTOCOLS = (Protocol.STRICT, *map(Protocol, find_protocols()))
EACH_PROTOCOL = pytest.mark.parametrize("protocol", PROTOCOLS, ids=str)
