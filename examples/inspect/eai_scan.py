"""Scanner for Inspect Scout that finds the kinds of error of agents in transcripts of acting.

pip install inspect-scout
scout scan eai_scan.py -T runs/logs
"""

import re
from collections import Counter

from inspect_scout import Reference, Result, Scanner, Transcript, scanner

FAILED = re.compile(r"failed \(([a-z ]+)\): ", re.IGNORECASE)
"""Pattern of an observation's first line that reports an impossible action."""


@scanner(messages="all")
def eai_errors() -> Scanner[Transcript]:
    """Count the impossible actions of an episode by kind of error, with a reference to each."""

    async def scan(transcript: Transcript) -> Result:
        observed = [each for each in transcript.messages if each.role in ("tool", "user")]
        found = [(each.id, FAILED.search(each.text.partition("\n")[0])) for each in observed]
        kinds = [(place, failed[1]) for place, failed in found if failed]
        return Result(
            value=dict(Counter(kind for _, kind in kinds)),
            references=[Reference(type="message", id=place, cite=kind) for place, kind in kinds if place],
        )

    return scan
