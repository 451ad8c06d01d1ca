"""Claims on the errors that models make."""

from __future__ import annotations

from collections.abc import Sequence

from claim import Claim, Finding, Row, Status, by_degree
from evidence import AS, GI, GPT_4O, NAMED, PLANS, SD, TM, B, Evidence, Suite, V, rate, told

from eai.results.lines import AnswerTableLine, make_task_rate_contribution
from eai.results.paper_tables import map_files_to_paper_models
from eai.results.table import Estimate
from eai.tasks.share import Share

SEATED = ("the_character_is_sitting_or_lying",)
CLOSED = ("is_closed", "is_inside_something_that_is_closed")
RUNTIME = ("missing_step", "wrong_order", "affordance")


def shares(evidence: Evidence) -> Finding:
    rows = []
    answers = [each for suite in PLANS for each in evidence.answers(suite, GPT_4O)]
    kinds = {
        "missing step": lambda each: each.error_kind == "missing_step",
        "additional step": lambda each: bool(each.additional_steps),
        "any runtime error (missing step, wrong order, affordance)": lambda each: each.error_kind in RUNTIME,
        "any of these": lambda each: each.error_kind in RUNTIME or bool(each.additional_steps),
    }
    printed = ("19.5 % / 15.5 %", "14.2 % / 16.2 %", "", "45.2 % / 41.2 %")
    for (name, is_so), said in zip(kinds.items(), printed, strict=True):
        rows.append(Row(name, said, told(rate(answers, is_so))))
    return Finding(
        Status.CANNOT_BE_CHECKED,
        "The paper prints two sets of figures for one diagram and does not name their denominators. No "
        "subset or weighting of the suites that we tried has these proportions.",
        rows,
    )


def frequent(evidence: Evidence) -> Finding:
    rows, first, behind = [], [], []
    for suite in PLANS:
        answers = evidence.answers(suite)
        counts = {
            "missing step": rate(answers, lambda each: each.error_kind == "missing_step"),
            "additional step": rate(answers, lambda each: bool(each.additional_steps)),
            "wrong order": rate(answers, lambda each: each.error_kind == "wrong_order"),
            "affordance": rate(answers, lambda each: each.error_kind == "affordance"),
        }
        most = max(counts, key=lambda name: counts[name].value or 0)
        first.append(most)
        rarer = max(counts["wrong order"].value or 0, counts["affordance"].value or 0)
        behind.append(min(counts["missing step"].value or 0, counts["additional step"].value or 0) > rarer)
        rows += [Row(f"{suite}: {name}", "", told(each)) for name, each in counts.items()]
    additional = first.count("additional step")
    return Finding(
        by_degree(all(behind) and additional == len(first), any(behind) or additional > 0),
        f"Additional steps are the most frequent error in {additional} of four suites, and missing steps in "
        f"{first.count('missing step')}. Both are more frequent than wrong orders and affordance errors in "
        f"{sum(behind)} of four suites.",
        rows,
    )


def kinds_of_goals(evidence: Evidence) -> Finding:
    rows, most, nearly_all = [], [], []
    for suite in PLANS:
        answers = evidence.answers(suite)
        pooled = {kind: _goals(answers, kind) for kind in ("state", "relation")}
        models = list(evidence.suites[suite])
        ahead = sum(_is_ahead(evidence.answers(suite, model)) for model in models)
        so = ahead if suite.domain == V else len(models) - ahead
        most.append(so > len(models) / 2)
        nearly_all.append(so >= len(models) - 1)
        rows += [Row(f"{suite}: {kind} goals", "", told(each)) for kind, each in pooled.items()]
        what = f"{suite}: models with a higher rate for state goals"
        rows.append(Row(what, "", f"{ahead} of {len(models)}"))
    return Finding(
        by_degree(all(nearly_all), all(most)),
        f"The claimed order holds for most models in {sum(most)} of four suites. It holds for all models, or "
        f"all but one, in {sum(nearly_all)}. Pooled over models, only VirtualHome's subgoals show it "
        "clearly.",
        rows,
    )


def _goals(answers: Sequence[AnswerTableLine], kind: str) -> Estimate:
    return Estimate.from_task_rate_contributions(
        [
            make_task_rate_contribution(
                each, Share(getattr(each, f"{kind}_met") or 0, getattr(each, f"{kind}_total") or 0)
            )
            for each in answers
        ]
    )


def _is_ahead(answers: Sequence[AnswerTableLine]) -> bool:
    return (_goals(answers, "state").value or 0) > (_goals(answers, "relation").value or 0)


def seated(evidence: Evidence) -> Finding:
    return overlooked(evidence, V, SEATED, ("missing_step", "wrong_order"), "sitting or lying")


