"""VirtualHome goal interpretation: our speed as a ratio to the reference's (see `suites`)."""

from __future__ import annotations

import sys

from eai.abilities.protocol import Ability
from suites import Limit, main

LIMIT = Limit(Ability.GOAL_INTERPRETATION, sample=342, ratio=800.0)

if __name__ == "__main__":
    sys.exit(main(LIMIT, __doc__))
