"""Options of scoring: the rules, the planner that tests operators in answers, and the content of records."""

from __future__ import annotations

from pydantic import Field

from eai.abilities.protocol import DEFAULT_PROTOCOL, Protocol
from eai.pddl.planning import PlannerChoice
from eai.tasks.options import Options
from eai.tasks.source import ErrataChoice


class ScoringOptions(Options):
    """How answers are scored.

    Attributes:
        protocol: The rules: strict (what the paper says), or the name of a release (its verdicts).
        errata: Known errors of the data: current (strict corrects them or leaves tasks out), or none
            (as published).
        planner: The judge of operators: full (built-in search, then Fast Downward), built_in, fast_downward,
            none, or auto: full where Fast Downward is installed, else built_in.
        planner_seconds: CPU seconds that Fast Downward may take for one problem; the benchmark's limit if not
            given. Records state another limit than the benchmark's.
        planner_memory: MiB of memory for all planners together; all memory of the machine if not given.
        workers: Number of processes.
        explanations: Put a step-by-step explanation into every record.
        allow_missing: Leave tasks without an answer out of all rates; the run is then not ranked.
        look_back: Maximum number of states in the search for the fewest edits that repair a failed plan, or
            for the turn that lost an episode. No search if not given.
    """

    protocol: Protocol = DEFAULT_PROTOCOL
    errata: ErrataChoice = ErrataChoice.CURRENT
    planner: PlannerChoice = PlannerChoice.AUTO
    planner_seconds: int | None = Field(default=None, ge=1)
    planner_memory: int | None = Field(default=None, ge=64)
    workers: int = Field(default=1, ge=1)
    explanations: bool = True
    allow_missing: bool = False
    look_back: int | None = Field(default=None, ge=1)
