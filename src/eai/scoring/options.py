"""Options of scoring: the rules, the planner that judges operators, and what records hold."""

from __future__ import annotations

from eai.abilities.options import Options, option
from eai.abilities.protocol import DEFAULT_PROTOCOL, Protocol
from eai.pddl.planning import PlannerChoice
from eai.tasks.source import ErrataChoice


class ScoringOptions(Options):
    """How answers are scored."""

    protocol: Protocol = option(
        "The rules: strict (what the paper says), or the name of a release (its verdicts).",
        DEFAULT_PROTOCOL,
    )
    errata: ErrataChoice = option(
        "What is known to be wrong in the data: current (corrected, or left out of all rates, under strict), "
        "or none (as published).",
        ErrataChoice.CURRENT,
    )
    planner: PlannerChoice = option(
        "The judge of operators: full (built-in search, then Fast Downward), built_in, "
        "fast_downward, none, or auto: full where Fast Downward is installed, else built_in.",
        PlannerChoice.AUTO,
    )
    planner_seconds: int | None = option(
        "CPU seconds that Fast Downward may take for one problem (records say so); the "
        "benchmark's if not given.",
        ge=1,
    )
    planner_memory: int | None = option(
        "MiB of memory for all planners at a time; as much as there is if not given.", ge=64
    )
    workers: int = option("Processes.", 1, ge=1)
    explanations: bool = option("Put a step-by-step explanation into every record.", True)
    allow_missing: bool = option(
        "Leave tasks without an answer out of all rates; the run is then not ranked.", False
    )
    look_back: int | None = option(
        "The states of a search for the fewest edits that mend a failed plan, or for the turn that lost an "
        "episode; none if not given.",
        ge=1,
    )
