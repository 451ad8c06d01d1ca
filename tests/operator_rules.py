"""The rules for operators by protocol, with a planner of the test's own."""

from __future__ import annotations

from eai.abilities.protocol import Protocol
from eai.abilities.transition_modeling.judgement import Rules
from eai.abilities.transition_modeling.rules import PaperRules
from eai.pddl.planning import PddlPlanner
from eai.reference.operator_rules import ReferenceRules


def rules_of(protocol: Protocol, planner: PddlPlanner | None) -> Rules:
    """Fresh rules."""
    kind = ReferenceRules if protocol is Protocol.EAI_1_0_5 else PaperRules
    return kind.with_planner(planner)
