"""Measures of statements about operators: their clauses, and results of planners."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable

from claim import Finding, by_degree
from evidence import GPT_4O, NAMED, TM, B, Evidence, Suite, V, below_zero, told
from rates import WORLDS, all_of, if_so, mean_of

from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.benchmarks.registry import find_benchmark
from eai.pddl.planning import PlannerOutcome
from eai.results.rate import Rate
from eai.studies.cofactors.effects import compute_rank_correlation
from eai.studies.sensitivity.study import OVERALL

THREE = {"plug_in", "walk_towards", "switch_on"}
"""The operators of the paper's example of a mixture."""

OF_VIRTUALHOME = {"plug_in": 0.09, "walk_towards": 0.63}
"""The rates that the paper's summary prints for VirtualHome as a whole."""

SPATIAL = "spatial_relations"
"""The category of spatial relations."""

NON_SPATIAL = "non_spatial_relations"
"""The category of other relations."""

NOTABLE = 5
"""Points by which two means have to differ notably."""

_CLEAN_BRUSH = re.compile(r"clean_stained_brush(?:(?!:action).)*\(not \(stained \?scrub_brush\)\)", re.DOTALL)
"""The operator with an effect on the brush."""

HIGH = 0.9
"""A share of solved problems that counts as nearly perfect or high."""


def plug_or_switch(evidence: Evidence) -> Finding:
    models = evidence.suites[Suite(V, TM)]
    plug = switch = number = 0
    for model in models:
        clauses = [
            each
            for each in evidence.of(evidence.tables.clauses, Suite(V, TM), model)
            if each.operator == "plug_in"
        ]
        written = Counter(
            each.clause for each in clauses if each.side == "precondition" and each.verdict != "missing"
        )
        tasks = len({each.task for each in clauses})
        number += tasks
        plug += min(tasks, written["has_plug"])
        switch += min(tasks, written["has_switch"])
    return Finding(
        by_degree(plug > number / 2 and switch < number / 10, plug > number / 2),
        f"of {number:,} answers with plug_in {plug:,} write has_plug as a clause of its precondition, "
        f"{switch:,} has_switch",
    )


def plugs_of_gpt_4o(evidence: Evidence) -> Finding:
    """Look for words of preconditions, in the annotation and in GPT-4o's operators."""
    library = next(iter(find_benchmark(V).operator_tasks(evidence.published).values())).domain
    gold = library.operators["plug_in"].precondition
    clauses = [
        each
        for each in evidence.of(evidence.tables.clauses, Suite(V, TM), GPT_4O)
        if each.side == "precondition" and each.verdict != "missing"
    ]
    asked = {
        operator: {each.task for each in clauses if each.operator == operator}
        for operator in ("plug_in", "switch_on")
    }
    plug, switch, plugged = (
        len({each.task for each in clauses if each.operator == operator and word in each.predicates.split()})
        for operator, word in (
            ("plug_in", "has_plug"),
            ("plug_in", "has_switch"),
            ("switch_on", "plugged_in"),
        )
    )
    tasks, others = len(asked["plug_in"]), len(asked["switch_on"])
    parts = [
        "has_plug" in gold and "has_switch" in gold,
        plug > tasks / 2 and switch < tasks / 2,
        plugged < others / 2,
    ]
    return Finding(
        by_degree(all(parts), any(parts)),
        f"the annotated precondition is {gold}; GPT-4o's plug_in has has_plug in {plug} and has_switch in "
        f"{switch} of {tasks} answers, its switch_on plugged_in in {plugged} of {others}",
    )


def conditions_of_walking(evidence: Evidence) -> Finding:
    clauses = [
        each
        for each in evidence.of(evidence.tables.clauses, Suite(V, TM))
        if each.operator == "walk_towards" and "spatial_relations" in each.categories.split()
    ]
    counts = Counter(each.verdict for each in clauses)
    wrong = counts["additional"] + counts["missing"]
    return if_so(
        wrong > counts["matched"],
        f"spatial clauses: {counts['matched']:,} right, {counts['additional']:,} too many, "
        f"{counts['missing']:,} missing",
    )


