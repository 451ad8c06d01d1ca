"""VirtualHome subgoal decomposition: our speed as a ratio to the reference's (see `suites`)."""

from __future__ import annotations

import sys

from eai.abilities.protocol import Ability
from suites import Limit, main

LIMIT = Limit(Ability.SUBGOAL_DECOMPOSITION, sample=30, ratio=8_000.0)

if __name__ == "__main__":
    sys.exit(main(LIMIT, __doc__))
