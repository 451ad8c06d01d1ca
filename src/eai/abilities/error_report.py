"""What ended an answer, from the engine's terms to those of verdicts: the same for every ability."""

from __future__ import annotations

from eai.abilities.verdict import ErrorReport
from eai.world.domain import Domain
from eai.world.execution import Action, Fault, names_of
from eai.world.state import Scene

UNKNOWN_ACTION = "unknown_action"
"""The test of names that an action which does not exist fails; the others are those of `MisuseKind`."""


def error_report(fault: Fault, number: int, domain: Domain, action: Action, scene: Scene) -> ErrorReport:
    """The report on the fault that an action has; ``number`` is that of the step or subgoal."""
    check, names = fault.check, names_of(action, domain, scene)
    objects = tuple([names[parameter] for parameter in check.concerned])
    return ErrorReport(fault.kind, number, check.reason.format_map(names), check.id, objects)
