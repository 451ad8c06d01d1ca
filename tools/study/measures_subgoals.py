"""Measures of statements about errors in subgoals and plans, and about the conditions in their goals."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from statistics import median

from claim import Finding, by_degree
from errors import CLOSED, SEATED
from evidence import AS, GI, NAMED, PLANS, SD, B, Evidence, Suite, V, rho_of_means, told
from measures_rates import OPEN_MODELS, RUNTIME, SIZES
from rates import all_of, if_so, most_of, rank_of, rates_of

from eai.abilities.protocol import Ability
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.logic.choice import count_dnf_terms
from eai.results.lines import AnswerTableLine, compute_contribution_to_main_score
from eai.results.paper_tables import map_files_to_paper_models, read_published_scores

TOOLS = (
    "there_is_no_soaked_cleaning_tool_detergent_or_running_sink_for",
    "there_is_no_cleaning_tool_running_sink_or_dishwasher_for",
    "is_in_no_running_sink_and_no_teapot",
    "no_hand_holds_a_slicer",
)
"""The checks of BEHAVIOR that ask for a tool, a running sink or a knife."""

OTHERS_IN_RUNTIME = ("GPT-4-turbo", "Gemini 1.5 Pro", "Claude-3 Opus")
COMMON = 0.1
"""Minimum share of errors that counts as common."""

_QUANTIFIED = re.compile(r"\b(ForAll|Exists|Exactly|ForPairs)\(")
"""A quantifier in the text of a parsed formula."""

_READER = re.compile(r"^line \d+, column \d+: ")
"""The beginning of a message about a formula that cannot be read."""


def kinds_of_errors(evidence: Evidence) -> Finding:
    """Count each kind of error in plans and subgoals."""
    counts = Counter(
        each.error_kind for suite in PLANS for each in evidence.answers(suite) if each.error_kind
    )
    counts["additional_step"] = sum(
        bool(each.additional_steps) for suite in PLANS for each in evidence.answers(suite)
    )
    wanted = ("parsing", "hallucination", "argument_number", *RUNTIME)
    text = ", ".join(f"{kind.replace('_', ' ')} {counts[kind]:,}" for kind in wanted)
    return all_of(
        (sum(bool(counts[kind]) for kind in wanted), len(wanted)),
        text=f"plans and subgoals with errors: {text}",
    )


def harm_of_errors(evidence: Evidence) -> Finding:
    """Call an error critical if answers with it succeed less often than answers with other runtime errors."""
    answers = evidence.answers(Suite(V, SD))
    groups = {kind: [each for each in answers if each.error_kind == kind] for kind in RUNTIME[:3]}
    groups["additional_step"] = [each for each in answers if each.additional_steps]
    shares = {kind: _share([bool(a.success) for a in each]) for kind, each in groups.items()}
    text = ", ".join(f"{kind.replace('_', ' ')} {100 * share:.0f} %" for kind, share in shares.items())
    others = [share for kind, share in shares.items() if kind != "additional_step"]
    return if_so(
        shares["additional_step"] < min(others), f"answers with subgoals that succeed, by their error: {text}"
    )


def steps_after_additional(evidence: Evidence) -> Finding:
    """Count answers with an additional step that are carried out to the end."""
    counts = {}
    for suite in PLANS:
        those = [each for each in evidence.answers(suite) if each.additional_steps]
        counts[str(suite)] = sum(not each.executable for each in those), len(those)
    text = ", ".join(f"{name} {number - hits:,} of {number:,}" for name, (hits, number) in counts.items())
    return all_of(
        *counts.values(), text=f"answers with an additional step that are carried out to the end: {text}"
    )


def majority_of_missing(evidence: Evidence) -> Finding:
    """Compare missing steps with all runtime errors of BEHAVIOR's subgoals, model by model."""
    suite, hits, total = Suite(B, SD), 0, Counter[str]()
    for model in evidence.suites[suite]:
        counts = _runtime_counts(evidence.answers(suite, model))
        total.update(counts)
        hits += counts["missing_step"] > counts.total() / 2
    return most_of(
        (total["missing_step"], total.total()),
        (hits, len(evidence.suites[suite])),
        text=f"{total['missing_step']:,} of {total.total():,} runtime errors are missing steps; more than "
        f"half in {hits} of {len(evidence.suites[suite])} models",
    )


