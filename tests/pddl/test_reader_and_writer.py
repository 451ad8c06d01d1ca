from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eai.base.store import DataPackStore
from eai.benchmarks.reference_wheel import BEHAVIOR_PDDL, RESOURCES
from eai.logic.formula import TRUE, And, Atom, Constant, Exists, ForAll, Formula, Not, Variable
from eai.pddl.check import PddlError, PddlViolationKind
from eai.pddl.model import NO_EFFECT, Add, Delete, PddlDomain, PddlProblem, TypedName, WhenEffect
from eai.pddl.reader import (
    MAX_DEPTH,
    ExpressionList,
    SExpr,
    Symbol,
    read_action,
    read_domain,
    read_group,
    read_problem,
)
from eai.pddl.writer import write_action, write_domain, write_problem
from pddl.random_pddl import DOMAINS, PROBLEMS
from sweeps import examples


@settings(max_examples=examples(30), deadline=None)
@given(DOMAINS)
def test_a_written_domain_is_read_back(domain: PddlDomain) -> None:
    assert read_domain(write_domain(domain)) == domain


@given(PROBLEMS)
def test_a_written_problem_is_read_back(problem: PddlProblem) -> None:
    assert read_problem(write_problem(problem)) == problem


@pytest.mark.parametrize(
    ("pack", "header", "problems", "operators"),
    [(RESOURCES, "virtualhome_pd.pddl", 338, 33), (BEHAVIOR_PDDL, "behavior_pd.pddl", 100, 30)],
)
def test_every_pddl_text_of_the_data_set_survives_a_round_trip(
    data_store: DataPackStore, pack: str, header: str, problems: int, operators: int
) -> None:
    files = data_store.open_pack(pack)
    domain = read_domain(files.read_member(header).decode() + ")")
    assert read_domain(write_domain(domain)) == domain
    texts = files.read_json("problems.json").values()
    assert len(texts) == problems
    for text in texts:
        problem = read_problem(text)
        assert problem.initial
        assert read_problem(write_problem(problem)) == problem
    gold = files.read_json("gold_action.json").values()
    assert len(gold) == operators
    for each in gold:
        action = read_action(
            f"(:action {each['action_name']} :parameters {each['action_parameters']} :precondition "
            f"{each['action_preconditions']} :effect {each['action_effects']})"
        )
        assert read_action(write_action(action)) == action


def test_an_operator_as_a_value() -> None:
    action = read_action(
        "(:ACTION Open :parameters (?c - character ?o) :precondition (and (not (open ?o)) (near ?c kitchen))"
        " :effect (and (open ?o) (when (lit ?o) (not (closed ?o)))))"
    )
    assert action.name == "open"
    assert action.parameters == (Variable("c", "character"), Variable("o"))
    near = Atom("near", (Variable("c"), Constant("kitchen")))
    assert action.precondition == And((Not(Atom("open", (Variable("o"),))), near))
    closed = WhenEffect(Atom("lit", (Variable("o"),)), Delete(Atom("closed", (Variable("o"),))))
    assert action.effect.parts == (Add(Atom("open", (Variable("o"),))), closed)  # type: ignore[union-attr]


def condition(text: str) -> Formula:
    return read_action(f"(:action a :precondition {text})").precondition


def test_absent_and_empty_parts_mean_nothing_is_asked_or_done() -> None:
    for text in ("(:action a)", "(:action a :parameters () :precondition () :effect ())"):
        action = read_action(text)
        assert (action.precondition, action.effect, action.parameters) == (TRUE, NO_EFFECT, ())


def test_quantifiers_over_several_variables_are_nested_and_over_none_vanish() -> None:
    body = Atom("p", (Variable("x"),))
    text = "(forall (?x ?y - t) (exists () (p ?x)))"
    assert condition(text) == ForAll(Variable("x", "t"), ForAll(Variable("y", "t"), body))
    assert condition("(exists (?x) (p ?x))") == Exists(Variable("x"), body)


def test_types_of_a_list_reach_back_to_the_type_before() -> None:
    domain = read_domain("(define (domain d) (:types a b - c d) (:constants k - a))")
    declared = (TypedName("a", "c"), TypedName("b", "c"), TypedName("d", "object"))
    assert domain.types == (*declared, TypedName("c"))  # a supertype need not be declared besides
    assert domain.constants == (TypedName("k", "a"),)


@pytest.mark.parametrize(
    ("text", "offence"),
    [
        ("(not (p) (q))", PddlViolationKind.MALFORMED),
        ("(not)", PddlViolationKind.MALFORMED),
        ("(imply (p))", PddlViolationKind.MALFORMED),
        ("(exists (?x))", PddlViolationKind.MALFORMED),
        ("(exists ?x (p ?x))", PddlViolationKind.MALFORMED),
        ("(exists (x) (p x))", PddlViolationKind.MALFORMED),
        ("(exists (?x -) (p ?x))", PddlViolationKind.MALFORMED),
        ("(exists (?x - (either a b)) (p ?x))", PddlViolationKind.UNSUPPORTED),
        ("(and p)", PddlViolationKind.MALFORMED),
        ("(and ())", PddlViolationKind.MALFORMED),
        ("((p) ?x)", PddlViolationKind.MALFORMED),
        ("(p (q))", PddlViolationKind.MALFORMED),
        ("(when (p) (q))", PddlViolationKind.EFFECT_IN_CONDITION),
        ("(and (p)", PddlViolationKind.UNBALANCED),
    ],
)
def test_a_malformed_condition_is_refused_by_name(text: str, offence: PddlViolationKind) -> None:
    with pytest.raises(PddlError) as raised:
        condition(text)
    assert raised.value.offence is offence


