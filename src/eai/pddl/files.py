"""Reading files of PDDL: sound domains and problems, or an error that names file, line and what was expected.

Costs of actions are left out, which is remarked; numbers otherwise, time and preferences are refused.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from eai.errors import InputError, located
from eai.pddl.check import OF_PROBLEMS, Offence, PddlFinding, check_domain, check_problem
from eai.pddl.model import PddlDomain, PddlProblem
from eai.pddl.reader import Group, PddlReader, SExpr, Symbol, error_at, head_of, read_group

_DOMAIN = frozenset(
    ["domain", ":requirements", ":types", ":constants", ":predicates", ":functions", ":derived", ":action"]
)
_PROBLEM = frozenset(
    {"problem", ":domain", ":requirements", ":objects", ":init", ":goal", ":metric", ":length"}
)
_NUMBERS = "numbers or object fluents, but for costs of actions"
_NUMBERED = frozenset({":init", ":metric", ":functions"})
_REFUSED = {
    ":durative-action": "durative actions",
    ":constraints": "constraints on the course of a plan",
    ":process": "processes",
    ":event": "events",
    ":observe": "observations",
    ":sensing": "observations",
    "probabilistic": "probabilistic effects",
    "oneof": "nondeterministic effects",
    "unknown": "facts that are unknown at the start",
    "preference": "preferences",
    **dict.fromkeys(("<", ">", "<=", ">=", "assign", "decrease", "scale-up", "scale-down"), _NUMBERS),
}
"""All that is not taken, in words, by the word with which it begins."""
_EXPECTED = {
    Offence.UNKNOWN_PREDICATE: "a declared predicate, not {}",
    Offence.WRONG_ARITY: "{} with as many arguments as are declared",
    Offence.UNKNOWN_TYPE: "a declared type, not {}",
    Offence.UNBOUND_VARIABLE: "a variable that is a parameter or quantified, not ?{}",
    Offence.UNDECLARED_CONSTANT: "a declared object, not {}",
    Offence.DUPLICATE: "{} once only",
    Offence.MALFORMED: "no type above itself, as {} is",
}


@dataclass(frozen=True, slots=True)
class ProblemFile:
    """A problem that was read, and its text."""

    problem: PddlProblem
    path: Path
    text: str


def domain_in(text: str, path: Path) -> PddlDomain:
    """The domain in a text that was found in a file.

    Raises:
        InputError: it is no sound domain of a fragment that is understood.
    """
    with located(path):
        group = _read_group(text)
        _check(text, group, _DOMAIN, _declared(group))
        domain = PddlReader(text, either=True).domain(_without_costs(group))
        refuse(text, [each for each in check_domain(domain) if each.offence is not OF_PROBLEMS])
    return domain


def read_problem_file(path: Path, domain: PddlDomain) -> ProblemFile:
    """The problem in a file, which must be one of the domain.

    The names of domains are not compared where all else fits, as planners do.

    Raises:
        InputError: it cannot be read, or is no sound problem of the domain.
    """
    return problem_in(read_text(path), path, domain)


def problem_in(text: str, path: Path, domain: PddlDomain) -> ProblemFile:
    """The problem in a text that was found in a file; raises likewise."""
    with located(path):
        group = _read_group(text)
        _check(text, group, _PROBLEM, [each.name for each in domain.predicates])
        problem = PddlReader(text, either=True).problem(_without_costs(group))
        again = {each.name for each in domain.constants} & {each.name for each in problem.objects}
        twice = [PddlFinding(Offence.DUPLICATE, name, ":objects") for name in sorted(again)]
        findings = (*twice, *check_problem(problem, domain))
        if problem.domain != domain.name and any(each.offence.stops_planner for each in findings):
            place = _offset(text, ":domain", 0)
            raise error_at(text, place, Offence.MALFORMED, f"(:domain {domain.name})")
        refuse(text, findings)
    return ProblemFile(problem, path, text)


def _read_group(text: str) -> Group:
    """The definition in a text, in which commas may stand between names."""
    return read_group(text.replace(",", " "))


def read_text(path: Path) -> str:
    """The text of a file.

    Raises:
        InputError: it cannot be read.
    """
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is no UTF-8 text"
        raise InputError(f"{path}: cannot be read ({reason})") from error


def _check(text: str, group: Group, known: frozenset[str], predicates: Collection[str]) -> None:
    """Refuse what is not understood; costs, which are ignored, are."""
    for section in group.items[1:]:
        if not isinstance(section, Group) or not (head := head_of(section)):
            raise error_at(text, section.offset, Offence.MALFORMED, "a section such as (:action ...)")
        if head not in known and head not in _REFUSED:
            raise error_at(text, section.offset, Offence.UNSUPPORTED, f"no section ({head} ...)")
        for inner in _groups(section):
            refused = _refusal(inner, numbers=head in _NUMBERED)
            if refused is not None and head_of(inner) not in predicates:
                expected = f"classical planning, without {refused}"
                raise error_at(text, inner.offset, Offence.UNSUPPORTED, expected)


def _refusal(group: Group, *, numbers: bool) -> str | None:
    """The reason why a group is not taken, in words; None if it is, where numbers may be set or not."""
    match group.items:
        case (Symbol("at"), Symbol(), Group()):
            return "facts that come true at a time"
        case (Symbol("="), *terms) if not numbers and any(isinstance(each, Group) for each in terms):
            return _NUMBERS
        case (Symbol(":action"), _, *parts):
            keys = [each.text for each in parts if isinstance(each, Symbol)]
            return next((_REFUSED[key] for key in keys if key in _REFUSED), None)
        case (Symbol(head), *_):
            return _REFUSED.get(head)
        case _:
            return None


def _without_costs(group: Group) -> Group:
    """The definition without functions, a metric, what increases a cost and what sets one at the start."""
    kept: list[SExpr] = []
    for item in group.items:
        if not isinstance(item, Group):
            kept.append(item)
        elif not _is_cost(item):
            kept.append(_without_costs(item))
    return Group(tuple(kept), group.offset, group.end)


def _is_cost(group: Group) -> bool:
    match group.items:
        case (Symbol(":functions" | ":metric" | "increase"), *_) | (Symbol("="), Group(), _):
            return True
        case _:
            return False


def _declared(group: Group) -> list[str]:
    """The names of the predicates that a domain declares."""
    sections = [each for each in group.items if isinstance(each, Group) and head_of(each) == ":predicates"]
    return [head_of(item) for each in sections for item in each.items[1:] if isinstance(item, Group)]


def _groups(group: Group) -> Iterator[Group]:
    yield group
    for item in group.items:
        if isinstance(item, Group):
            yield from _groups(item)


def refuse(text: str, findings: Sequence[PddlFinding]) -> None:
    """Refuse a text for what was found in it.

    Raises:
        PddlError: for the first finding that a planner would not accept, at its place in the text.
    """
    for finding in findings:
        if finding.offence.stops_planner:
            operator = finding.place.rpartition(" of ")[2] if " of " in finding.place else ""
            start = _offset(text, operator, 0) if operator else _offset(text, finding.place, 0)
            variable = finding.offence is Offence.UNBOUND_VARIABLE
            name = f"?{finding.name}" if variable else finding.name
            expected = _EXPECTED.get(finding.offence, "{}").format(finding.name)
            place = _offset(text, name, start)
            raise error_at(text, place, finding.offence, f"{expected} ({finding.place})")


def line_of(text: str, word: str) -> int:
    """The line on which a word stands first, or 1."""
    return text.count("\n", 0, _offset(text, word, 0)) + 1


def _offset(text: str, word: str, start: int) -> int:
    """Where a word stands first from a place on, else that place."""
    found = re.compile(rf"(?<![^\s()]){re.escape(word)}(?![^\s()])", re.IGNORECASE).search(text, start)
    return start if found is None else found.start()
