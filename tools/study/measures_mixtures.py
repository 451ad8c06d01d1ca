"""Measures of statements about operators: how answers word them, and what a planner does with one of them."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Sequence
from math import log

from claim import Finding, by_degree
from evidence import GPT_4O, NAMED, SD, TM, B, Evidence, Suite, V
from measures_rates import CATEGORIES, first_place_columns
from rates import all_of, if_so, most_of, range_over_models, rates_of

from eai.benchmarks.registry import find_benchmark
from eai.pddl.planning import PlannerOutcome
from eai.results.paper_tables import map_files_to_paper_models, read_published_scores
from eai.studies.sensitivity.study import OperatorReplacementTrial
from eai.tasks.operator_task import OperatorLibrary, TransitionTask
from eai.tasks.task import PredicateCategory

O1 = "o1-preview-2024-09-12"
_WORD = re.compile(r"[a-z][a-z0-9_-]*")
_ACTION = re.compile(r"\(:action\s+")
_EFFECT = re.compile(r":effect(.*)", re.DOTALL)
_PARAMETERS = re.compile(r":parameters\s*\(([^)]*)\)", re.DOTALL)
_VARIABLE = re.compile(r"\?[\w-]+")
_BOUND = re.compile(r"(?:exists|forall)\s*\(([^)]*)\)")


def effect_of_grab(evidence: Evidence) -> Finding:
    """Count answers whose effect of grab names both hands."""
    hits, number = Counter[str](), Counter[str]()
    for model, records in evidence.suites[Suite(V, TM)].items():
        for record in records:
            for text in _actions(record.response, "grab"):
                effect = _EFFECT.search(text)
                number[model] += 1
                hits[model] += effect is not None and all(
                    word in effect[1] for word in ("holds_rh", "holds_lh")
                )
    (first, most), *_ = hits.most_common(1)
    matched = sum(
        each.operator == "grab" and each.side == "effect" and each.verdict == "matched"
        for each in evidence.of(evidence.tables.clauses, Suite(V, TM))
    )
    return if_so(
        hits.total() < number.total() / 10,
        f"{hits.total()} of {number.total():,} answers with grab name both hands in its effect, "
        f"{most} of {number[first]} of {map_files_to_paper_models()[first]}; annotated clauses of the "
        f"effect are matched {matched} times",
        in_part=hits.total() < number.total() / 2,
    )


def preconditions_left_out(evidence: Evidence) -> Finding:
    return _left_out(evidence, "precondition")


def effects_left_out(evidence: Evidence) -> Finding:
    return _left_out(evidence, "effect")


def hands_by_model(evidence: Evidence) -> Finding:
    """Count models that write a condition on hands or containers into most preconditions of grab."""
    suite = Suite(V, TM)
    counts = {}
    for what, words in (("hands", {"holds_rh", "holds_lh"}), ("a container", {"closed", "obj_inside"})):
        counts[what] = 0
        for model in evidence.suites[suite]:
            clauses = [
                each
                for each in evidence.of(evidence.tables.clauses, suite, model)
                if each.operator == "grab" and each.side == "precondition"
            ]
            writing = {
                c.task for c in clauses if c.verdict != "missing" and words & set(c.predicates.split())
            }
            counts[what] += len(writing) > len({c.task for c in clauses}) / 2
    text = ", ".join(f"{what} {number}" for what, number in counts.items())
    few = [number <= 18 / 4 for number in counts.values()]
    return Finding(
        by_degree(all(few), any(few)),
        f"models that write a condition in most answers with grab: {text} of 18",
    )


def missing_non_spatial(evidence: Evidence) -> Finding:
    """Ask whether the missing non-spatial clauses are those of operators with a condition or a quantifier."""
    library = _library(evidence, V)
    complex_ones = {
        name
        for name, text in library.operators.items()
        if re.search(r"\((when|exists|forall) ", f"{text.precondition} {text.effect}")
    }
    missing = Counter(
        each.operator
        for each in evidence.of(evidence.tables.clauses, Suite(V, TM))
        if each.verdict == "missing" and "non_spatial_relations" in each.categories.split()
    )
    hits = sum(number for name, number in missing.items() if name in complex_ones)
    text = ", ".join(f"{name} {number:,}" for name, number in missing.most_common(3))
    return most_of(
        (hits, missing.total()),
        text=f"{hits:,} of {missing.total():,} missing non-spatial clauses are in operators with a condition "
        f"or quantifier; most in {text}",
    )


def undeclared_room(evidence: Evidence) -> Finding:
    """Look for a variable of walk_towards that is neither a parameter nor bound, in GPT-4o's answers."""
    texts = [
        text
        for record in evidence.suites[Suite(V, TM)][GPT_4O]
        for text in _actions(record.response, "walk_towards")
    ]
    hits = sum(bool(_free_variables(text)) for text in texts)
    return if_so(
        hits == 0,
        f"the printed walk_towards uses ?room, which is no parameter; so do {hits} of {len(texts)} "
        "of GPT-4o's public answers",
    )


