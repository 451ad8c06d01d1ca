"""Choosing: what a person decides of what demonstrations share, one command after the other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from eai.errors import InputError, did_you_mean
from eai.studies.annotation.abstract import Candidate
from eai.studies.annotation.decisions import Chosen
from eai.studies.annotation.difference import Difference, properties
from eai.studies.annotation.frequency import frequencies
from eai.studies.annotation.pattern import Entry, Pattern, read_pattern
from eai.world.domain import Domain

HELP = """\
keep N ...      each of these must be so
or N N ...      one of these must be so
drop N ...      these mean nothing
add PATTERN     one that is not listed, or: add do TOUCH or do PUSH
new             what follows is of another candidate
undo            take the last command back
done            leave; every decision is saved at once"""

COMMANDS = ("keep", "or", "drop", "add", "new", "undo", "done")


@dataclass(frozen=True)
class Listing:
    """What the demonstrations of a title share.

    Attributes:
        differences: what each of them changes.
        domain: their world.
        without: predicates that are not counted.
    """

    differences: Sequence[Difference]
    domain: Domain
    without: Sequence[str] = ()

    @cached_property
    def counts(self) -> Mapping[Pattern, int]:
        """In how many demonstrations each pattern occurs, the most frequent first."""
        found: Counter[Pattern] = Counter()
        for each in self.differences:
            found.update(set(frequencies([each], self.without)))
        order = frequencies(self.differences, self.without)
        return {pattern: found[pattern] for pattern in sorted(order, key=lambda each: -found[each])}

    @cached_property
    def numbered(self) -> Sequence[Pattern]:
        """The patterns by their numbers, which stay the same whatever is decided; the first has number 1."""
        return tuple(self.counts)

    def open(self, chosen: Chosen) -> list[int]:
        """The numbers of patterns of which nothing is decided yet."""
        decided = chosen.decided
        return [number for number, pattern in enumerate(self.numbered, 1) if pattern not in decided]


def decide(command: str, chosen: Chosen, listing: Listing) -> Chosen:
    """The decisions after one more command, other than ``undo`` and ``done``.

    Raises:
        InputError: it is no command.
    """
    word, _, rest = command.strip().partition(" ")
    match word:
        case "keep":
            return _with_entries(chosen, [(pattern,) for pattern in _named(rest, listing)])
        case "or":
            return _with_entries(chosen, [tuple(_named(rest, listing))])
        case "drop":
            kept = dict.fromkeys((*chosen.dropped, *_named(rest, listing)))
            return replace(chosen, dropped=tuple(kept))
        case "add":
            return _with_entries(chosen, [_alternatives(rest, listing)])
        case "new":
            return replace(chosen, candidates=(*chosen.candidates, Candidate(())))
        case _:
            raise InputError(f"{word!r} is no command: {', '.join(COMMANDS)}{did_you_mean(word, COMMANDS)}")


def _named(text: str, listing: Listing) -> list[Pattern]:
    """The patterns of these numbers."""
    found = []
    for word in text.replace(",", " ").split():
        if not word.isdecimal() or not 1 <= int(word) <= len(listing.numbered):
            raise InputError(f"{word!r}: expected a number from 1 to {len(listing.numbered)}")
        found.append(listing.numbered[int(word) - 1])
    if not found:
        raise InputError("expected the number of a line, or several")
    return found


def _alternatives(text: str, listing: Listing) -> Entry:
    patterns = tuple(read_pattern(part.strip()) for part in text.split(" or "))
    if len({pattern.is_action for pattern in patterns}) > 1:
        raise InputError(f"{text}: an action is no alternative to a state of the world")
    for pattern in patterns:
        _refuse_strangers(pattern, listing)
    return patterns


def refuse_unknown_name(pattern: Pattern, domain: Domain) -> None:
    """Refuse a pattern of an action, or of a predicate, that there is not.

    Raises:
        InputError: the domain does not declare it, or not as something that changes.
    """
    arity = len(pattern.kinds)
    if pattern.is_action:
        _refuse_unknown(pattern.name, [operator.name for operator in domain.operators], "action")
    else:
        names = [
            each.name for each in domain.vocabulary.predicates if each.arity == arity and not each.static
        ]
        _refuse_unknown(pattern.name, names, f"changing predicate of {arity}")


def _refuse_strangers(pattern: Pattern, listing: Listing) -> None:
    """Raise if a pattern names what is not there."""
    refuse_unknown_name(pattern, listing.domain)
    classes = {thing.category for each in listing.differences for thing in each.scene.objects}
    good_for = properties(listing.domain.vocabulary)
    for kind in pattern.kinds:
        if kind.name:
            _refuse_unknown(kind.name, sorted(classes), "class")
        for name in kind.properties:
            _refuse_unknown(name, good_for, "property")


def _refuse_unknown(name: str, known: Sequence[str], noun: str) -> None:
    if name not in known:
        raise InputError(f"{name!r} is no {noun}{did_you_mean(name, known)}")


def _with_entries(chosen: Chosen, entries: Sequence[Entry]) -> Chosen:
    """The decisions with entries in the last candidate."""
    *before, last = chosen.candidates or (Candidate(()),)
    return replace(chosen, candidates=(*before, Candidate((*last.entries, *entries))))