def closed(evidence: Evidence) -> Finding:
    return overlooked(evidence, B, CLOSED, ("missing_step",), "a closed object")


def overlooked(
    evidence: Evidence, domain: str, checks: Sequence[str], kinds: Sequence[str], name: str
) -> Finding:
    rows, highest = [], []
    for ability in (AS, SD):
        suite = Suite(domain, ability)
        errors = [each for each in evidence.answers(suite) if each.error_kind in kinds]
        found = rate(errors, lambda each: each.error_check in checks)
        others: dict[str | None, int] = {}
        for each in errors:
            if each.error_check not in checks:
                others[each.error_check] = others.get(each.error_check, 0) + 1
        highest.append((found.numerator or 0) > max(others.values(), default=0))
        rows.append(
            Row(f"{suite}: {name}, of all {' and '.join(kinds).replace('_', ' ')} errors", "", told(found))
        )
    return Finding(
        by_degree(all(highest), any(highest)),
        f"{name.capitalize()} is the most frequent reason in {sum(highest)} of two suites.",
        rows,
    )


def chicken(evidence: Evidence) -> Finding:
    table = stating(evidence, "serving_a_meal", "ontop(chicken", "table.")
    plate = stating(evidence, "serving_a_meal", "ontop(chicken", "plate.")
    models = list(evidence.suites[Suite(B, GI)])
    neither = [each for each in models if each not in (*table, *plate)]
    return Finding(
        by_degree(len(table) == len(models), False),
        f"Most models do, but not all. {_names(plate)} predict{'s' if len(plate) == 1 else ''} the plate. "
        f"{_names(neither)} predict{'s' if len(neither) == 1 else ''} neither. "
        "(The appendix says “many other models”.)",
        [
            Row("models that put the chicken on the table", "all", f"{len(table)} of {len(models)}"),
            Row("models that put it on a plate", "none", f"{len(plate)} of {len(models)}"),
        ],
    )


def sneakers(evidence: Evidence) -> Finding:
    goals = [
        each
        for each in evidence.of(evidence.tables.atoms, Suite(B, GI))
        if each.name == "cleaning_sneakers" and each.predicate == "onfloor"
    ]
    met = {each.model for each in goals if each.verdict == "matched"}
    elsewhere = {each.model for each in goals if each.verdict == "wrong" and "gym_shoe" in each.atom}
    models = list(evidence.suites[Suite(B, GI)])
    also = f" {_names(sorted(elsewhere))} states it for another floor." if elsewhere else ""
    return Finding(
        by_degree(not met, len(met) < len(models) / 2),
        f"No model states this goal.{also}" if not met else f"{_names(sorted(met))} state this goal.",
        [Row("models with the goal that the shoes are on the floor", "none", f"{len(met)} of {len(models)}")],
    )


def stating(evidence: Evidence, task: str, beginning: str, end: str) -> list[str]:
    atoms = evidence.of(evidence.tables.atoms, Suite(B, GI))
    said = {
        each.model
        for each in atoms
        if each.name == task
        and each.verdict != "missing"
        and each.positive
        and each.atom.startswith(beginning)
        and end in each.atom
    }
    return sorted(said)


def drinking(evidence: Evidence) -> Finding:
    suite = Suite(V, GI)
    answers = [each for each in evidence.answers(suite, GPT_4O) if each.name == "Drink"]
    atoms = [
        each
        for each in evidence.of(evidence.tables.atoms, suite, GPT_4O)
        if each.name == "Drink" and each.verdict == "wrong"
    ]
    rows, counts = [], {}
    for predicate, thing in (("OPEN", "freezer"), ("FULL", ""), ("GRABBED", "")):
        said = {each.task for each in atoms if each.predicate == predicate and thing in each.atom}
        counts[predicate] = len(said)
        what = f"answers with the wrong goal {predicate}({thing or '…'})"
        rows.append(Row(what, "", f"{len(said)} of {len(answers)}"))
    freezers = counts["OPEN"]
    return Finding(
        by_degree(freezers > 0, False),
        f"GPT-4o states an open freezer as a goal in {freezers} of {len(answers)} tasks about drinking. "
        "These tasks are nearly copies.",
        rows,
    )


def statements(evidence: Evidence) -> Finding:
    rows, right = [], []
    parts = (
        ("object_states", "effect", True),
        ("object_states", "precondition", False),
        ("spatial_relations", "precondition", True),
        ("spatial_relations", "effect", False),
    )
    for domain in (V, B):
        clauses = evidence.of(evidence.tables.clauses, Suite(domain, TM))
        for category, side, over in parts:
            those = [each for each in clauses if each.side == side and category in each.categories.split()]
            said = sum(each.verdict != "missing" for each in those)
            asked = sum(each.verdict != "additional" for each in those)
            ratio = said / asked
            right.append(ratio > 1 if over else ratio < 1)
            what = f"{NAMED[domain]}: {category.replace('_', ' ')} in {side}s, written / annotated"
            rows.append(
                Row(what, "more than 1" if over else "less than 1", f"{said:,}/{asked:,} = {ratio:.2f}")
            )
    return Finding(
        by_degree(all(right), any(right)),
        f"{sum(right)} of eight parts are confirmed: {sum(right[:4])} of four in VirtualHome and "
        f"{sum(right[4:])} of four in BEHAVIOR. In both, effects have too few spatial relations, and "
        "preconditions too few states.",
        rows,
    )