def devices_without_plug(evidence: Evidence) -> Finding:
    """Count problems with plug_in in which an unplugged device has a switch and no plug."""
    tasks = find_benchmark(V).operator_tasks(evidence.published).values()
    asked = [task for task in tasks if "plug_in" in task.operators]
    hits = sum(bool(_only_switched(task.problem_text)) for task in asked)
    return if_so(
        hits > len(asked) / 2,
        f"in {hits} of {len(asked)} problems with plug_in something unplugged has a switch and no plug",
        in_part=hits > 0,
    )


def plug_in_of_the_program(evidence: Evidence) -> Finding:
    """Ask whether the simulator plugs in what has a switch and no plug, as the annotated operator does."""
    steps = [
        step
        for step in evidence.of(evidence.tables.steps, Suite(V, SD))
        if step.operator == "PLUGIN" and "has no plug" in step.reason
    ]
    tasks = find_benchmark(V).tasks(evidence.published)
    switched = sum(
        tasks[step.task].initial.has("HAS_SWITCH", tasks[step.task].scene.index[step.objects])
        for step in steps
    )
    return if_so(
        switched == 0,
        f"the annotated plug_in accepts what has a switch; the program refuses PLUGIN of {switched:,} such "
        "objects in subgoals, since they have no plug",
    )


def first_in_planning(evidence: Evidence) -> Finding:
    columns = [("V", "TM", f"{name}.planner_success") for name in CATEGORIES]
    columns += [("B", "TM", f"{name}.planner_success") for name in (CATEGORIES[0], *CATEGORIES[3:])]
    hits, number = first_place_columns(evidence, "o1-preview", columns)
    return all_of((hits, number), text=f"o1-preview is first in {hits} of {number} rates of planner success")


def range_of_planning(evidence: Evidence) -> Finding:
    return range_over_models(evidence, "overall.planner_success", "planner success")


def strong_in_space(evidence: Evidence) -> Finding:
    """Compare planner success in spatial relations with that overall, for the five best models of a world."""
    text, lower = [], []
    for world in "VB":
        overall = rates_of(evidence, world, "TM", "overall.planner_success")
        spatial = rates_of(evidence, world, "TM", "spatial_relations.planner_success")
        best = sorted(overall, key=lambda name: -overall[name])[:5]
        lower.append(sum(spatial[name] < overall[name] for name in best))
        text.append(", ".join(f"{name} {spatial[name]:.1f} against {overall[name]:.1f}" for name in best))
    return all_of(
        *((hits, 5) for hits in lower),
        text=f"planner success in spatial relations against all, VirtualHome: {text[0]}; BEHAVIOR: {text[1]}",
    )


def mixtures_by_model(evidence: Evidence) -> Finding:
    """Compare one operator of a model among gold ones with all its own operators, by problems solved."""
    text, lower = [], []
    for domain in (V, B):
        shares = {}
        for model in evidence.suites[Suite(domain, TM)]:
            trials = evidence.trials(domain, model)
            own = evidence.percent(domain, TM, "overall.planner_success", map_files_to_paper_models()[model])
            shares[model] = 100 * _solved(trials), own or 0.0
        lower.append((sum(mixed < own for mixed, own in shares.values()), len(shares)))
        named = ", ".join(
            f"{map_files_to_paper_models()[model]} {shares[model][0]:.1f} against {shares[model][1]:.1f} %"
            for model in (GPT_4O, O1)
        )
        text.append(f"{NAMED[domain]} lower in {lower[-1][0]} of {lower[-1][1]} models ({named})")
    return all_of(
        *lower, text=f"mixtures with one operator of a model against its own set: {'; '.join(text)}"
    )


def consistency_of_o1(evidence: Evidence) -> Finding:
    """Ask whether o1-preview's own set solves more of BEHAVIOR's problems than mixtures do."""
    mixed = 100 * _solved(evidence.trials(B, O1))
    own = evidence.percent(B, TM, "overall.planner_success", "o1-preview") or 0.0
    return if_so(
        own > mixed,
        f"BEHAVIOR: its own operators together solve {own:.1f} % of problems, one of them among gold ones "
        f"{mixed:.1f} %; a set that is consistent only with itself would do the reverse",
    )


