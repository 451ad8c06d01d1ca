"""Measures of statements about errors, goals and subgoals that need the answers of several suites."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable

from claim import Finding, Status, by_degree
from errors import stating
from evidence import AS, GI, GPT_4O, NAMED, PLANS, SD, TM, B, Evidence, Suite, V, below_zero, told
from measures_answers import RESULTS
from measures_rates import STRONG
from rates import all_of, if_so, most_of

from eai.abilities.subgoal_decomposition.verdict import SubgoalVerdict
from eai.benchmarks.registry import find_benchmark
from eai.results.comparison import compare_runs
from eai.results.lines import AnswerTableLine, PlanStepTableLine, compute_share_of_reached_goals
from eai.results.paper_tables import map_files_to_paper_models
from eai.studies.cofactors.effects import compute_rank_correlation

RESULTS_IN_BEHAVIOR = {
    "OPEN": ("open",),
    "CLOSE": ("not open",),
    "TOGGLE_ON": ("toggled_on",),
    "TOGGLE_OFF": ("not toggled_on",),
    "CLEAN": ("not dusty", "not stained"),
    "SOAK": ("soaked",),
    "SLICE": ("sliced",),
    "COOK": ("cooked",),
    "FREEZE": ("frozen",),
}
"""The literals that an action of BEHAVIOR makes true of its object."""

QUANTIFIER = re.compile(r"\b(forall|exists|forn|forpairs|fornpairs)\b")
LEADER, SECOND = "o1-preview", "Claude-3.5 Sonnet"
"""The models whose averages in BEHAVIOR the paper compares."""

P_LIMIT = 0.05
OFTEN = 0.5
"""Minimum share of models for a statement with “often”."""


def several_actions(evidence: Evidence) -> Finding:
    """Compare numbers of actions and subgoals of answers that are carried out to the end."""
    text, hits = [], []
    for domain in (V, B):
        verdicts = [
            record.verdict
            for records in evidence.suites[Suite(domain, SD)].values()
            for record in records
            if isinstance(record.verdict, SubgoalVerdict) and record.verdict.executable
        ]
        longer = sum(bool(verdict.added_actions) for verdict in verdicts)
        subgoals = sum(verdict.refined or 0 for verdict in verdicts)
        actions = subgoals + sum(verdict.added_actions or 0 for verdict in verdicts)
        hits.append((int(longer > 0), 1))
        text.append(
            f"{NAMED[domain]}: {longer:,} of {len(verdicts):,} executed answers have more actions than "
            f"subgoals, {actions / subgoals:.1f} actions for each subgoal"
        )
    return all_of(*hits, text="; ".join(text))


def search_limits(evidence: Evidence) -> Finding:
    """Count searches for the actions of subgoals that ended at a limit of ours."""
    ends = Counter(
        record.verdict.search
        for domain in (V, B)
        for records in evidence.suites[Suite(domain, SD)].values()
        for record in records
        if isinstance(record.verdict, SubgoalVerdict) and record.verdict.search is not None
    )
    return all_of(
        (ends["complete"], ends.total()),
        text=f"{ends['complete']:,} of {ends.total():,} searches for the models' subgoals are complete",
    )


def goals_already_reached(evidence: Evidence) -> Finding:
    """Count additional steps of plans and subgoals whose result is a goal of the task."""
    return _steps_to_reached_goals(evidence, PLANS)


def goals_already_reached_by_plans(evidence: Evidence) -> Finding:
    """Count additional steps of plans whose result is a goal of the task."""
    return _steps_to_reached_goals(evidence, (Suite(V, AS), Suite(B, AS)))


def _steps_to_reached_goals(evidence: Evidence, suites: Iterable[Suite]) -> Finding:
    text, counts = [], []
    for suite in suites:
        goals: dict[str, set[str]] = {}
        for goal in evidence.of(evidence.tables.goals, suite):
            goals.setdefault(goal.task, set()).add(goal.text)
        categories = {
            task.id: {each.name: each.category for each in task.scene.objects}
            for task in find_benchmark(suite.domain).tasks(evidence.published).values()
        }
        steps = [
            step for step in evidence.of(evidence.tables.steps, suite) if step.outcome == "additional_step"
        ]
        hits = sum(_brings_about(step, goals.get(step.task, ()), categories[step.task]) for step in steps)
        counts.append((hits, len(steps)))
        text.append(f"{suite} {hits:,} of {len(steps):,}")
    return most_of(*counts, text=f"additional steps whose result is a goal of the task: {'; '.join(text)}")


def variety_of_environments(evidence: Evidence) -> Finding:
    """Correlate the share of goals reached with the kinds of objects and of states at the start."""
    rows, below = [], []
    for suite in PLANS:
        kinds = _kinds_of_states(evidence, suite.domain)
        answers = [each for each in evidence.answers(suite) if _share(each) is not None]
        for name, values in (
            ("kinds of objects", [float(each.object_categories or 0) for each in answers]),
            ("kinds of states", [float(kinds[each.task]) for each in answers]),
        ):
            found = compute_rank_correlation(
                values, [_share(each) or 0 for each in answers], [each.name for each in answers]
            )
            below.append(below_zero(found))
            rows.append(f"{suite}, {name}: {told(found)}")
    return Finding(
        by_degree(all(below), any(below)),
        "rank correlations of the share of goals reached, below 0 with the whole "
        f"interval in {sum(below)} of "
        f"{len(below)}: {'; '.join(rows)}",
    )


def reporting_bias(evidence: Evidence) -> Finding:
    models = evidence.suites[Suite(B, GI)]
    table = stating(evidence, "serving_a_meal", "ontop(chicken", "table.")
    turkeys = [
        task.title
        for domain in (V, B)
        for task in find_benchmark(domain).tasks(evidence.published).values()
        if any("turkey" in each.name for each in task.scene.objects)
    ]
    return if_so(
        len(table) > OFTEN * len(models),
        f"{len(table)} of {len(models)} models put the chicken of serving_a_meal on the table; "
        f"released tasks with a turkey: {', '.join(turkeys) or 'none'}",
    )


def lead_of_o1(evidence: Evidence) -> Finding:
    """Compare the two models task by task; Claude-3.5 Sonnet's goals in VirtualHome cannot be read."""
    text, clear, number = [], Counter[str](), Counter[str]()
    for suite in (Suite(V, AS), Suite(V, SD), Suite(V, TM), *(Suite(B, each) for each in (GI, AS, SD, TM))):
        runs = {
            map_files_to_paper_models()[file]: records for file, records in evidence.suites[suite].items()
        }
        for metric, found in compare_runs(runs[SECOND], runs[LEADER]).differences.items():
            if found.percentage_points is None or found.p_value is None:
                continue
            number[suite.domain] += 1
            if found.percentage_points > 0 and found.p_value < P_LIMIT:
                clear[suite.domain] += 1
                name = metric.replace("_", " ").replace(".", " ")
                chance = "p < 0.001" if found.p_value < 0.001 else f"p = {found.p_value:.3f}"
                text.append(f"{suite}, {name} {found.percentage_points:+.1f} ({chance})")
    return Finding(
        by_degree(clear == number, bool(clear)),
        f"on the same tasks {LEADER} is ahead of {SECOND} with p < {P_LIMIT} in "
        f"{clear[V]} of {number[V]} rates "
        f"in VirtualHome and {clear[B]} of {number[B]} in BEHAVIOR: {'; '.join(text)}",
    )