def grab(evidence: Evidence) -> Finding:
    """Compare names of predicates, because the gold clause is a whole disjunction."""
    models = evidence.suites[Suite(V, TM)]
    clauses = [
        each
        for each in evidence.of(evidence.tables.clauses, Suite(V, TM))
        if each.operator == "grab" and each.side == "precondition"
    ]
    answers = {(each.model, each.task) for each in clauses}
    written = [each for each in clauses if each.verdict != "missing"]
    closed = {
        (each.model, each.task) for each in written if {"closed", "obj_inside"} & set(each.predicates.split())
    }
    hands = {
        (each.model, each.task) for each in written if {"holds_rh", "holds_lh"} & set(each.predicates.split())
    }
    few = [len(each) < len(answers) / 3 for each in (closed, hands)]
    return Finding(
        by_degree(all(few), any(few)),
        f"of {len(answers):,} answers of {len(models)} models {len(closed)} write something of a "
        f"container, {len(hands)} of the hands",
    )


def lie(evidence: Evidence) -> Finding:
    """Count the answers that write one predicate too many and lack the other."""
    clauses = [
        each
        for each in evidence.of(evidence.tables.clauses, Suite(V, TM))
        if each.operator == "lie" and each.side == "precondition"
    ]
    found = {
        (verdict, word): {
            (each.model, each.task)
            for each in clauses
            if each.verdict == verdict and word in each.predicates.split()
        }
        for verdict, word in (("additional", "sittable"), ("missing", "lieable"))
    }
    swapped = found["additional", "sittable"] & found["missing", "lieable"]
    answers = {(each.model, each.task) for each in clauses}
    return if_so(
        bool(swapped),
        f"sittable stands in place of lieable in {len(swapped)} of {len(answers)} answers, of "
        f"{len({model for model, _ in swapped})} models",
    )


def brush(evidence: Evidence) -> Finding:
    """Read the texts, because clauses are listed without their arguments."""
    records = [
        record
        for records in evidence.suites[Suite(B, TM)].values()
        for record in records
        if "clean_stained_brush" in record.response
    ]
    wrong = [record for record in records if _CLEAN_BRUSH.search(record.response)]
    models = {record.model for record in wrong}
    return if_so(
        bool(wrong),
        f"true for {len(wrong)} of {len(records)} answers with clean_stained_brush, of {len(models)} models",
    )


def wearable(evidence: Evidence) -> Finding:
    library = next(iter(find_benchmark(V).operator_tasks(evidence.published).values())).domain
    is_known = "wearable" in {each.name for each in library.header.predicates}
    records = [each for runs in evidence.suites[Suite(V, TM)].values() for each in runs]
    hits = sum("wearable" in each.response for each in records)
    return if_so(
        hits > 0 and not is_known,
        f"written in {hits} of {len(records):,} answers; it is {'a' if is_known else 'no'} predicate of "
        "VirtualHome's domain",
    )


def mixtures(evidence: Evidence) -> Finding:
    """Compare GPT-4o's operators in VirtualHome, by the built-in planner."""
    solved = _solved_alone(evidence)
    trials = evidence.trials(V, GPT_4O)
    mixed = sum(trial.outcome == PlannerOutcome.SOLVED.value for trial in trials)
    own = sum(solved.values()) / len(solved)
    broken = {
        trial.task for trial in trials if trial.outcome != PlannerOutcome.SOLVED.value and solved[trial.task]
    }
    share = mixed / len(trials)
    return Finding(
        by_degree(share < own, bool(broken)),
        f"all gold operators solve all {len(solved)} problems by construction, all of GPT-4o's "
        f"{100 * own:.1f} %, one of GPT-4o's "
        f"among gold ones {100 * share:.1f} % of {len(trials)} mixtures; in {len(broken)} problems "
        "that GPT-4o's own "
        "operators solve a mixture fails",
    )


def mixture_of_three(evidence: Evidence) -> Finding:
    solved = _solved_alone(evidence)
    failed = {
        trial.task
        for trial in evidence.trials(V, GPT_4O)
        if trial.operator == "plug_in" and trial.outcome != PlannerOutcome.SOLVED.value
    }
    asked = {trial.task for trial in evidence.trials(V, GPT_4O) if trial.operator == "plug_in"}
    operators: dict[str, set[str]] = {}
    for trial in evidence.trials(V, GPT_4O):
        operators.setdefault(trial.task, set()).add(trial.operator)
    broken = {task for task in failed if solved[task]}
    exactly = {task for task in broken if operators[task] == THREE}
    return if_so(
        bool(exactly),
        f"{len(broken)} of {len(asked)} problems are solved with all of GPT-4o's operators, but not if only "
        f"plug_in is GPT-4o's; {len(exactly)} of these have exactly these three operators",
    )


