"""The English of a benchmark's tasks, and the goals that nobody would ask for in it.

Its words come from a file of the benchmark's package; those of instructions that are the same in every world,
and how a sentence is turned, are here.
"""

from __future__ import annotations

import random
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from importlib.resources import files
from typing import ClassVar, NamedTuple

from pydantic import ConfigDict, TypeAdapter

from eai.base.files import parse_toml
from eai.world.vocabulary import parameter_names

FILE = "english.toml"


@dataclass(frozen=True, slots=True)
class Hazard:
    """A process constraint that a person takes for granted: what it keeps from happening on the way.

    Attributes:
        name: what it keeps from happening, as records have it.
        x: the categories of the thing that it is about, with the wildcards of names of files.
        formula: the goal over time about ``{x}``, and ``{y}`` where there is another thing, as task files
            state goals.
        sentence: the same for an agent.
        why: why a person agrees.
        safe: what is to be brought about on the way, where the danger passes by that; empty where another
            way must be found.
        y: the categories of the other thing; empty if there is none.
        kept: how many of the tasks with it alone are kept, where it is so frequent that others would be rare.
        odd: what at the end of a task with it makes no sense to a person; empty if nothing does.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")

    name: str
    x: Sequence[str]
    formula: str
    sentence: str
    why: str
    safe: str = ""
    y: Sequence[str] = ()
    kept: float = 1.0
    odd: str = ""


@dataclass(frozen=True, slots=True)
class English:
    """The words of a benchmark; a text that says nothing of a predicate or category leaves it to its name.

    Attributes:
        says: sentences that say that a predicate holds, by its name: in the singular, the second word a verb
            of which the plural is known, as in ``{x} is on top of {y}``. The first is the usual one; all mean
            the same, and no sentence of another predicate.
        asks: requests that it be so, by its name, as in ``put {x} on top of {y}``.
        denies: requests that it be not so.
        nouns: what an object of a category is called, in the singular, as in ``pair of jeans``.
        odd: what nobody would ask for by itself, though it occurs: ``predicate category ...``, in which ``*``
            and ``[...]`` stand for anything as in names of files.
        sound: what is not odd after all.
        hazards: what a person takes for granted must not happen.
        may_lack: the properties that a thing may be without, as where it is broken; any if empty.
        role: the agent in prompts, as in ``a household robot``.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")

    says: Mapping[str, Sequence[str]] = field(default_factory=dict)
    asks: Mapping[str, Sequence[str]] = field(default_factory=dict)
    denies: Mapping[str, Sequence[str]] = field(default_factory=dict)
    nouns: Mapping[str, str] = field(default_factory=dict)
    odd: Sequence[str] = ()
    sound: Sequence[str] = ()
    hazards: Sequence[Hazard] = ()
    may_lack: Sequence[str] = ()
    role: str = "an agent"

    def is_odd(self, predicate: str, categories: Sequence[str]) -> bool:
        """Whether nobody would ask that a predicate hold of objects of these categories."""
        phrase = " ".join((predicate, *categories))
        return any(fnmatchcase(phrase, each) for each in self.odd) and not any(
            fnmatchcase(phrase, each) for each in self.sound
        )


PLAIN_ENGLISH = English()
"""All words are made of names, and nothing is odd."""


def read_english(package: str) -> English:
    """Read the file ``english.toml`` of a package."""
    text = (files(package) / FILE).read_text(encoding="utf-8")
    return TypeAdapter(English).validate_python(parse_toml(text))


OPENINGS = (
    "Make sure that",
    "See to it that",
    "Please arrange things so that in the end",
    "When you are done, it should be the case that",
)
"""The beginnings of an instruction that states a condition; each says the same."""

REQUESTS = ("Please", "Your task is to", "I would like you to")
"""The beginnings of an instruction that states an action."""

SEE_TO_IT = "see to it that"
"""The words that make a request of a sentence."""

EVERY, EXACTLY, OWN = (
    ("every", "each"),
    ("exactly", "precisely"),
    ("{a} {noun} of its own", "a separate {noun}"),
)
"""Several words for the same."""

NO, SOME, AT_LEAST_ONE = "no", "some", "at least one"

NEVER, WHILE, UNTIL, AFTER = "never", "while", "until", "some time after"
"""The words that join two sentences of a goal over time."""

NUMBERS = {1: "one", 2: "two", 3: "three", 4: "four"}
"""Numbers that are written as words."""

_MAX_PICKS = 12
_PLURAL = {"is": "are", "has": "have", "holds": "hold", "faces": "face"}


class PhraseStyle(NamedTuple):
    """One of several ways to say the same.

    Attributes:
        pick: which of several words is taken, counted round.
        requests: whether goals are what to do ("close the box"), where that can be said.
    """

    pick: int = 0
    requests: bool = False

    @staticmethod
    def draw(rng: random.Random) -> PhraseStyle:
        """Any voice."""
        return PhraseStyle(rng.randrange(_MAX_PICKS), rng.random() < 0.5)

    def choose(self, several: Sequence[str]) -> str:
        """One of several words."""
        return several[self.pick % len(several)]


USUAL_STYLE = PhraseStyle()
"""Sentences in the usual words."""


def sentences_of(predicate: str, arity: int, english: English) -> Sequence[str]:
    """The sentences for a predicate, the usual first: ``{x} is on top of {y}``, in the singular."""
    given = english.says.get(predicate)
    if given is not None:
        return given
    name = re.sub("[_-]", " ", predicate).lower().removeprefix("is ")
    if not arity:
        return (f"it is so that {name}",)
    if arity > 2:
        return (
            f"it is so that {name} holds of {', '.join([f'{{{each}}}' for each in parameter_names(arity)])}",
        )
    verb = name if name in _PLURAL else f"is {name}"
    return (f"{{x}} {verb} {{y}}" if arity == 2 else f"{{x}} {verb}",)


def inflect(sentence: str, *, negated: bool = False, several: bool = False, never: bool = False) -> str:
    """A sentence denied (once or for ever) or in the plural."""
    first, verb, *rest = sentence.split(" ")
    is_short = verb in ("is", "has")
    if never:
        verb = f"{verb} {NEVER}" if is_short else f"{NEVER} {verb}"
    if negated:
        verb = f"{verb} not" if is_short else f"does not {verb.removesuffix('s')}"
    return " ".join([first, _PLURAL.get(verb, verb) if several else verb, *rest])


def pluralize(noun: str) -> str:
    """The plural of a noun, as regular English has it: of several words of the first before an ``of``."""
    head, of, rest = noun.partition(" of ")
    if of:
        return f"{pluralize(head)}{of}{rest}"
    if re.search(r"(?:s|x|z|ch|sh)$", noun):
        return f"{noun}es"
    if re.search(r"[^aeiou]y$", noun):
        return f"{noun[:-1]}ies"
    if noun.endswith(("knife", "shelf", "loaf", "leaf")):
        return f"{noun.removesuffix('e').removesuffix('f')}ves"
    return f"{noun}s"
