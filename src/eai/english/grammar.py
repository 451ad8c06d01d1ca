"""The words of instructions that are the same in every world, and how a sentence is turned."""

from __future__ import annotations

import random
import re
from collections.abc import Sequence
from typing import NamedTuple

from eai.english.english import English

OPENINGS = (
    "Make sure that",
    "See to it that",
    "Please arrange things so that in the end",
    "When you are done, it should be the case that",
)
"""How an instruction begins that says what is to be so; each says the same."""

REQUESTS = ("Please", "Your task is to", "I would like you to")
"""How one begins that says what to do."""

SEE_TO_IT = "see to it that"
"""What makes a request of what is to be so."""

EVERY, EXACTLY, OWN = (
    ("every", "each"),
    ("exactly", "precisely"),
    ("{a} {noun} of its own", "a separate {noun}"),
)
"""Several words for the same."""

NO, SOME, AT_LEAST_ONE = "no", "some", "at least one"

NEVER, WHILE, UNTIL, AFTER = "never", "while", "until", "some time after"
"""What joins two sentences of a goal over time."""

NUMBERS = {1: "one", 2: "two", 3: "three", 4: "four"}
"""Numbers that are written as words."""

_PICKS = 12
_PLURAL = {"is": "are", "has": "have", "holds": "hold", "faces": "face"}


class Voice(NamedTuple):
    """One of several ways to say the same.

    Attributes:
        pick: which of several words is taken, counted round.
        requests: whether goals are what to do ("close the box"), where that can be said.
    """

    pick: int = 0
    requests: bool = False

    @staticmethod
    def drawn(rng: random.Random) -> Voice:
        """Any voice."""
        return Voice(rng.randrange(_PICKS), rng.random() < 0.5)

    def of(self, several: Sequence[str]) -> str:
        """One of several words."""
        return several[self.pick % len(several)]


PLAIN = Voice()
"""What is to be, in the usual words."""


def sentences_of(predicate: str, arity: int, english: English) -> Sequence[str]:
    """What says that a predicate holds, the usual first: ``{x} is on top of {y}``, in the singular."""
    given = english.says.get(predicate)
    if given is not None:
        return given
    name = re.sub("[_-]", " ", predicate).lower().removeprefix("is ")
    if not arity:
        return (f"it is so that {name}",)
    verb = name if name in _PLURAL else f"is {name}"
    return (f"{{x}} {verb} {{y}}" if arity == 2 else f"{{x}} {verb}",)


def turned(sentence: str, *, negated: bool = False, several: bool = False, never: bool = False) -> str:
    """A sentence denied (once or for ever) or in the plural."""
    first, verb, *rest = sentence.split(" ")
    is_short = verb in ("is", "has")
    if never:
        verb = f"{verb} {NEVER}" if is_short else f"{NEVER} {verb}"
    if negated:
        verb = f"{verb} not" if is_short else f"does not {verb.removesuffix('s')}"
    return " ".join([first, _PLURAL.get(verb, verb) if several else verb, *rest])


def plural(noun: str) -> str:
    """The plural of a noun, as regular English has it: of several words of the first before an ``of``."""
    head, of, rest = noun.partition(" of ")
    if of:
        return f"{plural(head)}{of}{rest}"
    if re.search(r"(?:s|x|z|ch|sh)$", noun):
        return f"{noun}es"
    if re.search(r"[^aeiou]y$", noun):
        return f"{noun[:-1]}ies"
    if noun.endswith(("knife", "shelf", "loaf", "leaf")):
        return f"{noun.removesuffix('e').removesuffix('f')}ves"
    return f"{noun}s"
