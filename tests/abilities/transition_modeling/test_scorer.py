from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import pytest

from eai.abilities.transition_modeling.extraction import MAX_CACHED_CHARACTERS, ResultCache
from eai.abilities.transition_modeling.rules import OperatorScoringRules, PaperOperatorScoringRules
from eai.abilities.transition_modeling.scorer import TransitionModelingScorer, count_matches_by_category
from eai.abilities.transition_modeling.verdict import (
    OperatorComparisonStatus,
    OperatorVerdict,
    find_predicates_and_their_categories,
)
from eai.abilities.verdict import ALL, ConfusionCounts, Verdict
from eai.pddl.fast_downward import FastDownward
from eai.pddl.matching import ClauseComparison
from eai.pddl.model import OperatorText
from eai.pddl.planners import make_planner, resolve_automatic_choice
from eai.pddl.planning import (
    PddlPlanner,
    PlannerChoice,
    PlannerLimits,
    PlannerOutcome,
    PlannerResult,
    PlanningTask,
)
from eai.pddl.reader import read_domain
from eai.pddl.search import BuiltInPlanner
from eai.tasks.operator_task import OperatorLibrary, TransitionTask
from eai.tasks.task import PredicateCategory
from eai.world.fault import FaultKind
from operator_rules import gold_answer

OPEN = OperatorText("open", "(?o)", "(and (shut ?o) (near ?o))", "(not (shut ?o))")
LIGHT = OperatorText("light", "(?o)", "(near ?o)", "(lit ?o)")
STAMP = OperatorText("stamp", "(?o)", "()", "(lit ?o)")
DOMAIN = OperatorLibrary(
    read_domain("(define (domain d) (:predicates (shut ?o) (near ?o) (lit ?o) (used ?o)))"),
    {"open": OPEN, "light": LIGHT, "stamp": STAMP},
    {
        "shut": PredicateCategory.OBJECT_STATES,
        "lit": PredicateCategory.OBJECT_STATES,
        "near": PredicateCategory.SPATIAL_RELATIONS,
        "used": PredicateCategory.OBJECT_TOOLS,
    },
)
TASK = TransitionTask(
    "t",
    DOMAIN,
    ("open", "light"),
    (PredicateCategory.OBJECT_STATES, PredicateCategory.SPATIAL_RELATIONS),
    "(define (problem p) (:domain d) (:objects box) (:init (shut box) (near box))"
    " (:goal (and (lit box) (not (shut box)))))",
)


def answer(*operators: OperatorText) -> str:
    return json.dumps({"output": "\n".join(operator.write_pddl for operator in operators)})


MakeRules: TypeAlias = Callable[[PddlPlanner | None], OperatorScoringRules]


@pytest.fixture
def rules_with() -> MakeRules:
    """Make the rules of `strict`. Tests of other protocols replace this fixture."""
    return PaperOperatorScoringRules


def score(text: str, rules_with: MakeRules = PaperOperatorScoringRules) -> OperatorVerdict:
    verdict = TransitionModelingScorer(TASK, rules_with(BuiltInPlanner())).score(text)
    assert isinstance(verdict, OperatorVerdict)
    return verdict


def counts(verdict: Verdict) -> dict[str, dict[str, tuple[int, ...]]]:
    return {
        side: {name: tuple(confusion) for name, confusion in found.items() if name != ALL}
        for side, found in (verdict.counts or {}).items()
        if not isinstance(found, ConfusionCounts)
    }


GOLD_COUNTS = {
    "precondition": {"object_states": (1, 0, 0), "spatial_relations": (2, 0, 0)},
    "effect": {"object_states": (2, 0, 0)},
}
"""The same for clauses and for predicates: no clause has two, and no predicate is in two of an operator."""


def test_the_gold_answer_has_no_error(rules_with: MakeRules) -> None:
    verdict = score(gold_answer(TASK), rules_with)
    assert counts(verdict) == GOLD_COUNTS
    assert verdict.planner is PlannerOutcome.SOLVED
    assert verdict.success is True
    assert verdict.task_categories == ("object_states", "spatial_relations")
    assert sorted(verdict.plan) == ["light box", "open box"]


