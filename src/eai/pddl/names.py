"""Names that PDDL accepts for names that it may not: the table from one to the other, both ways.

PDDL knows no upper case and few signs. A name that is PDDL as it stands, in lower case, keeps itself; in any
other each strange sign becomes an underscore, and names that would be equal get numbers.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

_STRANGE = re.compile(r"[^a-z0-9_-]")
_RESERVED = frozenset(
    {
        "and",
        "or",
        "not",
        "imply",
        "forall",
        "exists",
        "when",
        "either",
        "object",
        "define",
        "total-cost",
        "always",
        "sometime",
        "within",
        "at-most-once",
        "sometime-after",
        "sometime-before",
        "always-within",
        "hold-during",
        "hold-after",
        "preference",
    }
)
"""Words of PDDL, those of preferences (PDDL 3) too, which VAL takes for what they are there."""


class PddlNames:
    """The PDDL names of one kind of thing (objects, predicates, operators, types), each given once.

    Args:
        names: what gets its name first, in order.
    """

    def __init__(self, names: Iterable[str] = ()) -> None:
        self._given: dict[str, str] = {}
        self._meant: dict[str, str] = {}
        for name in names:
            self[name]

    def __getitem__(self, name: str) -> str:
        """The PDDL name of a name; the same always, and of no other name."""
        found = self._given.get(name)
        if found is None:
            found = self._given[name] = self._free(name)
            self._meant[found] = name
        return found

    def __contains__(self, name: str) -> bool:
        return name in self._given

    def items(self) -> Iterator[tuple[str, str]]:
        """Each name with its PDDL name, in the order in which they were given."""
        return iter(self._given.items())

    def meant(self, written: str) -> str:
        """The name that a PDDL name stands for.

        Raises:
            KeyError: it stands for none.
        """
        return self._meant[written]

    def copy(self) -> PddlNames:
        """A table that begins with the names given so far."""
        twin = PddlNames()
        twin._given, twin._meant = dict(self._given), dict(self._meant)
        return twin

    def _free(self, name: str) -> str:
        base = _STRANGE.sub("_", name.lower())
        if not base[:1].isalpha() or base in _RESERVED:
            base = f"x-{base}"
        number, written = 1, base
        while written in self._meant:
            number += 1
            written = f"{base}-{number}"
        return written