def reasons_of_missing_steps(evidence: Evidence) -> Finding:
    """Sort BEHAVIOR's missing steps in subgoals by the check that failed."""
    checks = Counter(
        each.error_check for each in evidence.answers(Suite(B, SD)) if each.error_kind == "missing_step"
    )
    number = checks.total()
    tools, closed = (sum(checks[name] for name in names) for names in (TOOLS, CLOSED))
    return Finding(
        by_degree(
            tools + closed > number / 2 and min(tools, closed) > COMMON * number, max(tools, closed) > 0
        ),
        f"of {number} missing steps {closed} ({100 * closed / number:.0f} %) find something closed, {tools} "
        f"({100 * tools / number:.0f} %) lack a tool, a running sink or a knife, {number - tools - closed} "
        "have other reasons",
    )


def closed_by_complexity(evidence: Evidence) -> Finding:
    """Correlate the share of models that overlook opening with the size of BEHAVIOR's tasks."""
    answers = evidence.answers(Suite(B, SD))
    found = {
        name: rho_of_means(answers, feature, lambda each: float(each.error_check in CLOSED))
        for name, feature in (("goals", "ground_goals"), ("steps", "annotated_steps"), ("objects", "objects"))
    }
    above = [estimate.low is not None and estimate.low > 0 for estimate in found.values()]
    text = ", ".join(f"{name} {told(estimate)}" for name, estimate in found.items())
    return Finding(
        by_degree(all(above), any(above)), f"rank correlations of overlooking a closed object with {text}"
    )


def unreadable_of_command_r(evidence: Evidence) -> Finding:
    details = [
        record.verdict.error.detail
        for record in evidence.suites[Suite(B, SD)]["cohere-command-r"]
        if record.verdict.error is not None and record.verdict.error.kind.value == "parsing"
    ]
    hits = sum(_READER.match(detail) is not None for detail in details)
    return most_of(
        (hits, len(details)),
        text=f"of its {len(details)} unreadable answers {hits} hold a formula that the reader of LTL refuses",
    )


def invented_predicates(evidence: Evidence) -> Finding:
    """Count models with an unknown predicate or action besides POUR in VirtualHome's subgoals."""
    counts = _hallucinations(evidence, V, r"is no predicate")
    pour = _hallucinations(evidence, V, r"POUR is no predicate")
    own = {model: counts[model] - pour[model] for model in counts if counts[model] > pour[model]}
    text = ", ".join(f"{model} {number}" for model, number in sorted(own.items(), key=lambda item: -item[1]))
    objects = _hallucinations(evidence, V, r"there is no ")
    return if_so(
        bool(own),
        f"unknown predicates or actions besides POUR: {text or 'none'}; answers with POUR {pour.total()}; "
        f"unknown objects {objects.total()}",
    )


def objects_of_llama(evidence: Evidence) -> Finding:
    """Rank Llama 3 8B by unknown objects in BEHAVIOR's subgoals."""
    counts = _hallucinations(evidence, B, r"there is no ")
    order = counts.most_common(3)
    return if_so(
        order[0][0] == "Llama 3 8B" and order[0][1] > order[1][1],
        f"answers with an unknown object: {', '.join(f'{name} {number}' for name, number in order)}",
        in_part=counts["Llama 3 8B"] > 0,
    )


def standup_left_out(evidence: Evidence) -> Finding:
    """Look for standing up in answers whose wrong order is due to a sitting or lying character."""
    suite = Suite(V, SD)
    texts = {
        (record.model, record.task_id): record.response
        for records in evidence.suites[suite].values()
        for record in records
    }
    wrong = [
        each
        for each in evidence.answers(suite)
        if each.error_kind == "wrong_order" and each.error_check in SEATED
    ]
    without = sum("STANDUP" not in texts[each.model, each.task].upper() for each in wrong)
    return most_of(
        (without, len(wrong)), text=f"{without} of {len(wrong)} such answers have no STANDUP at all"
    )


def solutions_of_quantifiers(evidence: Evidence) -> Finding:
    """Count the ways to meet each goal of BEHAVIOR that has a quantifier."""
    several = number = 0
    for task in find_benchmark(B).tasks(evidence.published).values():
        for goal in task.without_goals_over_time.goals:
            if _QUANTIFIED.search(str(goal.formula)):
                number += 1
                several += count_dnf_terms(goal.formula, task.scene.names_of_category) > 1
    return most_of(
        (several, number), text=f"{several} of {number} goals with a quantifier have several solutions"
    )