def test_a_missing_operator_costs_recall_and_the_plan() -> None:
    verdict = score(answer(LIGHT))
    assert counts(verdict)["precondition"] == {"object_states": (0, 0, 1), "spatial_relations": (1, 0, 1)}
    assert verdict.planner is PlannerOutcome.UNSOLVABLE


GHOST = OperatorText("light", "(?o)", "(and (near ?o) (bright ?o))", "(lit ?o)")
SILENT = OperatorText("light", "(?o)", "(used ?o)", "(lit ?o)")
EVERYTHING = OperatorText("open", "()", "()", "(forall (?a) (lit ?a))")


def test_what_was_not_asked_for_does_not_help() -> None:
    verdict = score(answer(OPEN, SILENT, STAMP))
    assert verdict.planner is PlannerOutcome.UNSOLVABLE
    compared, hallucinated = OperatorComparisonStatus.COMPARED, OperatorComparisonStatus.HALLUCINATED
    assert [each.status for each in verdict.operators] == [compared, compared, hallucinated]


def test_a_predicate_that_the_domain_lacks_is_counted() -> None:
    assert counts(score(answer(OPEN, GHOST)))["precondition"]["other"] == (0, 1, 0)


def test_a_clause_is_right_or_wrong_as_a_unit_in_each_category() -> None:
    nested = OperatorText("light", "(?o)", "(not (exists (?x) (and (near ?x) (shut ?x))))", "(lit ?o)")
    library = OperatorLibrary(DOMAIN.header, {"light": nested}, DOMAIN.categories)
    task = TransitionTask("t", library, ("light",), (PredicateCategory.OBJECT_STATES,), TASK.problem_text)
    half = OperatorText("light", "(?o)", "(not (exists (?y) (and (bright ?y) (near ?y))))", "(lit ?o)")
    for operator, side, in_literals in (
        (nested, {"all": (1, 0, 0), "object_states": (1, 0, 0), "spatial_relations": (1, 0, 0)}, (2, 0, 0)),
        (
            half,
            {
                "all": (0, 1, 1),
                "object_states": (0, 0, 1),
                "other": (0, 1, 0),
                "spatial_relations": (0, 1, 1),
            },
            (1, 1, 1),
        ),
    ):
        rules = PaperOperatorScoringRules(None)
        verdict = TransitionModelingScorer(task, rules).assess(answer(operator)).verdict
        assert isinstance(verdict, OperatorVerdict)
        assert verdict.counts == {
            "precondition": side,
            "effect": {"all": (1, 0, 0), "object_states": (1, 0, 0)},
        }
        assert verdict.literals == {"precondition": in_literals, "effect": (1, 0, 0)}


def test_an_unreadable_answer_misses_all_clauses() -> None:
    verdict = score("3")
    assert verdict.error is not None
    assert verdict.error.kind is FaultKind.PARSING
    assert counts(verdict)["effect"] == {"object_states": (0, 0, 2)}
    assert (verdict.planner, verdict.excluded) == (PlannerOutcome.INPUT_ERROR, None)


@pytest.mark.parametrize("text", [gold_answer(TASK), "3", answer(OperatorText("open", "()", "(dark)", "()"))])
def test_without_a_planner_nothing_is_said_of_plans(rules_with: MakeRules, text: str) -> None:
    verdict = TransitionModelingScorer(TASK, rules_with(None)).score(text)
    assert (verdict.success, verdict.plan_works) == (None, None)
    assert verdict.planner in ({PlannerOutcome.NOT_RUN} if verdict.excluded is None else {None})


@pytest.fixture
def problems() -> int:
    """Return the number of different planning problems in two answers."""
    return 2


def test_equal_operators_are_planned_with_once(rules_with: MakeRules, problems: int) -> None:
    class Counting:
        name = "counting"
        calls = 0

        def solve(self, task: PlanningTask) -> PlannerResult:
            self.calls += 1
            return PlannerResult(PlannerOutcome.UNSOLVABLE)

    planner = Counting()
    scorer = TransitionModelingScorer(TASK, rules_with(planner))
    verdicts = {scorer.score(text) == scorer.score(text) for text in (answer(OPEN, LIGHT), answer(OPEN))}
    assert verdicts == {True}
    assert planner.calls == problems


