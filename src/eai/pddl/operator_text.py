"""An operator as an answer writes it, before anything is understood."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class OperatorText:
    """The name of an operator and the text of its three parts, each a parenthesised list."""

    name: str
    parameters: str
    precondition: str
    effect: str

    @property
    def size(self) -> int:
        """How many characters its parts take."""
        return len(self.parameters) + len(self.precondition) + len(self.effect)

    @property
    def pddl(self) -> str:
        """The operator as a PDDL action."""
        return (
            f"(:action {self.name} :parameters {self.parameters} "
            f":precondition {self.precondition} :effect {self.effect})"
        )
