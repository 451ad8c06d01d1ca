"""Changes: which stored facts must become true or false, any of them, for a literal to become so."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import eai.logic.formula as f
from eai.logic.traversal import children
from eai.planning.subgoal import GroundAtom
from eai.world.derived import Defined
from eai.world.frame import AGENT
from eai.world.vocabulary import Vocabulary


class Change(NamedTuple):
    """A fact about a stored predicate that becomes true, or false; None stands for any object."""

    predicate: str
    arguments: tuple[int | None, ...]
    truth: bool


def changes_for(literal: GroundAtom, vocabulary: Vocabulary, agent: int) -> list[Change]:
    """The changes that may make a literal so, as far as the definition of its predicate tells.

    Objects may go by any numbers, ``agent`` is that of the agent. The values of variables that a definition
    binds are not told apart; what only a function tells comes down to any change of the predicates that it
    reads.
    """
    seen: dict[Change, None] = {}
    found: list[Change] = []
    pending = [Change(*literal)]
    while pending:
        change = pending.pop()
        if change in seen:
            continue
        seen[change] = None
        derived = vocabulary.derived_by_name.get(change.predicate)
        if derived is None:
            found.append(change)
            continue
        definition = derived if isinstance(derived, Defined) else getattr(derived, "meaning", None)
        if definition is not None:
            scope = dict(zip([p.name for p in definition.parameters], change.arguments, strict=True))
            pending += _atoms(definition.definition, scope, change.truth, agent)
        else:
            for name in derived.reads:
                anything = (None,) * (vocabulary.arity(name) or 0)
                pending += [Change(name, anything, truth) for truth in (True, False)]
    return found


def _atoms(formula: f.Formula, scope: Mapping[str, int | None], truth: bool, agent: int) -> Iterator[Change]:
    """The atoms of a formula, each with the truth that helps the formula to its own."""
    match formula:
        case f.Atom(predicate, terms):
            arguments = [agent if t == AGENT else scope.get(t.name) for t in terms]
            yield Change(predicate, tuple(arguments), truth)
        case f.Not(operand):
            yield from _atoms(operand, scope, not truth, agent)
        case f.Implies(premise, conclusion):
            yield from _atoms(premise, scope, not truth, agent)
            yield from _atoms(conclusion, scope, truth, agent)
        case f.Exactly() | f.ForPairs():
            for part in children(formula):
                yield from _atoms(part, {}, True, agent)
                yield from _atoms(part, {}, False, agent)
        case f.ForAll(variable, body) | f.Exists(variable, body):
            inner = {name: value for name, value in scope.items() if name != variable.name}
            yield from _atoms(body, inner, truth, agent)
        case _:
            for part in children(formula):
                yield from _atoms(part, scope, truth, agent)