def _names(models: Sequence[str]) -> str:
    named = [map_files_to_paper_models().get(each, each) for each in models]
    return " and ".join([", ".join(named[:-1]), named[-1]] if len(named) > 1 else named) or "no model"


ALL_FOUR = frozenset(PLANS)

CLAIMS: Sequence[Claim] = (
    Claim(
        "B1",
        "Shares of GPT-4o's errors",
        "The introduction gives shares of GPT-4o's errors over four abilities and two simulators: 45.2 % "
        "trajectory feasibility, 19.5 % missing steps, 14.2 % additional steps. The appendix gives 41.2 %, "
        "15.5 % and 16.2 % for the same diagram.",
        "introduction; appendix, “Error analysis”",
        ALL_FOUR,
        "none, because the paper does not say what it counts",
        shares,
        "Our figures are shares of GPT-4o's answers with plans or subgoals.",
    ),
    Claim(
        "B2",
        "State goals are met more often than relation goals in VirtualHome, less often in BEHAVIOR",
        "In VirtualHome, state goals are met more often than relation goals. In BEHAVIOR, they are met less "
        "often. The main text says that object goals are generally easier.",
        "results, “Goal Satisfaction”; appendix",
        ALL_FOUR,
        "in all four suites, the claimed order holds for all models or all but one; in part if it holds for "
        "most models",
        kinds_of_goals,
        "The main text's general statement holds only in VirtualHome.",
    ),
    Claim(
        "B3",
        "Models overlook that the character sits or lies",
        "Models overlook that the character sits or lies, and leave out standing up (VirtualHome).",
        "introduction; appendix, “Subgoal Decomposition”",
        frozenset({Suite(V, AS), Suite(V, SD)}),
        "sitting or lying is the most frequent reason for a missing step or wrong order in both suites; in "
        "part if in one suite",
        seated,
        "The paper gives no number.",
    ),
    Claim(
        "B4",
        "Models do not open closed containers",
        "Models do not open a container before they fetch something from it (BEHAVIOR).",
        "introduction; appendix",
        frozenset({Suite(B, AS), Suite(B, SD)}),
        "a closed object is the most frequent reason for a missing step in both suites",
        closed,
        "The paper gives no number.",
    ),
    Claim(
        "B5",
        "All models put the chicken on the table",
        "In the task of serving a meal, all models state that the chicken must be on the table, and not on a "
        "plate.",
        "results, “Reporting Bias”",
        frozenset({Suite(B, GI)}),
        "all models put the chicken on the table",
        chicken,
    ),
    Claim(
        "B6",
        "No model states that the sneakers must be on the floor",
        "In the task of cleaning sneakers, no prediction has the goal that the shoes are on the floor.",
        "results, “Reporting Bias”",
        frozenset({Suite(B, GI)}),
        "no model states this goal",
        sneakers,
        "One task is an example, not a measure of a bias. For all tasks, see goal interpretation "
        "[by predicate](analyses.md#goals).",
    ),
    Claim(
        "B7",
        "Effects have too many states, preconditions too many relations",
        "Predicted operators have too many object states in effects and too few in preconditions. They have "
        "too few spatial relations in effects and too many in preconditions.",
        "results, “Transition Modeling”",
        frozenset({Suite(V, TM), Suite(B, TM)}),
        "all four parts are confirmed in both domains",
        statements,
    ),
    Claim(
        "B8",
        "Models state intermediate goals as final goals",
        "Some models state goals that must hold only in between, such as an open freezer for drinking.",
        "introduction; results, “Goal Interpretation”",
        frozenset({Suite(V, GI)}),
        "the paper's example occurs in an answer",
        drinking,
        "One example suffices, because the paper only says “sometimes”.",
    ),
    Claim(
        "B9",
        "Additional steps are the most frequent error, wrong orders and affordance errors are rare",
        "Missing steps and additional steps are more frequent than other errors. Additional steps are the "
        "most frequent error, also in the best models.",
        "results, “Trajectory Feasibility”",
        ALL_FOUR,
        "both statements hold in all four suites; in part if one of them holds in a suite",
        frequent,
        "An answer counts once for each kind of error that it has.",
    ),
)