def test_an_explanation_names_the_defects_and_shows_the_plan() -> None:
    scorer = TransitionModelingScorer(TASK, PaperOperatorScoringRules(BuiltInPlanner()))
    notes = scorer.explain(answer(OperatorText("open", "(?o)", "(near ?x)", "(not (shut ?o))"))).notes
    assert "open: the precondition lacks the clauses (shut ?o), (near ?o)" in notes
    assert "open: the precondition has the additional clause (near ?x) (no parameter: ?x)" in notes
    assert "open: unbound_variable in the precondition of open: x" in notes
    assert "light: missing" in notes
    assert any(note.startswith("planner: input_error") for note in notes)
    steps = scorer.explain(gold_answer(TASK)).steps
    assert sorted(step.action for step in steps) == ["light box", "open box"]
    assert scorer.explain("3").notes != ()


def test_an_unreadable_side_misses_only_its_own_clauses() -> None:
    half = OPEN.write_pddl.replace(OPEN.effect, "(or (lit ?o) (shut ?o))")
    scorer = TransitionModelingScorer(TASK, PaperOperatorScoringRules(BuiltInPlanner()))
    text = json.dumps({"output": f"{half}\n{LIGHT.write_pddl}"})
    verdict = scorer.score(text)
    assert isinstance(verdict, OperatorVerdict)
    lost = {**GOLD_COUNTS["effect"], "object_states": (1, 0, 1)}
    assert counts(verdict) == {"precondition": GOLD_COUNTS["precondition"], "effect": lost}
    assert (verdict.planner, verdict.success) == (PlannerOutcome.INPUT_ERROR, False)
    assert verdict.operators[0].status is OperatorComparisonStatus.COMPARED
    notes = scorer.explain(text).notes
    assert "open: the effect cannot be compared, so it counts as lacking the clause (not (shut ?o))" in notes
    assert "open: condition_in_effect in the effect of open: expected an effect, not (or ...)" in notes
    assert not any("precondition" in note or "the effect lacks" in note for note in notes)


def test_an_explanation_names_renamed_parameters() -> None:
    scorer = TransitionModelingScorer(TASK, PaperOperatorScoringRules(BuiltInPlanner()))
    other = OPEN.write_pddl.replace("?o", "?thing")
    notes = scorer.explain(json.dumps({"output": f"{other}\n{LIGHT.write_pddl}"})).notes
    assert [note for note in notes if "compared so" in note] == [
        "open: compared so that its ?thing is the data set's ?o; "
        "clauses that it lacks have the data set's names, additional ones its own"
    ]


def test_an_explanation_says_which_clauses_are_alternatives() -> None:
    gold = OperatorText("open", "(?o)", "(or (shut ?o) (near ?o))", "(not (shut ?o))")
    library = OperatorLibrary(DOMAIN.header, {"open": gold, "stamp": STAMP}, DOMAIN.categories)
    task = TransitionTask("t", library, ("open", "stamp"), TASK.categories, TASK.problem_text)
    scorer = TransitionModelingScorer(task, PaperOperatorScoringRules(None))
    written = [
        OperatorText("open", "(?o)", "(and (shut ?o) (used ?o))", "(not (shut ?o))"),
        OperatorText("stamp", "(?o)", "(or (near ?o) (used ?o))", "(lit ?o)"),
    ]
    assert [note for note in scorer.explain(answer(*written)).notes if "precondition" in note] == [
        "open: the precondition lacks the alternatives (shut ?o), (near ?o)",
        "open: the precondition has the additional clause (and (shut ?o) (used ?o))",
        "stamp: the precondition has the additional alternatives (near ?o), (used ?o)",
    ]


def test_an_explanation_says_what_an_unreadable_side_lacks() -> None:
    nested = OperatorText("open", "(?o)", "(shut (lid ?o))", "(not (shut ?o))")
    notes = (
        TransitionModelingScorer(TASK, PaperOperatorScoringRules(BuiltInPlanner()))
        .explain(answer(nested))
        .notes
    )
    assert "open: malformed in the precondition of open: expected a word, not a list" in notes
    assert "planner: input_error (precondition of open: malformed: expected a word, not a list)" in notes