def hallucinated_in_subgoals(evidence: Evidence) -> Finding:
    text, right = [], []
    for what, pattern in (("actions", r"is no predicate|is not an action"), ("objects", r"there is no ")):
        models = {
            map_files_to_paper_models()[file]
            for domain in (V, B)
            for file, records in evidence.suites[Suite(domain, SD)].items()
            for record in records
            if (error := record.verdict.error) is not None
            and error.kind.value == "hallucination"
            and re.search(pattern, error.detail)
        }
        hits = len(models.intersection(STRONG))
        right.append((hits, len(STRONG)))
        text.append(f"{what} or predicates {hits}" if what == "actions" else f"{what} {hits}")
    return most_of(
        *right, text=f"of {len(STRONG)} strong models with names that do not exist: {', '.join(text)}"
    )


def conditions_in_quantifiers(evidence: Evidence) -> Finding:
    suite = Suite(B, SD)
    alone = Counter(
        goal.kind
        for goal in evidence.of(evidence.tables.goals, suite, GPT_4O)
        if not QUANTIFIER.search(goal.text)
    )
    answers = evidence.answers(suite, GPT_4O)
    counts = {
        kind: (total - alone[kind], total)
        for kind in ("state", "relation")
        for total in [sum(getattr(each, f"ground_{kind}_goals") or 0 for each in answers)]
    }
    text = ", ".join(f"{hits} of {number} {kind} conditions" for kind, (hits, number) in counts.items())
    return most_of(*counts.values(), text=f"inside quantifiers are {text}")


