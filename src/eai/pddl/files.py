"""Read files of PDDL.

If a file has no valid domain or problem, the error names the file, the line and the expected text. Costs of
actions are left out. Other numbers, time and preferences are refused.
"""

from __future__ import annotations

import io
import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from eai.base.errors import InputError, did_you_mean, prefix_errors_with_location
from eai.base.files import read_content
from eai.logic.signature import find_line_and_column
from eai.pddl.check import (
    VIOLATION_FIXABLE_BY_PROBLEM,
    PddlDeclarations,
    PddlError,
    PddlFinding,
    PddlViolationKind,
    TypeScope,
    check_domain,
    check_problem,
)
from eai.pddl.model import OBJECT, PddlDomain, PddlProblem, TypedName, get_variable_type
from eai.pddl.places import find_offset_of_finding
from eai.pddl.reader import (
    CONNECTIVES,
    ExpressionList,
    PddlReader,
    SExpr,
    Symbol,
    find_start_of_unclosed_section,
    get_first_word,
    make_pddl_error,
    read_group,
)

_BLANK = re.compile(r"(?:\s|;[^\n]*)*")
_COMMENT = re.compile(r";[^\n]*")
_DEFINITION = re.compile(rf"\({_BLANK.pattern}define{_BLANK.pattern}\({_BLANK.pattern}(\w+)", re.IGNORECASE)
_UNDECODED = re.compile("[\udc80-\udcff]")
"""A byte that is not valid UTF-8, as Python's `surrogateescape` represents it."""

_SECTIONS_OF = {
    "domain": frozenset(
        {
            "domain",
            ":requirements",
            ":types",
            ":constants",
            ":predicates",
            ":functions",
            ":derived",
            ":action",
        }
    ),
    "problem": frozenset(
        {"problem", ":domain", ":requirements", ":objects", ":init", ":goal", ":metric", ":length"}
    ),
}
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
"""Mapping from the keyword of an unsupported feature of PDDL to the name of the feature in messages."""
_EXPECTED = {
    PddlViolationKind.UNKNOWN_PREDICATE: "a declared predicate, not {}",
    PddlViolationKind.WRONG_ARITY: "{} with as many arguments as are declared",
    PddlViolationKind.UNKNOWN_TYPE: "a declared type, not {}",
    PddlViolationKind.UNBOUND_VARIABLE: "a variable that is a parameter or quantified, not ?{}",
    PddlViolationKind.UNDECLARED_CONSTANT: "a declared object, not {}",
    PddlViolationKind.DUPLICATE: "{} once only",
    PddlViolationKind.MALFORMED: "no type above itself, as {} is",
}


@dataclass(frozen=True, slots=True)
class ProblemFile:
    """A problem with its file and text."""

    problem: PddlProblem
    path: Path
    text: str


def read_domain_text(text: str, path: Path) -> PddlDomain:
    """Return the domain in the text of a file.

    Raises:
        InputError: the text is not a valid domain in the supported part of PDDL.
    """
    with prefix_errors_with_location(path):
        group = _read_definition(text, "domain")
        _require_supported_pddl(text, group, "domain", _read_declared_predicates(group))
        domain = PddlReader(text, is_file=True).read_domain_definition(_remove_costs(group))
        findings = [
            finding for finding in check_domain(domain) if finding.offence is not VIOLATION_FIXABLE_BY_PROBLEM
        ]
        raise_for_findings(text, group, findings, PddlDeclarations.from_domain(domain))
    return domain


def read_problem_file(
    path: Path, domain: PddlDomain, domain_file: tuple[Path, str] | None = None
) -> ProblemFile:
    """Read the problem in a file, which must belong to the domain.

    If the domain is in a file, facts and goals must have arguments of the declared types, and the problem may
    name no other domain. If the domain is in no file, the problem may name another domain, as long as its
    facts and goals are valid in this domain. An object that the domain declares as a constant of the same
    type is dropped from the problem.

    Args:
        path: the file of the problem.
        domain: the domain.
        domain_file: path and text of the domain; None if the domain is in no file.

    Raises:
        InputError: the file cannot be read, or is not a valid problem of the domain.
    """
    return read_problem_text(read_text(path), path, domain, domain_file)


