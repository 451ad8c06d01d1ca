"""Measures of statements about operators: their clauses, and results of planners."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection

from claim import Finding, by_degree
from evidence import GPT_4O, TM, B, Evidence, Suite, V
from rates import all_of, if_so

from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.pddl.planning import PlannerOutcome
from eai.studies.sensitivity.study import OVERALL

THREE = {"plug_in", "walk_towards", "switch_on"}
"""The operators of the paper's example of a mixture."""

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


def conditions_of_walking(evidence: Evidence) -> Finding:
    clauses = [
        each
        for each in evidence.of(evidence.tables.clauses, Suite(V, TM))
        if each.operator == "walk_towards" and "spatial_relations" in each.categories.split()
    ]
    counts = Counter(each.verdict for each in clauses)
    return if_so(
        counts["additional"] > 0 and counts["missing"] > 0,
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
    return _written(evidence, V, ("lie",), "precondition", "sittable")


def brush(evidence: Evidence) -> Finding:
    return _written(evidence, B, ("clean_stained_brush",), "effect", "stained")


def wearable(evidence: Evidence) -> Finding:
    records = [each for runs in evidence.suites[Suite(V, TM)].values() for each in runs]
    hits = sum("wearable" in each.response for each in records)
    return if_so(hits > 0, f"{hits} of {len(records):,} answers")


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
        f"in {len(broken)} of {len(asked)} problems plug_in alone breaks what all of GPT-4o's "
        "operators together solve, "
        f"in {len(exactly)} with exactly these three operators",
    )


def place_inside(evidence: Evidence) -> Finding:
    cells = evidence.sensitivity(B, [GPT_4O])
    rates = {
        operator: rate
        for (operator, category), rate in cells.items()
        if category == OVERALL and rate.denominator >= 20
    }
    order = sorted(rates, key=lambda name: rates[name].share or 0)
    rank, lowest, own = order.index("place_inside") + 1, rates[order[0]], rates["place_inside"]
    return if_so(
        rank == 1,
        f"GPT-4o's place_inside {own.numerator:g} of {own.denominator:g}, number {rank} from below; "
        "lowest of the frequent "
        f"ones is {order[0]}, {lowest.numerator:g} of {lowest.denominator:g}",
        in_part=rank <= 3,
    )


def rest_non_spatial(evidence: Evidence) -> Finding:
    return _rest(evidence, V, "non_spatial_relations", {"grab", "walk_towards"})


def rest_orientation(evidence: Evidence) -> Finding:
    return _rest(evidence, V, "object_orientation", {"turn_to", "walk_into", "walk_towards"})


def rest_behavior(evidence: Evidence) -> Finding:
    return _rest(evidence, B, "non_spatial_relations", {"release", "slice-carvingknife"}, 1.0)


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
        text=f"so of {hits} of {len(rates)} other operators of GPT-4o{f'; lower: {text}' if text else ''}",
    )


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


def _written(evidence: Evidence, domain: str, operators: Collection[str], side: str, word: str) -> Finding:
    clauses = [
        each
        for each in evidence.of(evidence.tables.clauses, Suite(domain, TM))
        if each.operator in operators and each.side == side
    ]
    answers = {(each.model, each.task) for each in clauses}
    wrong = {
        (each.model, each.task)
        for each in clauses
        if each.verdict == "additional" and word in each.predicates.split()
    }
    models = len({model for model, _ in wrong})
    return if_so(
        bool(wrong),
        f"{word} stands wrongly in the {side} in {len(wrong)} of {len(answers)} answers, of {models} models",
    )