def conditions_counted_singly(evidence: Evidence) -> Finding:
    """Compare goals that are met with single conditions that are met, in BEHAVIOR's subgoals."""
    suite = read_published_scores("strict").suites[f"{B}/{SD}"]
    pairs = [
        (rates["total_goal"].percent or 0, rates["partial_success"].percent or 0)
        for model in suite.models
        for rates in [suite.find_rates(model)]
    ]
    lower = sum(goals < conditions for goals, conditions in pairs)
    means = [sum(each) / len(pairs) for each in zip(*pairs, strict=True)]
    return all_of(
        (lower, len(pairs)),
        text=f"under `strict` the share of goals met is below the share of single conditions met in {lower} "
        f"of {len(pairs)} models, {means[0]:.1f} against {means[1]:.1f} % on average",
    )


def goals_at_start_by_world(evidence: Evidence) -> Finding:
    """Ask whether worlds differ in goals that hold at the start as they do in additional steps."""
    text, shares, steps = [], [], []
    for domain in (V, B):
        answers = evidence.answers(Suite(domain, SD))
        lines = list({each.task: each for each in answers}.values())
        shares.append(
            sum(each.goals_at_start or 0 for each in lines) / sum(each.goals or 0 for each in lines)
        )
        steps.append(_share([bool(each.additional_steps) for each in answers]))
        text.append(
            f"{NAMED[domain]} {100 * shares[-1]:.1f} % of goals hold at the start, {100 * steps[-1]:.1f} % "
            "of answers have an additional step"
        )
    return if_so(
        shares[0] > 0.5 > shares[1],
        f"{'; '.join(text)}: in both worlds most goals do not hold at the start",
        in_part=shares[0] > shares[1],
    )


def unmet_preconditions(evidence: Evidence) -> Finding:
    """Count unmet preconditions, which are missing steps and wrong orders, among plans that stop."""
    counts = {}
    for domain in (V, B):
        stopped = [each for each in evidence.answers(Suite(domain, AS)) if each.error_kind]
        unmet = sum(each.error_kind in ("missing_step", "wrong_order") for each in stopped)
        counts[domain] = unmet, len(stopped)
    text = ", ".join(f"{NAMED[domain]} {hits:,} of {number:,}" for domain, (hits, number) in counts.items())
    return most_of(*counts.values(), text=f"plans that stop at an unmet precondition: {text}")


def mixed_in_runtime(evidence: Evidence) -> Finding:
    """Ask whether models are among the best five in some runtime errors and in the lower half in others."""
    text, mixed = [], []
    for name in OTHERS_IN_RUNTIME:
        ranks = [
            len(rates) + 1 - rank_of(rates, name)
            for world in "VB"
            for metric in RUNTIME
            for rates in [rates_of(evidence, world, "AS", metric)]
        ]
        mixed.append(min(ranks) <= 5 and max(ranks) > 9)
        text.append(f"{name} {', '.join(map(str, ranks))}")
    return Finding(
        by_degree(all(mixed), any(mixed)),
        f"ranks in four runtime errors of plans, VirtualHome first, 1 for the fewest: {'; '.join(text)}",
    )


def length_explains_worlds(evidence: Evidence) -> Finding:
    """Compare the worlds' shares of executed answers at annotated lengths that both have."""
    gaps, even = {}, {}
    for ability in (AS, SD):
        answers = {domain: evidence.answers(Suite(domain, ability)) for domain in (V, B)}
        gaps[ability] = _gap(answers)
        even[ability] = _gap_at_equal_length(answers)
    text = ", ".join(
        f"{ability.replace('_', ' ')} {100 * gaps[ability]:.1f} points, at equal lengths "
        f"{100 * even[ability]:.1f}"
        for ability in gaps
    )
    left = [even[ability] / gaps[ability] for ability in gaps]
    return Finding(
        by_degree(max(left) < 0.25, min(left) < 0.75), f"VirtualHome's lead in executed answers: {text}"
    )