def place_inside(evidence: Evidence) -> Finding:
    """Call it low if it breaks half of the problems, in part if it breaks more than other operators do."""
    cells = evidence.sensitivity(B, [GPT_4O])
    overall = {operator: rate for (operator, category), rate in cells.items() if category == OVERALL}
    own = overall.pop("place_inside")
    shares = {category: rate for (operator, category), rate in cells.items() if operator == "place_inside"}
    others = _pooled(overall.values())
    text = ", ".join(
        f"{name.replace('_', ' ')} {rate.numerator:g} of {rate.denominator:g}"
        for name, rate in shares.items()
    )
    return if_so(
        (own.share or 0) < 0.5,
        f"GPT-4o's place_inside: {text}; its other operators {100 * others:.1f} %",
        in_part=(own.share or 0) < others,
    )


def overall_rates(evidence: Evidence) -> Finding:
    """Compare the printed rates with all problems that ask for the operator."""
    cells = evidence.sensitivity(V, [GPT_4O])
    rates = {name: cells[name, OVERALL] for name in OF_VIRTUALHOME}
    right = [
        abs((rates[name].share or 0) - printed) < 0.005 + 1e-9 for name, printed in OF_VIRTUALHOME.items()
    ]
    text = ", ".join(
        f"{name} {rate.numerator:g} of {rate.denominator:g} = {rate.share:.2f}"
        for name, rate in rates.items()
    )
    return Finding(by_degree(all(right), any(right)), f"in all of VirtualHome GPT-4o's {text}")


def spatial_operators(evidence: Evidence) -> Finding:
    """Compare operators whose precondition, or effect, has a spatial relation with the others."""
    text, lower = [], []
    for domain in (V, B):
        rates = _overall(evidence, domain)
        for side in ("precondition", "effect"):
            spatial = {name for name in rates if _literals(evidence, domain, name, side, SPATIAL)}
            groups = [[rates[name] for name in rates if (name in spatial) == has] for has in (True, False)]
            shares = [_pooled(group) for group in groups]
            lower.append(shares[0] < shares[1])
            text.append(
                f"{NAMED[domain]}, in the {side} {100 * shares[0]:.1f} % "
                f"({len(groups[0])} operators) against "
                f"{100 * shares[1]:.1f} % ({len(groups[1])})"
            )
    return Finding(
        by_degree(all(lower), any(lower)),
        f"problems solved by GPT-4o's operators with and without a spatial relation: {'; '.join(text)}",
    )


def complexity_of_operators(evidence: Evidence) -> Finding:
    """Correlate the success of operators with the literals of their annotated preconditions."""
    text, below = [], []
    for domain in (V, B):
        rates = _overall(evidence, domain)
        names = list(rates)
        for kind, category in (("literals", None), ("spatial literals", SPATIAL)):
            found = compute_rank_correlation(
                [_literals(evidence, domain, name, "precondition", category) for name in names],
                [rates[name].share or 0 for name in names],
                names,
            )
            below.append(below_zero(found))
            text.append(f"{NAMED[domain]}, {kind} {told(found)}")
    return Finding(
        by_degree(all(below), any(below)),
        f"rank correlations of the success of GPT-4o's operators: {'; '.join(text)}",
    )


def rest_non_spatial(evidence: Evidence) -> Finding:
    return _rest(evidence, V, "non_spatial_relations", {"grab", "walk_towards"})


def rest_orientation(evidence: Evidence) -> Finding:
    return _rest(evidence, V, "object_orientation", {"turn_to", "walk_into", "walk_towards"})


def rest_affordance(evidence: Evidence) -> Finding:
    return _rest(evidence, V, "object_affordance", {"plug_in", "put_inside"})