@pytest.mark.parametrize(
    ("text", "offence"),
    [
        ("(or (p) (q))", PddlViolationKind.CONDITION_IN_EFFECT),
        ("(exists (?x) (p ?x))", PddlViolationKind.CONDITION_IN_EFFECT),
        ("(imply (p) (q))", PddlViolationKind.CONDITION_IN_EFFECT),
        ("(not (not (p)))", PddlViolationKind.CONDITION_IN_EFFECT),
        ("(not (and (p)))", PddlViolationKind.CONDITION_IN_EFFECT),
        ("(= ?x ?y)", PddlViolationKind.CONDITION_IN_EFFECT),
        ("(when (p))", PddlViolationKind.MALFORMED),
        ("(and ())", PddlViolationKind.MALFORMED),
    ],
)
def test_a_malformed_effect_is_refused_by_name(text: str, offence: PddlViolationKind) -> None:
    with pytest.raises(PddlError) as raised:
        read_action(f"(:action a :effect {text})")
    assert raised.value.offence is offence


@pytest.mark.parametrize("text", ["(action a)", "(:action)", "(:action a :effect)", "(:action a :cost (p))"])
def test_a_malformed_operator_is_refused(text: str) -> None:
    with pytest.raises(PddlError):
        read_action(text)


@pytest.mark.parametrize("text", ["(define (problem p))", "(domain d)", "(define (domain))"])
def test_a_domain_must_define_one(text: str) -> None:
    with pytest.raises(PddlError, match=r"define \(domain NAME\)"):
        read_domain(text)


def test_only_literals_are_initial_facts() -> None:
    problem = read_problem("(define (problem p) (:domain d) (:init (a) (not (b))) (:goal (a)))")
    assert (problem.initial, problem.denied) == ((Atom("a"),), (Atom("b"),))
    with pytest.raises(PddlError) as raised:
        read_problem("(define (problem p) (:domain d) (:init (= (f) 1)) (:goal (a)))")
    assert raised.value.offence in {PddlViolationKind.MALFORMED, PddlViolationKind.UNSUPPORTED}


def test_derived_predicates_are_read_and_written() -> None:
    text = "(define (domain d) (:predicates (p ?x) (q ?x)) (:derived (q ?x - object) (not (p ?x))))"
    domain = read_domain(text)
    assert [(axiom.name, axiom.condition) for axiom in domain.axioms] == [("q", condition("(not (p ?x))"))]
    assert read_domain(write_domain(domain)) == domain
    with pytest.raises(PddlError, match="derived"):
        read_domain("(define (domain d) (:derived (q)))")


WORDS = st.text("abcdefgh_-:", min_size=1, max_size=6)
TREES = st.recursive(WORDS, lambda parts: st.lists(parts, max_size=4).map(lambda p: f"({' '.join(p)})"))


def show(expression: SExpr) -> str:
    if isinstance(expression, Symbol):
        return expression.text
    return f"({' '.join(show(item) for item in expression.items)})"


@given(st.lists(TREES, max_size=4))
def test_what_is_shown_is_read_back(texts: list[str]) -> None:
    assert [show(expression) for expression in read_group(f"({' '.join(texts)})").items] == texts


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("(AND (On ?X))", "(and (on ?x))"),
        ("(on?char ?obj)", "(on ?char ?obj)"),
        ("; (a\n(b) ; ((\n", "(b)"),
        ("()", "()"),
        ("(\ta\r\n b )", "(a b)"),
    ],
)
def test_tolerates(text: str, shown: str) -> None:
    assert show(read_group(text)) == shown


def test_several_groups_in_a_row_keep_their_places() -> None:
    first, second = read_group("((a) (b\n c))").items
    assert isinstance(first, ExpressionList)
    assert isinstance(second, ExpressionList)
    assert (first.offset, first.end, second.offset, second.end) == (1, 4, 5, 11)
    word = second.items[1]
    assert isinstance(word, Symbol)
    assert (word.text, word.offset) == ("c", 9)


def test_reading_one_group_leaves_the_rest() -> None:
    assert show(read_group("(a) (b")) == "(a)"


@pytest.mark.parametrize(
    ("text", "offence", "line", "column"),
    [
        ("(a\n (b)", PddlViolationKind.UNBALANCED, 1, 1),
        ("\n  )", PddlViolationKind.UNBALANCED, 2, 3),
        ("(" * (MAX_DEPTH + 1), PddlViolationKind.MALFORMED, 1, MAX_DEPTH + 1),
    ],
)
def test_names_the_offence_and_its_place(
    text: str, offence: PddlViolationKind, line: int, column: int
) -> None:
    with pytest.raises(PddlError) as raised:
        read_group(text)
    assert (raised.value.offence, raised.value.line, raised.value.column) == (offence, line, column)


@pytest.mark.parametrize("text", ["", "  ; nothing", "word (a)"])
def test_a_group_is_asked_for(text: str) -> None:
    with pytest.raises(PddlError, match="a parenthesised list"):
        read_group(text)


def test_the_deepest_nesting_that_is_read_can_be_shown() -> None:
    text = "(" * MAX_DEPTH + ")" * MAX_DEPTH
    assert show(read_group(text)) == text