def test_an_explanation_names_the_repairs_of_each_operator() -> None:
    scorer = TransitionModelingScorer(TASK, PaperOperatorScoringRules(BuiltInPlanner()))
    short = OPEN.write_pddl.replace("(near ?o))", "(near ?o)")
    text = f"{short}\n{LIGHT.write_pddl}"
    notes = scorer.explain(text).notes
    assert notes[0] == "the answer: read with repair: no_json"
    assert "open: read with repair: closing_parenthesis" in notes
    verdict = scorer.score(text)
    assert verdict.repairs == ("no_json", "closing_parenthesis")
    assert counts(verdict) == GOLD_COUNTS


TASK_OF_TWO = TransitionTask(
    "t",
    OperatorLibrary(
        DOMAIN.header,
        {
            "open": OperatorText("open", "(?a ?b)", "(and (shut ?a) (near ?b))", "(not (shut ?a))"),
            "light": OperatorText("light", "(?a)", "(not (shut ?a))", "(lit ?a)"),
        },
        DOMAIN.categories,
    ),
    ("open", "light"),
    (),
    "(define (problem p) (:domain d) (:objects box lamp) (:init (shut box) (near lamp)) (:goal (lit box)))",
)


@pytest.mark.parametrize(
    ("opened", "works", "note"),
    [
        ("(?a ?b)|(and (shut ?a) (near ?b))|(not (shut ?a))", True, "works with the data set's operators"),
        ("(?x ?y)|(and (shut ?x) (near ?y))|(not (shut ?x))", True, "works with the data set's operators"),
        ("(?b ?a)|(and (shut ?a) (near ?b))|(not (shut ?a))", True, "works with the data set's operators"),
        ("(?b ?c ?a)|(and (shut ?a) (near ?b) (shut ?c))|(not (shut ?a))", True, "works with the data set's"),
        ("(?y ?x)|(and (shut ?x) (near ?y))|(not (shut ?x))", False, "the precondition of (open lamp box)"),
        ("(?a)|(shut ?a)|(not (shut ?a))", False, "step 1: open takes 2 objects"),
        ("()|()|(forall (?a) (and (lit ?a) (not (shut ?a))))", False, "step 1: open takes 2 objects"),
        ("(?a ?b)|(shut ?b)|(forall (?c) (lit ?c))", False, "step 1: the precondition of (open"),
    ],
)
def test_a_plan_succeeds_if_it_works_with_the_gold_operators(opened: str, works: bool, note: str) -> None:
    scorer = TransitionModelingScorer(TASK_OF_TWO, PaperOperatorScoringRules(BuiltInPlanner()))
    light = TASK_OF_TWO.domain.operators["light"]
    assessment = scorer.assess(answer(OperatorText("open", *opened.split("|")), light))
    verdict = assessment.verdict
    assert isinstance(verdict, OperatorVerdict)
    assert verdict.planner is PlannerOutcome.SOLVED
    assert (verdict.plan_works, verdict.success) == (works, works)
    assert note in assessment.explain().notes[-1]


def test_the_user_chooses_the_planner() -> None:
    assert make_planner(PlannerChoice.NONE, 200) is None
    assert make_planner(PlannerChoice.BUILT_IN, 200) == BuiltInPlanner()


def test_an_explanation_says_which_operators_the_planner_got(tmp_path: Path) -> None:
    if not FastDownward.is_installed():
        pytest.skip("Fast Downward is not installed")
    usual = make_planner(PlannerChoice.FAST_DOWNWARD, 200)
    assert isinstance(usual, FastDownward)
    assert (usual.cpu_seconds, usual.memory_mib, usual.slots, usual.remark) == (200, 4096, None, "")
    brief = make_planner(PlannerChoice.FAST_DOWNWARD, 200, PlannerLimits(seconds=5))
    assert isinstance(brief, FastDownward)
    assert (brief.cpu_seconds, brief.name) == (5, f"{usual.name} (5 s)")
    for memory, limit, seats in ((30_000, 4096, 7), (1_000, 1_000, 1)):
        shared = make_planner(PlannerChoice.FAST_DOWNWARD, 200, PlannerLimits(None, memory, tmp_path))
        assert isinstance(shared, FastDownward)
        assert (shared.cpu_seconds, shared.memory_mib) == (200, limit)
        assert shared.slots == (seats, tmp_path)