def success_without_quantifiers(evidence: Evidence) -> Finding:
    """Compare BEHAVIOR's tasks with and without quantifiers with VirtualHome's tasks."""
    shares = {}
    for name, domain, quantified in (("without", B, False), ("with", B, True), ("VirtualHome", V, None)):
        answers = [
            each
            for each in evidence.answers(Suite(domain, SD))
            if quantified is None or bool(each.quantified_goals) == quantified
        ]
        shares[name] = 100 * sum(bool(each.success) for each in answers) / len(answers)
    gap, left = (shares["VirtualHome"] - shares[name] for name in ("with", "without"))
    return Finding(
        by_degree(left < gap / 4, left < gap / 2),
        f"subgoals succeed in {shares['with']:.1f} % of BEHAVIOR's answers with and "
        f"{shares['without']:.1f} % "
        f"without quantifiers, in {shares['VirtualHome']:.1f} % of VirtualHome's",
    )


def requirements_of_quantifiers(evidence: Evidence) -> Finding:
    goals: dict[str, list[str]] = {}
    for goal in evidence.of(evidence.tables.goals, Suite(B, SD), GPT_4O):
        goals.setdefault(goal.task, []).append(goal.text)
    named = sum(any(QUANTIFIER.search(text) for text in texts) for texts in goals.values())
    spatial = sum(
        any(QUANTIFIER.search(text) and re.search(r"\(\w+, ", text) for text in texts)
        for texts in goals.values()
    )
    temporal = sum(" then " in text for texts in goals.values() for text in texts)
    return most_of(
        (named, len(goals)),
        (max(spatial, temporal), len(goals)),
        text=f"of {len(goals)} tasks {named} have a quantifier, {spatial} one with a relation inside; "
        f"{temporal} goals of BEHAVIOR have a temporal operator",
    )


def pour(evidence: Evidence) -> Finding:
    """Call the answers an artefact if the tasks' own goals ask for the action."""
    tasks = find_benchmark(V).tasks(evidence.published)
    asked = {task.id for task in tasks.values() if any("POUR" in str(goal.formula) for goal in task.goals)}
    users = {
        file: {
            record.task_id
            for record in records
            if (error := record.verdict.error) is not None
            and error.kind.value == "hallucination"
            and "POUR" in error.detail
        }
        for file, records in evidence.suites[Suite(V, SD)].items()
    }
    own = users[GPT_4O]
    found = Counter(tasks[task].title for task in own)
    shown = ", ".join(f"{name} ({number})" for name, number in sorted(found.items())) or "no task"
    others = sum(asked <= ids for ids in users.values())
    status = by_degree(set(found) == {"Make coffee"}, "Make coffee" in found)
    return Finding(
        Status.ARTEFACT if own and own <= asked else status,
        f"{len(own)} answers: {shown}; the goals of exactly {len(asked)} tasks ask for "
        "POUR, which the question "
        f"does not offer, and {others} of {len(users)} models fail by it in all of them "
        "([erratum](errata.md) pour-not-offered)",
    )


def _brings_about(step: PlanStepTableLine, goals: Iterable[str], categories: dict[str, str]) -> bool:
    """Whether the result of an action is a goal, or is inside a goal on all objects of its kind."""
    if step.domain == V:
        return f"{RESULTS.get(step.operator)}({step.objects})" in goals
    literals = RESULTS_IN_BEHAVIOR.get(step.operator, ())
    kind = f": {categories.get(step.objects)}. "
    return any(
        re.search(rf"(?<!\w){'' if literal.startswith('not') else '(?<!not )'}{literal}\({name}\)", goal)
        for literal in literals
        for goal in goals
        for name in (re.escape(step.objects), r"\w" if kind in goal else re.escape(step.objects))
    )


def _kinds_of_states(evidence: Evidence, domain: str) -> dict[str, int]:
    """Return the number of predicates that hold of each task's relevant objects at the start."""
    return {
        task.id: len(
            {name for name, objects in task.initial.facts() if not {*objects}.isdisjoint(task.relevant)}
        )
        for task in find_benchmark(domain).tasks(evidence.published).values()
    }


def _share(answer: AnswerTableLine) -> float | None:
    """Return the share of goals that an answer reaches, or None if it is not known."""
    share = compute_share_of_reached_goals(answer)
    return share.numerator / share.denominator if share.denominator else None
