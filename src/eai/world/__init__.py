"""Worlds: objects, predicates, states, operators, domains; execution of plans and diagnosis of failures.

The package exports the classes that declare domains, and the functions that use domains. Each name is
imported when it is first used::

    from eai.world import Add, Domain, Operator, Predicate, Variable, Vocabulary, missing_step
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from eai.logic.formula import (
        FALSE,
        TRUE,
        And,
        Atom,
        Constant,
        Equals,
        Exactly,
        Exists,
        ForAll,
        Formula,
        ForPairs,
        Implies,
        Not,
        Or,
        Variable,
    )
    from eai.world.action import Action, Fault
    from eai.world.conformance import check_domain
    from eai.world.derived import ComputedPredicate, DefinedPredicate, LookupPredicate, is_a
    from eai.world.domain import Domain, Simulator
    from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach, Let, When, make_symmetric_effects
    from eai.world.episode import Episode, Slip, SlipSampler
    from eai.world.execution import Step, Trajectory, attempt_action, describe_fault, execute_plan
    from eai.world.fault import FaultKind
    from eai.world.frame import AGENT
    from eai.world.history import History, find_when_action_was_possible, find_when_conditions_held
    from eai.world.operator import (
        Check,
        Operator,
        OperatorAlternative,
        OperatorRole,
        additional_step,
        affordance,
        missing_step,
        sort_checks_in_paper_order,
    )
    from eai.world.state import Fact, Scene, State, StateChange, WorldObject, compare_states
    from eai.world.vocabulary import Predicate, Vocabulary

_MODULES = (
    "eai.logic.formula",
    "eai.world.action",
    "eai.world.conformance",
    "eai.world.derived",
    "eai.world.domain",
    "eai.world.effect",
    "eai.world.episode",
    "eai.world.execution",
    "eai.world.fault",
    "eai.world.frame",
    "eai.world.history",
    "eai.world.operator",
    "eai.world.state",
    "eai.world.vocabulary",
)
"""Names of the modules that define the exported names, in the order in which `__getattr__` tries them."""

__all__ = [
    "AGENT",
    "ANYTHING",
    "FALSE",
    "TRUE",
    "Action",
    "Add",
    "And",
    "Atom",
    "Check",
    "ComputedPredicate",
    "Constant",
    "DefinedPredicate",
    "Delete",
    "Domain",
    "Effect",
    "Episode",
    "Equals",
    "Exactly",
    "Exists",
    "Fact",
    "Fault",
    "FaultKind",
    "ForAll",
    "ForEach",
    "ForPairs",
    "Formula",
    "History",
    "Implies",
    "Let",
    "LookupPredicate",
    "Not",
    "Operator",
    "OperatorAlternative",
    "OperatorRole",
    "Or",
    "Predicate",
    "Scene",
    "Simulator",
    "Slip",
    "SlipSampler",
    "State",
    "StateChange",
    "Step",
    "Trajectory",
    "Variable",
    "Vocabulary",
    "When",
    "WorldObject",
    "additional_step",
    "affordance",
    "attempt_action",
    "check_domain",
    "compare_states",
    "describe_fault",
    "execute_plan",
    "find_when_action_was_possible",
    "find_when_conditions_held",
    "is_a",
    "make_symmetric_effects",
    "missing_step",
    "sort_checks_in_paper_order",
]


def __getattr__(name: str) -> object:
    """Import the module that defines a name, when the name is first used."""
    for module in map(import_module, _MODULES if name in __all__ else ()):
        if name in vars(module):
            return vars(module)[name]
    raise AttributeError(f"module 'eai.world' has no attribute {name!r}")