def test_fast_downward_is_asked_where_it_is_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FastDownward, "is_installed", lambda: True)
    assert resolve_automatic_choice(PlannerChoice.AUTO) is PlannerChoice.FULL
    monkeypatch.setattr(FastDownward, "is_installed", lambda: False)
    assert resolve_automatic_choice(PlannerChoice.AUTO) is PlannerChoice.BUILT_IN
    assert make_planner(PlannerChoice.AUTO, 200) == BuiltInPlanner()
    assert resolve_automatic_choice(PlannerChoice.NONE) is PlannerChoice.NONE


def test_a_verdict_names_the_planner(rules_with: MakeRules) -> None:
    planner = BuiltInPlanner(then=FastDownward(Path(), "1.0.0", 100, 4096))
    assert planner.name == "built-in search, then Fast Downward 1.0.0"
    for asked, name in ((BuiltInPlanner(), "built-in search"), (planner, planner.name), (None, None)):
        scorer = TransitionModelingScorer(TASK, rules_with(asked))
        assert scorer.score(answer(OPEN, LIGHT)).planner_name == name


def test_caches_of_rules_have_a_maximum_size(rules_with: MakeRules) -> None:
    rules = rules_with(None)
    scorer = TransitionModelingScorer(TASK, rules)
    length = 100_000
    texts = [
        answer(OperatorText("open", "(?o)", f"({number:x<{length}} ?o)", "(not (shut ?o))"))
        for number in range(MAX_CACHED_CHARACTERS // length + 2)
    ]
    first = scorer.score(texts[0])
    for text in texts:
        scorer.score(text)
    memories = [getattr(rules, name) for name in rules.__dataclass_fields__]
    sizes = [each.size for each in memories if isinstance(each, ResultCache)]
    assert MAX_CACHED_CHARACTERS - length - 1000 < max(sizes) <= MAX_CACHED_CHARACTERS
    assert scorer.score(texts[0]) == first  # computed again


CATEGORIES = {
    "open": PredicateCategory.OBJECT_STATES,
    "lit": PredicateCategory.OBJECT_STATES,
    "inside": PredicateCategory.SPATIAL_RELATIONS,
}
ONE = ConfusionCounts(1, 0, 0)


@pytest.mark.parametrize(
    ("clause", "by_clause", "by_predicate"),
    [
        ("(open ?x)", {"all": ONE, "object_states": ONE}, {"object_states": ONE}),
        (
            "(or (open ?x) (lit ?x))",  # both predicates have one category, so the clause counts once
            {"all": ONE, "object_states": ONE},
            {"object_states": ONE},
        ),
        (
            "(or (open ?x) (not (inside ?x ?y)))",
            {"all": ONE, "object_states": ONE, "spatial_relations": ONE},
            {"object_states": ONE, "spatial_relations": ONE},
        ),
        ("(shiny ?x)", {"all": ONE, "other": ONE}, {}),
        (
            "(or (shiny ?x) (open ?x))",
            {"all": ONE, "object_states": ONE, "other": ONE},
            {"object_states": ONE},
        ),
    ],
)
def test_a_clause_counts_once_in_every_category_of_its_predicates(
    clause: str, by_clause: dict[str, ConfusionCounts], by_predicate: dict[str, ConfusionCounts]
) -> None:
    side = ClauseComparison(matched=(clause,), additional=(), missing=())
    contents = {clause: find_predicates_and_their_categories(clause, CATEGORIES)}
    assert count_matches_by_category([side], contents, count_clauses=True) == by_clause
    assert count_matches_by_category([side], contents, count_clauses=False) == by_predicate


def test_matched_additional_and_missing_clauses_are_summed() -> None:
    sides = [
        ClauseComparison(("(open ?x)",), ("(lit ?x)", "(inside ?x ?y)"), ()),
        ClauseComparison((), ("(lit ?x)",), ("(open ?y)",)),
    ]
    texts = ("(open ?x)", "(lit ?x)", "(inside ?x ?y)", "(open ?y)")
    contents = {text: find_predicates_and_their_categories(text, CATEGORIES) for text in texts}
    assert count_matches_by_category(sides, contents, count_clauses=True) == {
        "all": ConfusionCounts(1, 3, 1),
        "object_states": ConfusionCounts(1, 2, 1),
        "spatial_relations": ConfusionCounts(0, 1, 0),
    }
    assert count_matches_by_category([], {}, count_clauses=True) == {}