def clauses_of_place_inside(evidence: Evidence) -> Finding:
    """Count answers that have the annotated clauses on place, grasp and hands; under half is a challenge."""
    hits, number = Counter[str](), Counter[str]()
    for each in evidence.of(evidence.tables.clauses, Suite(B, TM)):
        if each.operator == "place_inside" and each.verdict != "additional":
            number[f"{each.clause} in the {each.side}"] += 1
            hits[f"{each.clause} in the {each.side}"] += each.verdict == "matched"
    named = ("holding in the precondition", "inside in the effect", "handsfull in the effect")
    hard = [hits[name] < number[name] / 2 for name in named]
    text = ", ".join(f"{name} {hits[name]} of {number[name]}" for name in named)
    return Finding(by_degree(all(hard), any(hard)), f"operators place_inside with the right clause: {text}")


def disparity_in_space(evidence: Evidence) -> Finding:
    """Compare mean planner success in spatial and non-spatial relations; five points are notable."""
    means = {
        domain: [mean_of(evidence, world, "TM", f"{kind}.planner_success") for kind in (SPATIAL, NON_SPATIAL)]
        for world, domain in WORLDS.items()
    }
    wide = [abs(spatial - other) > NOTABLE for spatial, other in means.values()]
    text = "; ".join(f"{NAMED[domain]} {one:.1f} and {two:.1f} %" for domain, (one, two) in means.items())
    return Finding(
        by_degree(all(wide), any(wide)), f"mean planner success in spatial and non-spatial relations: {text}"
    )


def slice_alone(evidence: Evidence) -> Finding:
    cells = evidence.sensitivity(B, [GPT_4O])
    found = {
        category: rate
        for (operator, category), rate in cells.items()
        if operator == "slice" and category != OVERALL
    }
    text = ", ".join(
        f"{name.replace('_', ' ')} {rate.numerator:g} of {rate.denominator:g}" for name, rate in found.items()
    )
    none = [not rate.numerator for rate in found.values()]
    return Finding(
        by_degree(bool(none) and all(none), any(none)), f"GPT-4o's slice: {text or 'is asked for nowhere'}"
    )


def _rest(
    evidence: Evidence, domain: str, category: str, named: Collection[str], limit: float = HIGH
) -> Finding:
    cells = evidence.sensitivity(domain, [GPT_4O])
    rates = {
        operator: rate
        for (operator, place), rate in cells.items()
        if place == category and operator not in named
    }
    low = {name: rate for name, rate in rates.items() if (rate.share or 0) < limit}
    text = ", ".join(f"{name} {rate.numerator:g} of {rate.denominator:g}" for name, rate in low.items())
    hits = len(rates) - len(low)
    return all_of(
        (hits, len(rates)),
        text=f"true for {hits} of {len(rates)} other operators of GPT-4o{f'; lower: {text}' if text else ''}",
    )


def _overall(evidence: Evidence, domain: str) -> dict[str, Rate]:
    cells = evidence.sensitivity(domain, [GPT_4O])
    return {operator: rate for (operator, category), rate in cells.items() if category == OVERALL}


def _pooled(rates: Iterable[Rate]) -> float:
    known = list(rates)
    return sum(rate.numerator for rate in known) / sum(rate.denominator for rate in known)


def _literals(evidence: Evidence, domain: str, name: str, side: str, category: str | None) -> int:
    """Return the number of literals of a side of an annotated operator, of one category or of all."""
    library = next(iter(find_benchmark(domain).operator_tasks(evidence.published).values())).domain
    text = getattr(library.operators[name], side)
    kinds = {predicate: found.value for predicate, found in library.categories.items()}
    words = [word for word in re.findall(r"\(\s*([\w-]+)", text) if word in kinds]
    return sum(category in (None, kinds[word]) for word in words)


def _solved_alone(evidence: Evidence) -> dict[str, bool]:
    """Return whether GPT-4o's own operators solve each VirtualHome problem."""
    records = evidence.suites[Suite(V, TM)][GPT_4O]
    suite = evidence.planned_suite(V)
    solved = {}
    for record in records:
        verdict = suite.score(record.task_id, record.response)
        solved[record.task_id] = (
            isinstance(verdict, OperatorVerdict) and verdict.planner is PlannerOutcome.SOLVED
        )
    return solved