def read_problem_text(
    text: str, path: Path, domain: PddlDomain, domain_file: tuple[Path, str] | None = None
) -> ProblemFile:
    """Read the problem in the text of a file. Errors are raised as by `read_problem_file`."""
    with prefix_errors_with_location(path):
        group = _read_definition(text, "problem")
        _require_supported_pddl(text, group, "problem", [each.name for each in domain.predicates])
        reader = PddlReader(text, is_file=True)
        problem = reader.read_problem_definition(_remove_costs(group))
        vocabulary = PddlDeclarations.from_domain(domain, problem.objects)
        if problem.domain != domain.name:
            is_refused = domain_file is not None and problem.domain
            findings = check_problem(problem, domain)
            if is_refused or any(each.offence.makes_planners_refuse_domain for each in findings):
                offset = next(
                    (each.items[0].offset for each in _find_sections(group, ":domain")), group.offset
                )
                named = f", as in {domain_file[0]}" if domain_file is not None else ""
                expected = f"(:domain {domain.name}){named}, not (:domain {problem.domain})"
                raise make_pddl_error(text, offset, PddlViolationKind.MALFORMED, expected)
        again = [each for each in problem.objects if each in domain.constants]
        _check_constant_types(text, group, problem, domain, domain_file)
        problem = replace(problem, objects=tuple([each for each in problem.objects if each not in again]))
        raise_for_findings(text, group, check_problem(problem, domain), vocabulary)
        _refuse_derived_facts(text, group, problem, domain, vocabulary)
        if domain_file is not None:
            for section in (*_find_sections(group, ":init"), *_find_sections(group, ":goal")):
                _check_argument_types(text, reader, section, {}, vocabulary)
    return ProblemFile(problem, path, text)


def _refuse_derived_facts(
    text: str,
    group: ExpressionList,
    problem: PddlProblem,
    domain: PddlDomain,
    vocabulary: PddlDeclarations,
) -> None:
    derived = {axiom.name for axiom in domain.axioms}
    for name in [atom.predicate for atom in problem.initial if atom.predicate in derived]:
        finding = PddlFinding(PddlViolationKind.UNKNOWN_PREDICATE, name, "initial state")
        offset = find_offset_of_finding(finding, group, vocabulary)
        expected = f"facts from which {name} follows, as {name} is a derived predicate"
        raise make_pddl_error(text, offset, PddlViolationKind.MALFORMED, expected)


def _check_argument_types(
    text: str, reader: PddlReader, group: ExpressionList, scope: TypeScope, vocabulary: PddlDeclarations
) -> None:
    """Raise an error if an argument of a fact or goal has another type than its predicate declares.

    Args:
        text: the text of the problem.
        reader: the reader of the text.
        group: a part of the text.
        scope: mapping from each bound variable, such as ``?x``, to its type.
        vocabulary: the declared names.
    """
    head, arguments = get_first_word(group), group.items[1:]
    if head in ("forall", "exists"):
        bound = reader.read_variables(arguments[0])
        scope = {**scope, **{f"?{variable.name}": get_variable_type(variable) for variable in bound}}
    elif (predicate := vocabulary.predicates.get(head)) is not None:
        expected = [get_variable_type(parameter) for parameter in predicate.parameters]
        for required, argument in zip(expected, arguments, strict=True):
            name = argument.text if isinstance(argument, Symbol) else ""
            actual = scope.get(name) or vocabulary.constants[name]
            if not vocabulary.is_subtype(actual, required):
                atom = " ".join(text[group.offset : group.end].split())
                message = f"types ({' '.join([head, *expected])}) in {atom}, not {name} - {actual}"
                raise make_pddl_error(text, argument.offset, PddlViolationKind.WRONG_ARGUMENT_TYPE, message)
    for part in arguments:
        if isinstance(part, ExpressionList):
            _check_argument_types(text, reader, part, scope, vocabulary)


def _check_constant_types(
    text: str,
    group: ExpressionList,
    problem: PddlProblem,
    domain: PddlDomain,
    domain_file: tuple[Path, str] | None,
) -> None:
    """Raise an error for objects of a problem that the domain declares as constants of another type."""
    constants = {constant_item.name: constant_item for constant_item in domain.constants}
    for item in problem.objects:
        constant = constants.get(item.name, item)
        if constant.type != item.type:
            where = "of the domain"
            if domain_file is not None:
                finding = PddlFinding(VIOLATION_FIXABLE_BY_PROBLEM, item.name, ":constants")
                offset = find_offset_of_finding(
                    finding, _read_first_definition(domain_file[1]), PddlDeclarations.from_domain(domain)
                )
                where = f"of {domain_file[0]}, line {find_line_and_column(domain_file[1], offset)[0]}"
            expected = f"{_write_typed_name(constant)}, as among the constants {where},"
            expected += f" not {_write_typed_name(item)}"
            finding = PddlFinding(VIOLATION_FIXABLE_BY_PROBLEM, item.name, ":objects")
            raise make_pddl_error(
                text,
                find_offset_of_finding(finding, group, PddlDeclarations.from_domain(domain)),
                PddlViolationKind.DUPLICATE,
                expected,
            )