def errors_and_plans(evidence: Evidence) -> Finding:
    """Compare operators with and without missing or additional preconditions, each alone among gold ones."""
    trials = [
        trial
        for domain in (V, B)
        for m in evidence.suites[Suite(domain, TM)]
        for trial in evidence.trials(domain, m)
    ]
    groups = {
        what: [t for t in trials if pattern in t.errors]
        for what, pattern in (
            ("a missing precondition", "precondition:missing"),
            ("a missing effect", "effect:missing"),
            ("an additional precondition", "precondition:additional"),
        )
    }
    right = _solved([trial for trial in trials if not trial.errors])
    shares = {what: _solved(each) for what, each in groups.items()}
    text = ", ".join(f"{what} {100 * share:.1f} %" for what, share in shares.items())
    lower = [share < right - 0.1 for share in shares.values()]
    return Finding(
        by_degree(all(lower), any(lower)),
        f"problems solved with one operator of a model: without errors {100 * right:.1f} %, with {text}",
    )


def most_perfect(evidence: Evidence) -> Finding:
    """Count BEHAVIOR's operators of GPT-4o that break no problem, by category."""
    cells = evidence.sensitivity(B, [GPT_4O])
    counts = {}
    for kind in ("object_states", "spatial_relations", "non_spatial_relations"):
        shares = [rate.share for (_, category), rate in cells.items() if category == kind]
        counts[kind] = sum(share == 1 for share in shares), len(shares)
    text = ", ".join(f"{kind.replace('_', ' ')} {hits} of {n}" for kind, (hits, n) in counts.items())
    return most_of(*counts.values(), text=f"operators of GPT-4o that solve all problems: {text}")


def variation_of_operators(evidence: Evidence) -> Finding:
    """Compare the success of one operator of GPT-4o in different categories of tasks."""
    spans: dict[str, list[float]] = {}
    for domain in (V, B):
        for (operator, category), rate in evidence.sensitivity(domain, [GPT_4O]).items():
            if category in CATEGORIES and rate.share is not None:
                spans.setdefault(f"{NAMED[domain]}'s {operator}", []).append(100 * rate.share)
    wide = {name: values for name, values in spans.items() if max(values) - min(values) > 20}
    text = ", ".join(f"{name} {min(v):.0f} to {max(v):.0f} %" for name, v in wide.items())
    return if_so(
        len(wide) > len(spans) / 2,
        f"of {len(spans)} operators {len(wide)} vary by more than 20 points over categories: "
        f"{text or 'none'}",
        in_part=bool(wide),
    )


def preconditions_of_state_actions(evidence: Evidence) -> Finding:
    """Compare annotated preconditions of BEHAVIOR's actions on states with those of actions on places."""
    library = _library(evidence, B)
    predicates = {each.name for each in library.header.predicates}
    counts: dict[bool, list[int]] = {True: [], False: []}
    for name, text in library.operators.items():
        is_spatial = name.startswith(("place", "grasp", "release", "navigate"))
        words = [word for word in re.findall(r"\(\s*([\w-]+)", text.precondition) if word in predicates]
        counts[is_spatial].append(len(words))
    states, places = (sum(counts[kind]) / len(counts[kind]) for kind in (False, True))
    return if_so(
        states > places,
        f"predicates in a precondition: {states:.1f} of actions on states, {places:.1f} of others",
    )


def listed_predicates(evidence: Evidence) -> Finding:
    names = {each.name for each in _library(evidence, V).header.predicates}
    wanted = ("inside", "facing", "plugged_in", "closed", "grabbable", "has_switch")
    hits = [word for word in wanted if word in names]
    return all_of((len(hits), len(wanted)), text=f"declared examples: {', '.join(hits)}")


def categories_of_predicates(evidence: Evidence) -> Finding:
    kinds = {
        domain: sorted(
            {found.value.replace("_", " ") for found in _library(evidence, domain).categories.values()}
        )
        for domain in (V, B)
    }
    return if_so(len(kinds[V]) == 5, f"VirtualHome: {', '.join(kinds[V])}; BEHAVIOR: {', '.join(kinds[B])}")


def categories_by_weight(evidence: Evidence) -> Finding:
    """Compare released categories of tasks with those of the highest sums of inverse document frequencies."""
    counts = {}
    for domain in (V, B):
        tasks = find_benchmark(domain).operator_tasks(evidence.published).values()
        predicates = [_predicates_of(task) for task in tasks]
        frequency = Counter(name for names in predicates for name in names)
        hits = 0
        for task, names in zip(tasks, predicates, strict=True):
            weights: dict[PredicateCategory, float] = defaultdict(float)
            for name in sorted(names):
                weights[task.domain.categories[name]] += log(len(tasks) / frequency[name])
            lowest = min(weights[category] for category in task.categories)
            hits += all(weights[each] <= lowest + 1e-9 for each in weights.keys() - set(task.categories))
        counts[domain] = hits, len(tasks)
    text = ", ".join(f"{NAMED[domain]} {hits} of {number}" for domain, (hits, number) in counts.items())
    return all_of(*counts.values(), text=f"tasks whose released categories follow from these weights: {text}")


