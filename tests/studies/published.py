"""The published answers of nine models, scored and made into tidy tables."""

from __future__ import annotations

from functools import cache

import pytest

from eai.abilities.protocol import Ability, Protocol
from eai.base.store import DataPackStore
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.batch import score_run
from eai.results.options import ScoringOptions
from eai.results.responses import Response, ResponseFile
from eai.results.tidy import TidyTables
from eai.tasks.source import ErrataChoice, Source
from oracle import read_oracle
from protocols import PROTOCOLS

REFERENCE = Protocol("eai-1.0.5")
GPT_4O = "gpt-4o-2024-05-13"


@cache
def tables(
    domain: str,
    ability: Ability,
    models: tuple[str, ...] = (GPT_4O,),
    protocol: Protocol = REFERENCE,
    planner: PlannerChoice = PlannerChoice.NONE,
) -> TidyTables:
    """Return the tables of one suite. Skip the test if its answers or its protocol are not installed."""
    if protocol not in PROTOCOLS:
        pytest.skip(f"the protocol {protocol.value} is not installed")
    made = TidyTables(Source(DataPackStore(), errata=ErrataChoice.NONE))  # features are as published
    suite = open_suite(domain, ability, protocol, source=Source(DataPackStore(), planner=planner))
    for model in models:
        content = read_oracle(domain, ability.value, model)
        rows = content.get("tasks") or content.get("records")
        answers = ResponseFile(
            model,
            tuple(
                Response(
                    row.get("id", row.get("identifier")), row.get("llm_output", row.get("response")) or ""
                )
                for row in rows
            ),
        )
        made.add_records(score_run(suite, answers, {}, ScoringOptions(explanations=True)))
    return made