def _write_typed_name(item: TypedName) -> str:
    return item.name if item.type == OBJECT else f"{item.name} - {item.type}"


def _read_first_definition(text: str) -> ExpressionList:
    """Return the first ``define`` expression of a text, in which commas are read as spaces."""
    text = text.replace(",", " ")
    try:
        return read_group(text)
    except PddlError as error:
        offset = (
            find_start_of_unclosed_section(text) if error.offence is PddlViolationKind.UNBALANCED else None
        )
        if offset is None:
            raise
        expected = "a closing parenthesis before this section"
        raise make_pddl_error(text, offset, PddlViolationKind.UNBALANCED, expected) from error


def _read_definition(text: str, kind: str) -> ExpressionList:
    """Read the only ``define`` expression in a text.

    Args:
        text: the text.
        kind: the kind of definition: ``domain`` or ``problem``.
    """
    group = _read_first_definition(text)
    rest = _BLANK.match(text, group.end)
    offset = len(text) if rest is None else rest.end()
    if offset < len(text):
        line, column = find_line_and_column(text, group.end - 1)
        expected = f"the end of the file, as the definition ends at line {line}, column {column}"
        if (second := _DEFINITION.match(text, offset)) is not None:
            expected = f"one definition in a file; put this {second[1].lower()} into a file of its own"
        raise make_pddl_error(text, offset, PddlViolationKind.MALFORMED, expected)
    match group.items[:2]:
        case (Symbol("define"), ExpressionList((Symbol(other), Symbol(name)))) if other in _SECTIONS_OF:
            if other != kind:
                expected = f"the definition of a {kind}, not of the {other} {name}"
                order = "; the file of the domain comes first, then the problems"
                raise make_pddl_error(
                    text, group.items[1].offset, PddlViolationKind.MALFORMED, f"{expected}{order}"
                )
    return group


def is_domain_file(path: Path) -> bool:
    """Whether a file in PDDL or BDDL defines a domain, and nothing else."""
    return _read_domain_or_problem_keywords(path) == ["domain"]


def begins_with_domain_definition(path: Path) -> bool:
    """Whether the first definition in a file defines a domain."""
    return _read_domain_or_problem_keywords(path)[:1] == ["domain"]


def _read_domain_or_problem_keywords(path: Path) -> list[str]:
    """Return the kinds of a file's definitions, ``domain`` or ``problem``; empty if it cannot be read."""
    try:
        text = read_text(path)
    except InputError:
        return []
    return [match[1].lower() for match in _DEFINITION.finditer(_COMMENT.sub("", text))]


def read_text(path: Path) -> str:
    """Return the text of a file in UTF-8. Comments in the file may be in Latin-1.

    Raises:
        InputError: the file cannot be read, or text outside comments is not in UTF-8.
    """
    content = io.BytesIO(read_content(path))
    text = io.TextIOWrapper(content, encoding="utf-8-sig", errors="surrogateescape").read()
    text = _COMMENT.sub(lambda match: _UNDECODED.sub(lambda byte: chr(ord(byte[0]) - 0xDC00), match[0]), text)
    if (undecoded := _UNDECODED.search(text)) is not None:
        line, column = find_line_and_column(text, undecoded.start())
        byte = ord(undecoded[0]) - 0xDC00
        raise InputError(f"{path}: line {line}, column {column}: expected UTF-8, found the byte 0x{byte:02x}")
    return text


def _require_supported_pddl(text: str, group: ExpressionList, kind: str, predicates: Collection[str]) -> None:
    """Raise an error for sections and expressions that are not supported. Action costs are ignored."""
    sections = _SECTIONS_OF[kind]
    for section in group.items[1:]:
        if not isinstance(section, ExpressionList) or not (head := get_first_word(section)):
            raise make_pddl_error(
                text, section.offset, PddlViolationKind.MALFORMED, "a section such as (:action ...)"
            )
        if head not in sections and head not in _REFUSED:
            expected = f"a section of a {kind}, not ({head} ...){did_you_mean(head, sorted(sections))}"
            raise make_pddl_error(text, section.offset, PddlViolationKind.UNSUPPORTED, expected)
        for inner in _walk_nested_lists(section):
            refused = _find_unsupported_feature(inner, allow_numbers=head in _NUMBERED)
            if refused is not None and get_first_word(inner) not in predicates:
                expected = f"classical planning, without {refused}"
                raise make_pddl_error(text, inner.offset, PddlViolationKind.UNSUPPORTED, expected)


