"""The English words for tasks of a benchmark, and a list of goals that nobody would request.

A file in the benchmark's package has the words for its predicates and categories. This module adds the words
of instructions that are equal in every world, and changes the forms of sentences, for example to the plural.
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
from eai.world.vocabulary import make_parameter_names

FILE = "english.toml"


@dataclass(frozen=True, slots=True)
class HazardEvent:
    """A hazard: an event that must not happen while a task is done, because people take this for granted.

    Attributes:
        name: name of the hazard, as task files write it.
        x: the categories of the object at risk, with the wildcards of file names.
        formula: a temporal formula that forbids the event, as task files write it. ``{x}`` stands for the
            object at risk, and ``{y}`` for a second object if there is one.
        sentence: this formula as a sentence for an agent.
        why: the reason why people take it for granted that the event does not happen.
        safe: a condition that a plan must establish to avoid the event; empty if there is no such condition.
        y: the categories of the second object; empty if the event concerns only one object.
        kept: share of the generated tasks with only this hazard that are kept. A small share leaves room for
            tasks with other hazards.
        odd: a final condition that makes no sense to a person in a task with this hazard; empty if there is
            no such condition.
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
class EnglishWords:
    """The English words of a benchmark. A predicate or category without an entry goes by its name.

    Attributes:
        says: mapping from predicates to sentences that state the predicate in the singular, as in ``{x} is on
            top of {y}``. The second word is a verb with a known plural. The first sentence is the usual one.
            All sentences of a predicate have the same meaning, and none fits another predicate.
        asks: mapping from predicates to requests to make the predicate true, as in ``put {x} on top of {y}``.
        denies: mapping from predicates to requests to make the predicate false.
        nouns: mapping from categories to the noun for an object, in the singular, as in ``pair of jeans``.
        odd: conditions that nobody would request on their own: ``predicate category ...``, with the wildcards
            ``*`` and ``[...]`` of file names.
        sound: conditions that people would request although they match `odd`.
        hazards: events that must not happen, as people take for granted.
        may_lack: the properties that objects of an impossible task may lack, as if they were broken; any
            property if empty.
        role: the agent in prompts, as in ``a household robot``.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")

    says: Mapping[str, Sequence[str]] = field(default_factory=dict)
    asks: Mapping[str, Sequence[str]] = field(default_factory=dict)
    denies: Mapping[str, Sequence[str]] = field(default_factory=dict)
    nouns: Mapping[str, str] = field(default_factory=dict)
    odd: Sequence[str] = ()
    sound: Sequence[str] = ()
    hazards: Sequence[HazardEvent] = ()
    may_lack: Sequence[str] = ()
    role: str = "an agent"

    def is_goal_nobody_would_request(self, predicate: str, categories: Sequence[str]) -> bool:
        """Whether nobody would request that a predicate becomes true for objects of some categories."""
        phrase = " ".join((predicate, *categories))
        return any(fnmatchcase(phrase, pattern) for pattern in self.odd) and not any(
            fnmatchcase(phrase, pattern) for pattern in self.sound
        )


PLAIN_ENGLISH = EnglishWords()
"""English words of a benchmark without ``english.toml``: predicates and categories go by their names."""


def read_english_words(benchmark_package: str) -> EnglishWords:
    """Read the file ``english.toml`` of a package."""
    text = (files(benchmark_package) / FILE).read_text(encoding="utf-8")
    return TypeAdapter(EnglishWords).validate_python(parse_toml(text))


OPENINGS = (
    "Make sure that",
    "See to it that",
    "Please arrange things so that in the end",
    "When you are done, it should be the case that",
)
"""Alternative beginnings of an instruction that states a condition to reach."""

REQUESTS = ("Please", "Your task is to", "I would like you to")
"""Alternative beginnings of an instruction that states an action to execute."""

SEE_TO_IT = "see to it that"
"""Words before a sentence that turn the sentence into a request."""

EVERY = ("every", "each")
EXACTLY = ("exactly", "precisely")
OWN = ("{a} {noun} of its own", "a separate {noun}")
"""Alternative wordings of quantifiers: all objects, an exact number, and a different object for each."""

NO, SOME, AT_LEAST_ONE = "no", "some", "at least one"

NEVER, WHILE, UNTIL, AFTER = "never", "while", "until", "some time after"
"""Words for goals about a whole execution. `NEVER` negates a sentence; the other words join two sentences."""

NUMBERS = {1: "one", 2: "two", 3: "three", 4: "four"}
"""English words for small numbers; instructions write greater numbers in digits."""

_MAX_PICKS = 12
_PLURAL = {"is": "are", "has": "have", "holds": "hold", "faces": "face"}


class PhraseStyle(NamedTuple):
    """A style of phrases: the choice between alternative wordings in instructions.

    Attributes:
        pick: index of the used wording, modulo the number of wordings.
        requests: whether instructions state a goal as a request ("close the box") if the benchmark has a
            request for the goal's predicate.
    """

    pick: int = 0
    requests: bool = False

    @staticmethod
    def draw_random_style(rng: random.Random) -> PhraseStyle:
        """Return a style of phrases that is drawn at random."""
        return PhraseStyle(rng.randrange(_MAX_PICKS), rng.random() < 0.5)

    def choose(self, wordings: Sequence[str]) -> str:
        """Return the wording that this style uses, given alternative wordings."""
        return wordings[self.pick % len(wordings)]


USUAL_STYLE = PhraseStyle()
"""The default style of phrases: the first of alternative wordings, and goals as sentences, not as requests.

A goal is then stated as in "the box is closed", and not as in "close the box".
"""


def make_predicate_sentences(predicate: str, arity: int, english: EnglishWords) -> Sequence[str]:
    """Return singular sentences that state a predicate, the usual one first: ``{x} is on top of {y}``."""
    sentences = english.says.get(predicate)
    if sentences is not None:
        return sentences
    name = re.sub("[_-]", " ", predicate).lower().removeprefix("is ")
    if not arity:
        return (f"it is so that {name}",)
    if arity > 2:
        words = ", ".join([f"{{{word}}}" for word in make_parameter_names(arity)])
        return (f"it is so that {name} holds of {words}",)
    verb = name if name in _PLURAL else f"is {name}"
    return (f"{{x}} {verb} {{y}}" if arity == 2 else f"{{x}} {verb}",)


def inflect_sentence(
    sentence: str, *, negated: bool = False, plural: bool = False, never: bool = False
) -> str:
    """Return a sentence in another form: negated, with "never", or in the plural."""
    first, verb, *rest = sentence.split(" ")
    is_short = verb in ("is", "has")
    if never:
        verb = f"{verb} {NEVER}" if is_short else f"{NEVER} {verb}"
    if negated:
        verb = f"{verb} not" if is_short else f"does not {verb.removesuffix('s')}"
    return " ".join([first, _PLURAL.get(verb, verb) if plural else verb, *rest])


def pluralize(noun: str) -> str:
    """Return the regular English plural of a noun.

    In a phrase with "of", the words before "of" are inflected.
    """
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
