"""Gold operators as answers, and the rules for operators by protocol, with a planner of the test's own."""

from __future__ import annotations

from eai.abilities.protocol import Protocol
from eai.abilities.transition_modeling.rules import PaperRules, Rules
from eai.benchmarks.gold_answers import join_operators
from eai.pddl.planning import PddlPlanner
from eai.tasks.operator_task import TransitionTask
from protocols import of_reference


def gold_answer(task: TransitionTask) -> str:
    """The data set's own operators as an answer."""
    return join_operators(task.domain.operators[name].pddl for name in task.operators)


def rules_of(protocol: Protocol, planner: PddlPlanner | None) -> Rules:
    """Fresh rules."""
    is_paper = protocol is Protocol.STRICT
    kind = PaperRules if is_paper else of_reference("operator_rules").ReferenceRules
    return kind(planner)