def _find_unsupported_feature(group: ExpressionList, *, allow_numbers: bool) -> str | None:
    """Return the name of the unsupported feature in an expression; None if the expression is supported."""
    match group.items:
        case (Symbol("at"), Symbol(), ExpressionList()):
            return "facts that come true at a time"
        case (Symbol("="), *terms) if not allow_numbers and any(
            isinstance(item, ExpressionList) for item in terms
        ):
            return _NUMBERS
        case (Symbol(":action"), _, *parts):
            keys = [item.text for item in parts if isinstance(item, Symbol)]
            return next((_REFUSED[key] for key in keys if key in _REFUSED), None)
        case (Symbol(head), *_):
            return _REFUSED.get(head)
        case _:
            return None


def _remove_costs(group: ExpressionList) -> ExpressionList:
    """Return the definition without functions, metric and initial values of costs.

    An increase of a cost becomes an effect that changes nothing.
    """
    items: list[SExpr] = []
    for item in group.items:
        match item:
            case ExpressionList((Symbol(":functions" | ":metric"), *_) | (Symbol("="), ExpressionList(), _)):
                pass
            case ExpressionList((Symbol("increase"), ExpressionList(), _)):
                items.append(ExpressionList((Symbol("and", item.offset),), item.offset, item.end))
            case ExpressionList():
                items.append(_remove_costs(item))
            case _:
                items.append(item)
    return ExpressionList(tuple(items), group.offset, group.end)


def _read_declared_predicates(group: ExpressionList) -> list[str]:
    sections = _find_sections(group, ":predicates")
    return [
        get_first_word(item)
        for section in sections
        for item in section.items[1:]
        if isinstance(item, ExpressionList)
    ]


def _find_sections(group: ExpressionList, head: str) -> list[ExpressionList]:
    return [item for item in group.items if isinstance(item, ExpressionList) and get_first_word(item) == head]


def _walk_nested_lists(group: ExpressionList) -> Iterator[ExpressionList]:
    yield group
    for item in group.items:
        if isinstance(item, ExpressionList):
            yield from _walk_nested_lists(item)


def raise_for_findings(
    text: str, definition: ExpressionList, findings: Sequence[PddlFinding], vocabulary: PddlDeclarations
) -> None:
    """Raise an error for the first finding that stops a planner, with its position in the text.

    Args:
        text: the text.
        definition: the expression ``(define ...)`` in the text.
        findings: the violations of PDDL that were found in the text.
        vocabulary: the names that the text may use.

    Raises:
        PddlError: a planner would not accept the text.
    """
    names = {
        PddlViolationKind.UNKNOWN_PREDICATE: (*vocabulary.predicates, *sorted(CONNECTIVES)),
        PddlViolationKind.UNKNOWN_TYPE: vocabulary.parents,
        PddlViolationKind.UNDECLARED_CONSTANT: vocabulary.constants,
    }
    for finding in findings:
        if finding.offence.makes_planners_refuse_domain:
            expected = _EXPECTED.get(finding.offence, "{}").format(finding.name)
            hint = did_you_mean(finding.name, names.get(finding.offence, ()))
            offset = find_offset_of_finding(finding, definition, vocabulary)
            raise make_pddl_error(text, offset, finding.offence, f"{expected} ({finding.place}){hint}")


def blank_out_comments(text: str) -> str:
    """Return a text of PDDL or BDDL with blanks in place of comments. Positions stay the same."""
    return _COMMENT.sub(lambda comment: " " * len(comment[0]), text)


def find_line_of_word(text: str, word: str) -> int:
    """Return the number of the first line with a word outside comments, or 1 if there is no such line.

    A blank in the word stands for any white space, or none.
    """
    text = blank_out_comments(text)
    pattern = r"\s*".join(map(re.escape, word.split(" ")))
    match = re.search(rf"(?<![^\s()]){pattern}(?![^\s()])", text, re.IGNORECASE)
    return 1 if match is None else text.count("\n", 0, match.start()) + 1