def size_by_length(evidence: Evidence) -> Finding:
    """Ask whether a larger model leads by less in tasks with short annotated plans."""
    smaller, text = [], []
    for domain in (V, B):
        suite = Suite(domain, AS)
        limit = median(each.annotated_steps or 0 for each in evidence.answers(suite))
        leads = []
        for is_short in (True, False):
            shares = {
                name: _share([bool(a.success) for a in _answers_of(evidence, suite, name, limit, is_short)])
                for pair in SIZES
                for name in pair
            }
            leads.append(sum(shares[large] - shares[small] for large, small in SIZES) / len(SIZES))
        smaller.append(leads[0] < leads[1])
        text.append(
            f"{NAMED[domain]} {100 * leads[0]:+.1f} points in short tasks, {100 * leads[1]:+.1f} in long"
        )
    return Finding(
        by_degree(all(smaller), any(smaller)),
        f"mean lead of the larger of {len(SIZES)} pairs of models in plans: {'; '.join(text)}",
    )


def length_of_plans(evidence: Evidence) -> Finding:
    """Compare steps of executed plans with annotated steps, for Mistral Large and other models."""
    named = ("Mistral Large", "o1-preview", "Claude-3 Opus", "GPT-4o", "Gemini 1.5 Pro")
    files = {name: file for file, name in map_files_to_paper_models().items()}
    ratios = {}
    for name in named:
        answers = [each for each in evidence.answers(Suite(V, AS), files[name]) if each.executable]
        steps = sum(each.steps_tried or 0 for each in answers)
        ratios[name] = steps / sum(each.annotated_steps or 0 for each in answers)
    text = ", ".join(f"{name} {ratio:.2f}" for name, ratio in ratios.items())
    others = min(ratio for name, ratio in ratios.items() if name != named[0])
    return if_so(
        ratios[named[0]] < others - 0.01,
        f"steps per annotated step in executed VirtualHome plans: {text}",
        in_part=ratios[named[0]] <= others,
    )


def onfloor_left_out(evidence: Evidence) -> Finding:
    """Compare the recall of goals on the floor with that of other relations, over all models."""
    atoms = [
        each
        for each in evidence.of(evidence.tables.atoms, Suite(B, GI))
        if each.verdict in ("matched", "missing")
    ]
    names = ("onfloor", "inside", "ontop", "nextto", "under")
    recalls = {
        name: _share([each.verdict == "matched" for each in atoms if each.predicate == name])
        for name in names
    }
    text = ", ".join(f"{name} {100 * recalls[name]:.0f} %" for name in names)
    return if_so(
        recalls["onfloor"] == min(recalls.values()),
        f"goals of BEHAVIOR that models state: {text}",
        in_part=recalls["onfloor"] < recalls["inside"],
    )


def intermediate_by_openness(evidence: Evidence) -> Finding:
    """Call intermediate goals common if they are a tenth of a group's wrong goals."""
    text, shares = [], []
    for domain in (V, B):
        for is_open in (True, False):
            wrong = [
                each.reason
                for each in evidence.of(evidence.tables.atoms, Suite(domain, GI))
                if each.verdict == "wrong"
                and (map_files_to_paper_models()[each.model] in OPEN_MODELS) == is_open
            ]
            shares.append(wrong.count("intermediate") / len(wrong))
            kind = "open" if is_open else "proprietary"
            text.append(f"{NAMED[domain]}, {kind} models {100 * shares[-1]:.1f} %")
    return if_so(
        min(shares) >= COMMON,
        f"wrong goals that hold only in intermediate states: {', '.join(text)}",
        in_part=min(shares) > 0,
    )


def hallucinated_goals(evidence: Evidence) -> Finding:
    """Compare Llama 3 70B's goals that name something unknown with those of proprietary models."""
    shares = {}
    for file, name in map_files_to_paper_models().items():
        answers = [each for domain in (V, B) for each in evidence.answers(Suite(domain, GI), file)]
        shares[name] = sum(a.hallucinated or 0 for a in answers) / max(1, sum(a.stated or 0 for a in answers))
    closed = {name: share for name, share in shares.items() if name not in OPEN_MODELS}
    worst = max(closed, key=lambda name: closed[name])
    above = sum(share < shares["Llama 3 70B"] for share in closed.values())
    return if_so(
        above == len(closed),
        f"goals that name something unknown: Llama 3 70B {100 * shares['Llama 3 70B']:.2f} %, more than "
        f"{above} of {len(closed)} proprietary models, of which {worst} has most, "
        f"{100 * closed[worst]:.2f} %",
        in_part=above > len(closed) / 2,
    )