def plans_that_work(evidence: Evidence) -> Finding:
    """Count the plans found with models' operators that work with the true ones."""
    counts = {}
    for domain in (V, B):
        suite = read_published_scores("strict").suites[f"{domain}/{TM}"]
        rates = [suite.find_rates(model) for model in suite.models]
        counts[domain] = tuple(
            round(sum(rate[f"overall.{name}"].numerator for rate in rates))
            for name in ("plan_works", "planner_success")
        )
    text = ", ".join(f"{NAMED[domain]} {works:,} of {found:,}" for domain, (works, found) in counts.items())
    return all_of(*counts.values(), text=f"under `strict`, plans that work with the true operators: {text}")


def plans_of_gpt_4o(evidence: Evidence) -> Finding:
    """Count the plans found with GPT-4o's operators in VirtualHome that work with the true ones."""
    rates = read_published_scores("strict").suites[f"{V}/{TM}"].find_rates("GPT-4o")
    works, found = (round(rates[f"overall.{name}"].numerator) for name in ("plan_works", "planner_success"))
    return all_of(
        (works, found), text=f"under `strict` {works} of {found} such plans work with the true operators"
    )


def unknown_properties(evidence: Evidence) -> Finding:
    """Count answers with operators that use a predicate of no declaration."""
    text, shares = [], []
    for domain in (V, B):
        names = {each.name for each in _library(evidence, domain).header.predicates}
        written: dict[tuple[str, str], bool] = {}
        unknown = Counter[str]()
        for each in evidence.of(evidence.tables.clauses, Suite(domain, TM)):
            if each.verdict != "missing":
                others = [w for w in each.predicates.split() if _WORD.fullmatch(w) and w not in names]
                unknown.update(others)
                key = each.model, each.task
                written[key] = written.get(key, False) or bool(others)
        shares.append(sum(written.values()) / len(written))
        most = ", ".join(f"{word} {number}" for word, number in unknown.most_common(3))
        text.append(f"{NAMED[domain]} {sum(written.values())} of {len(written):,} ({most or 'none'})")
    return if_so(
        min(shares) > 0, f"answers with an unknown predicate: {'; '.join(text)}", in_part=max(shares) > 0
    )


def _actions(response: str, name: str) -> list[str]:
    """Return the texts of an operator in an answer."""
    parts = _ACTION.split(response.replace("\\n", "\n"))
    return [part for part in parts[1:] if re.match(rf"{name}\b", part)]


def _free_variables(text: str) -> set[str]:
    parameters = _PARAMETERS.search(text)
    known = set(_VARIABLE.findall(parameters[1] if parameters else ""))
    known |= {name for bound in _BOUND.findall(text) for name in _VARIABLE.findall(bound)}
    return set(_VARIABLE.findall(text)) - known


def _only_switched(problem: str) -> set[str]:
    facts = {
        word: set(re.findall(rf"\({word} (\w+)\)", problem))
        for word in ("has_switch", "has_plug", "plugged_out")
    }
    return (facts["has_switch"] & facts["plugged_out"]) - facts["has_plug"]


def _solved(trials: Sequence[OperatorReplacementTrial]) -> float:
    return sum(trial.outcome == PlannerOutcome.SOLVED.value for trial in trials) / max(1, len(trials))


def _predicates_of(task: TransitionTask) -> set[str]:
    library = task.domain
    texts = (library.operators[name] for name in task.operators)
    words = {word for text in texts for word in re.findall(r"\(\s*([\w-]+)", text.precondition + text.effect)}
    return words & library.categories.keys()


def _library(evidence: Evidence, domain: str) -> OperatorLibrary:
    return next(iter(find_benchmark(domain).operator_tasks(evidence.published).values())).domain


def _left_out(evidence: Evidence, side: str) -> Finding:
    """Call a side of operators hard if most models leave out more than half of its annotated clauses."""
    counts, text = [], []
    for domain in (V, B):
        shares = []
        for model in evidence.suites[Suite(domain, TM)]:
            verdicts = Counter(
                line.verdict
                for line in evidence.of(evidence.tables.clauses, Suite(domain, TM), model)
                if line.side == side
            )
            shares.append(verdicts["missing"] / (verdicts["missing"] + verdicts["matched"]))
        counts.append((sum(share > 0.5 for share in shares), len(shares)))
        text.append(
            f"{NAMED[domain]} {counts[-1][0]} of {len(shares)} models, "
            f"{100 * min(shares):.0f} to {100 * max(shares):.0f} %"
        )
    return most_of(
        *counts, text=f"more than half of the annotated clauses of {side}s are left out: {'; '.join(text)}"
    )