def f1_by_goals(evidence: Evidence) -> Finding:
    """Correlate the mean F1 of tasks over models with the number of their goals."""
    found = {
        domain: rho_of_means(evidence.answers(Suite(domain, GI)), "ground_goals", _f1) for domain in (V, B)
    }
    below = [each.high is not None and each.high < 0 for each in found.values()]
    text = ", ".join(f"{NAMED[domain]} {told(each)}" for domain, each in found.items())
    return Finding(
        by_degree(all(below), any(below)), f"rank correlation of F1 with the number of goals: {text}"
    )


def plywood_moved(evidence: Evidence) -> Finding:
    """Look for a step that ends a nearness of two pieces of plywood, in answers that miss such a goal."""
    suite = Suite(B, SD)
    executed = {(each.model, each.task) for each in evidence.answers(suite) if each.executable}
    wanted = {
        (goal.model, goal.task)
        for goal in evidence.of(evidence.tables.goals, suite)
        if not goal.satisfied and "plywood" in goal.text and "nextto" in goal.text
    } & executed
    records = {(r.model, r.task_id): r for runs in evidence.suites[suite].values() for r in runs}
    protocol = next(iter(records.values())).protocol
    scorer = open_suite(B, Ability.SUBGOAL_DECOMPOSITION, protocol, source=evidence.published)
    pair = re.compile(r"stands_by\(plywood_\d+, plywood_\d+\)")
    undone = [
        key
        for key in sorted(wanted)
        if any(
            pair.search(str(fact))
            for step in scorer.assess(key[1], records[key].response).explain().steps
            for fact in step.removed
        )
    ]
    names = sorted({map_files_to_paper_models()[model] for model, _ in undone})
    return if_so(
        bool(undone),
        f"a step separates two such pieces in {len(undone)} of {len(wanted)} executed answers that miss the "
        f"goal ({', '.join(names) or 'no model'})",
    )


def _hallucinations(evidence: Evidence, domain: str, pattern: str) -> Counter[str]:
    return Counter(
        map_files_to_paper_models()[record.model]
        for records in evidence.suites[Suite(domain, SD)].values()
        for record in records
        if (error := record.verdict.error) is not None
        and error.kind.value == "hallucination"
        and re.search(pattern, error.detail)
    )


def _runtime_counts(answers: Sequence[AnswerTableLine]) -> Counter[str]:
    counts = Counter(each.error_kind for each in answers if each.error_kind in RUNTIME[:3])
    counts["additional_step"] = sum(bool(each.additional_steps) for each in answers)
    return Counter({str(kind): number for kind, number in counts.items()})


def _answers_of(
    evidence: Evidence, suite: Suite, name: str, limit: float, is_short: bool
) -> list[AnswerTableLine]:
    file = next(file for file, paper in map_files_to_paper_models().items() if paper == name)
    return [
        each for each in evidence.answers(suite, file) if ((each.annotated_steps or 0) <= limit) == is_short
    ]


def _gap(answers: Mapping[str, Sequence[AnswerTableLine]]) -> float:
    return _share([bool(a.executable) for a in answers[V]]) - _share([bool(a.executable) for a in answers[B]])


def _gap_at_equal_length(answers: Mapping[str, Sequence[AnswerTableLine]]) -> float:
    """Return the gap between the worlds, bin by bin of five steps, weighted by BEHAVIOR's answers."""
    bins: dict[int, dict[str, list[bool]]] = {}
    for domain, lines in answers.items():
        for line in lines:
            own = bins.setdefault((line.annotated_steps or 0) // 5, {V: [], B: []})
            own[domain].append(bool(line.executable))
    both = [each for each in bins.values() if each[V] and each[B]]
    weight = sum(len(each[B]) for each in both)
    return sum((_share(each[V]) - _share(each[B])) * len(each[B]) for each in both) / weight


def _share(values: Sequence[bool]) -> float:
    return sum(values) / len(values) if values else 0.0


def _f1(answer: AnswerTableLine) -> float | None:
    share = compute_contribution_to_main_score(answer)
    return share.numerator / share.denominator if share.denominator else None
