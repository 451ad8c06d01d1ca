"""Measures of statements that need single answers: errors, goals and steps."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator

from claim import Finding, by_degree
from errors import SEATED
from evidence import (
    AS,
    GI,
    GPT_4O,
    NAMED,
    PLANS,
    SD,
    TM,
    B,
    Evidence,
    Suite,
    V,
    below_zero,
    rate,
    rho_of_means,
    told,
)
from measures_questions import CHARACTERS_PER_TOKEN
from measures_rates import OPEN_MODELS, STRONG
from rates import all_of, if_so, most_of, rates_of

from eai.abilities.protocol import Ability
from eai.benchmarks.registry import find_benchmark
from eai.results.lines import AnswerTableLine
from eai.results.paper_tables import map_files_to_paper_models
from eai.results.record import Record

GRAMMAR = ("parsing", "hallucination", "argument_number")
RUNTIME = ("wrong_order", "missing_step", "affordance", "additional_step")
CLOSED = ("is_closed", "is_inside_something_that_is_closed")
FAMILIES = ("GPT", "Claude", "o1")
OTHERS = ("Llama 3 8B", "Mixtral 8x22B MoE")
"""The models whose format errors the paper sets against those of the families."""

PLYWOOD = ("laying_wood_floors", "bringing_in_wood")
"""The tasks whose plans lay plywood on a floor."""

RESULTS = {
    "PLUGIN": "PLUGGED_IN",
    "PLUGOUT": "PLUGGED_OUT",
    "OPEN": "OPEN",
    "CLOSE": "CLOSED",
    "SWITCHON": "ON",
    "SWITCHOFF": "OFF",
}
"""The state that an action of VirtualHome makes true."""

SIZES = {
    "goals": "ground_goals",
    "state goals": "ground_state_goals",
    "relation goals": "ground_relation_goals",
    "length": "annotated_steps",
}
"""Columns of answers with the size of the task, by their names in the paper."""

FRAME = re.compile(r"\s*(?:```(?:json)?)?\s*\{.*\}\s*(?:```)?\s*(?:<\|eot_id\|>)?\s*", re.DOTALL)
"""An answer that is JSON and nothing else, perhaps in a code fence and with an end token."""

LONG_PLAN = 5_000
"""Characters of a plan that is longer than almost all others."""

SMALLEST_WINDOW = 16_385
"""Tokens of the context of GPT-3.5-turbo, the smallest of the models with unreadable plans in BEHAVIOR."""


def hallucinations(evidence: Evidence) -> Finding:
    counts = {}
    for suite in PLANS:
        answers = evidence.answers(suite)
        counts[str(suite)] = sum(each.error_kind == "hallucination" for each in answers), len(answers)
    for domain in (V, B):
        goals = evidence.answers(Suite(domain, GI))
        counts[f"{NAMED[domain]}, goals"] = (
            sum(each.hallucinated or 0 for each in goals),
            sum(each.stated or 0 for each in goals),
        )
    text = "; ".join(f"{name} {hits:,} of {number:,}" for name, (hits, number) in counts.items())
    return if_so(all(hits for hits, _ in counts.values()), text)


def additional_at_the_start(evidence: Evidence) -> Finding:
    """Count additional steps whose action the answer had not taken before."""
    suite = Suite(V, SD)
    goals = {(each.task, each.text) for each in evidence.of(evidence.tables.goals, suite)}
    taken: set[tuple[str, str, str, str]] = set()
    at_start = wanted = number = 0
    for step in evidence.of(evidence.tables.steps, suite):
        key = (step.model, step.task, step.operator, step.objects)
        if step.outcome == "additional_step":
            number += 1
            if key not in taken:
                at_start += 1
                wanted += (step.task, f"{RESULTS.get(step.operator)}({step.objects})") in goals
        taken.add(key)
    return if_so(
        wanted > number / 2,
        f"of {number:,} additional steps of VirtualHome's subgoals {at_start:,} restore facts that held "
        f"at the start; {wanted:,} of these facts are goals of the task",
        in_part=at_start > number / 2,
    )


def additional_in_virtualhome(evidence: Evidence) -> Finding:
    return _most_frequent(evidence, V, SD, "additional_step")


def missing_in_behavior(evidence: Evidence) -> Finding:
    return _most_frequent(evidence, B, SD, "missing_step")


def missing_in_plans(evidence: Evidence) -> Finding:
    hits = [_first_in(evidence, domain, AS, "missing_step") for domain in (V, B)]
    return all_of(
        *hits,
        text=f"true for {hits[0][0]} of {hits[0][1]} models in VirtualHome, {hits[1][0]} of {hits[1][1]} "
        "in BEHAVIOR",
    )


def missing_and_wrong(evidence: Evidence) -> Finding:
    text, right = [], []
    for domain in (V, B):
        answers = evidence.answers(Suite(domain, AS))
        counts = {kind: _having(answers, kind) for kind in RUNTIME}
        order = sorted(counts, key=lambda kind: -counts[kind])
        right.append(set(order[:2]) == {"missing_step", "wrong_order"})
        shown = ", ".join(f"{kind.replace('_', ' ')} {counts[kind]:,}" for kind in order)
        text.append(f"{NAMED[domain]}, {len(answers):,} plans: {shown}")
    return Finding(by_degree(all(right), any(right)), "; ".join(text))


def additional_of_the_best(evidence: Evidence) -> Finding:
    hits = number = 0
    for suite in PLANS:
        for model in _files(STRONG):
            answers = evidence.answers(suite, model)
            counts = {kind: _having(answers, kind) for kind in RUNTIME}
            hits += max(counts, key=lambda kind: counts[kind]) == "additional_step"
            number += 1
    return all_of(
        (hits, number), text=f"of strong models most frequent in {hits} of {number} pairs of model and suite"
    )


def runtime_errors(evidence: Evidence) -> Finding:
    text, right = [], []
    for suite in PLANS:
        answers = evidence.answers(suite)
        grammar = sum(each.error_kind in GRAMMAR for each in answers)
        runtime = sum(each.error_kind in RUNTIME or bool(each.additional_steps) for each in answers)
        right.append((int(runtime > grammar), 1))
        text.append(f"{suite}: {runtime:,} runtime, {grammar:,} grammar")
    return all_of(*right, text="; ".join(text))


def intermediate(evidence: Evidence) -> Finding:
    """Compare the reasons of wrong goals; an intermediate goal holds on the way only."""
    text, first, some = [], [], []
    for domain in (V, B):
        wrong = [
            each for each in evidence.of(evidence.tables.atoms, Suite(domain, GI)) if each.verdict == "wrong"
        ]
        counts = Counter(each.reason or "not known" for each in wrong)
        shown = ", ".join(
            f"{name.replace('_', ' ')} {100 * n / len(wrong):.0f} %" for name, n in counts.most_common(4)
        )
        first.append(counts.most_common(1)[0][0] == "intermediate")
        some.append(counts["intermediate"] > 0)
        text.append(f"{NAMED[domain]}: {shown}, intermediate {counts['intermediate']:,} of {len(wrong):,}")
    return if_so(all(first), f"where wrong goals come from, {'; '.join(text)}", in_part=all(some))


def water_in_glass(evidence: Evidence) -> Finding:
    atoms = [
        each
        for each in evidence.of(evidence.tables.atoms, Suite(V, GI), GPT_4O)
        if each.name == "Drink"
        and each.verdict == "wrong"
        and re.match(r"INSIDE\(.*water.*(glass|cup)", each.atom)
    ]
    tasks = {each.task for each in atoms}
    examples = ", ".join(sorted({re.sub(r"\.\d+", "", each.atom) for each in atoms})) or "none"
    return if_so(
        bool(tasks), f"wrong goals of water inside a glass or cup in {len(tasks)} answers ({examples})"
    )


def chicken_of_gpt_4o(evidence: Evidence) -> Finding:
    stated = [
        each.atom
        for each in evidence.of(evidence.tables.atoms, Suite(B, GI), GPT_4O)
        if each.name == "serving_a_meal" and each.verdict == "wrong" and each.atom.startswith("ontop(chicken")
    ]
    return if_so(
        any("table" in atom for atom in stated), f"GPT-4o states {', '.join(stated) or 'no such goal'}"
    )


def unreadable_gpt_4o(evidence: Evidence) -> Finding:
    counts = [_unreadable(evidence, domain, GI, "GPT-4o") for domain in (V, B)]
    return all_of(*((n - bad, n) for bad, n in counts), text=_both(counts, "cannot be read"))


def unreadable_llama(evidence: Evidence) -> Finding:
    counts = [_unreadable(evidence, domain, GI, "Llama 3 8B") for domain in (V, B)]
    right = [abs(100 * bad / n - said) < 0.05 for (bad, n), said in zip(counts, (0.6, 2.0), strict=True)]
    return Finding(by_degree(all(right), any(right)), _both(counts, "cannot be read"))


def unreadable_opus(evidence: Evidence) -> Finding:
    counts = [_unreadable(evidence, domain, AS, "Claude-3 Opus") for domain in (V, B)]
    return all_of(*((n - bad, n) for bad, n in counts), text=_both(counts, "cannot be read"))


def unreadable(evidence: Evidence) -> Finding:
    text, models = [], set()
    for suite in (*PLANS, Suite(V, GI), Suite(B, GI), Suite(V, TM), Suite(B, TM)):
        counts = Counter[str]()
        for model, records in evidence.suites[suite].items():
            errors = (record.verdict.error for record in records)
            counts[model] = sum(error is not None and error.kind.value == "parsing" for error in errors)
            if counts[model] > 0.05 * len(records):
                models.add(model)
        text.append(f"{suite} {counts.total():,}")
    return most_of(
        (len(models), 18),
        text=f"{len(models)} of 18 models have a suite with more than 5 % unreadable answers; "
        f"unreadable in all: {', '.join(text)}",
    )


def explanations(evidence: Evidence) -> Finding:
    """Count answers with goals and subgoals that are more than their JSON."""
    models: dict[str, None] = {}
    text = []
    for suite in (Suite(V, GI), Suite(B, GI), Suite(V, SD), Suite(B, SD)):
        talking, number = Counter[str](), 0
        for model, records in evidence.suites[suite].items():
            number += len(records)
            talking[model] = sum(FRAME.fullmatch(each.response) is None for each in records)
            if talking[model] > 0.05 * len(records):
                models[map_files_to_paper_models()[model]] = None
        text.append(f"{suite} {talking.total():,} of {number:,}")
    return most_of(
        (len(models), 18),
        text=f"answers that are more than their JSON: {'; '.join(text)}; more than 5 % of a suite "
        f"in {len(models)} models ({', '.join(models)})",
    )


def grammar_of_goals(evidence: Evidence) -> Finding:
    shares = {}
    for name in evidence.names:
        bad = number = 0
        for domain in (V, B):
            answers = [
                each for model in _files([name]) for each in evidence.answers(Suite(domain, GI), model)
            ]
            bad += sum(each.error_kind == "parsing" for each in answers)
            number += len(answers)
        shares[name] = 100 * bad / number
    closed = {name: share for name, share in shares.items() if name not in OPEN_MODELS}
    worst = max(closed, key=lambda name: closed[name])
    others = {name: share for name, share in closed.items() if name != worst}
    return if_so(
        max(closed.values()) < shares["Llama 3 70B"],
        f"unreadable answers with goals: Llama 3 70B {shares['Llama 3 70B']:.1f} %, Llama 3 8B "
        f"{shares['Llama 3 8B']:.1f} %; "
        f"proprietary models up to {max(others.values()):.1f} %, but {worst} {closed[worst]:.1f} %",
        in_part=shares["Llama 3 8B"] > max(others.values()),
    )


def format_of_families(evidence: Evidence) -> Finding:
    counts = {
        name: tuple(_unreadable(evidence, domain, GI, name) for domain in (V, B)) for name in evidence.names
    }
    totals = {name: sum(bad for bad, _ in each) for name, each in counts.items()}
    named = {name: n for name, n in totals.items() if name.startswith(FAMILIES)}
    few = {name: n for name, n in named.items() if n <= 5}
    rest = ", ".join(f"{name} {n}" for name, n in named.items() if name not in few)
    return Finding(
        by_degree(
            len(few) == len(named) and min(totals[name] for name in OTHERS) > 5, len(few) > len(named) / 2
        ),
        f"of 442 answers with goals at most 5 cannot be read in {len(few)} of {len(named)} GPT, Claude "
        "and o1 models"
        f" (else {rest or 'none'}); Llama 3 8B {totals['Llama 3 8B']}, Mixtral {totals['Mixtral 8x22B MoE']}",
    )


def format_of_commercial(evidence: Evidence) -> Finding:
    """Count the proprietary models with at most five unreadable answers with goals."""
    totals = {
        name: sum(_unreadable(evidence, domain, GI, name)[0] for domain in (V, B))
        for name in evidence.names
        if name not in OPEN_MODELS
    }
    rest = ", ".join(f"{name} {n}" for name, n in totals.items() if n > 5)
    few = sum(n <= 5 for n in totals.values())
    return all_of(
        (few, len(totals)),
        text=f"of 442 answers with goals at most 5 cannot be read in {few} of {len(totals)} proprietary "
        f"models (else {rest or 'none'})",
    )


def grammar_in_behavior(evidence: Evidence) -> Finding:
    free = {
        kind: sum(
            not any(each.error_kind == kind for each in evidence.answers(Suite(B, SD), model))
            for model in evidence.suites[Suite(B, SD)]
        )
        for kind in ("parsing", "argument_number")
    }
    return most_of(
        *((n, 18) for n in free.values()),
        text=f"no unreadable answer: {free['parsing']} of 18 models; no wrong number of arguments: "
        f"{free['argument_number']}",
    )


def rinse(evidence: Evidence) -> Finding:
    return _errors_with(evidence, "argument_number", ("RINSE", "WASH"))


def rinse_hallucinated(evidence: Evidence) -> Finding:
    return _errors_with(evidence, "hallucination", ("RINSE",))


def sitting_in_wrong_orders(evidence: Evidence) -> Finding:
    errors = [each for each in evidence.answers(Suite(V, SD)) if each.error_kind == "wrong_order"]
    found = rate(errors, lambda each: each.error_check in SEATED)
    return if_so((found.value or 0) > 50, f"of VirtualHome's wrong orders in subgoals {told(found)}")


def closed_of_gpt_3_5(evidence: Evidence) -> Finding:
    errors = [
        each
        for each in evidence.answers(Suite(V, SD), "gpt-3.5-turbo-0125")
        if each.error_kind == "missing_step"
    ]
    checks = Counter(each.error_check for each in errors)
    closed = sum(n for check, n in checks.items() if check in CLOSED)
    (first, most), *_ = checks.most_common(1)
    return if_so(
        closed >= most,
        f"{closed} of {len(errors)} missing steps; most frequent cause: {(first or '').replace('_', ' ')}, "
        f"{most}",
        in_part=closed > 0,
    )


def quantified(evidence: Evidence) -> Finding:
    text, lower, clear = [], [], []
    for ability, name in ((SD, "subgoals"), (AS, "plans")):
        suite = Suite(B, ability)
        goals = evidence.of(evidence.tables.goals, suite)
        answers = evidence.answers(suite)
        shares = []
        for kind in (True, False):
            those = [each.satisfied for each in goals if _has_quantifier(each.text) == kind]
            tasks = [bool(each.success) for each in answers if bool(each.quantified_goals) == kind]
            shares.append((100 * sum(those) / len(those), 100 * sum(tasks) / len(tasks)))
        trend = rho_of_means(answers, "quantified_goals", lambda each: float(bool(each.success)))
        lower.append(all(a < b for a, b in zip(*shares, strict=True)))
        clear.append(below_zero(trend))
        text.append(
            f"{name}: goals met {shares[0][0]:.1f} against {shares[1][0]:.1f} %, tasks solved "
            f"{shares[0][1]:.1f} "
            f"against {shares[1][1]:.1f} %, rank correlation of success with their number {told(trend)}"
        )
    return Finding(
        by_degree(all(lower) and all(clear), any(lower)), f"with and without quantifiers, {'; '.join(text)}"
    )


def success_by_complexity(evidence: Evidence) -> Finding:
    """Correlate the success of plans with the size of tasks, over the mean of all models."""
    found = {
        f"{NAMED[domain]} {name}": rho_of_means(
            evidence.answers(Suite(domain, AS)), feature, lambda each: float(bool(each.success))
        )
        for domain in (V, B)
        for name, feature in SIZES.items()
    }
    falls = [below_zero(estimate) for estimate in found.values()]
    text = ", ".join(f"{name} {told(estimate)}" for name, estimate in found.items())
    return Finding(by_degree(all(falls), any(falls)), f"rank correlations of all models' success with {text}")


def spatial_left_out(evidence: Evidence) -> Finding:
    """Count models that leave out more than a tenth of the relation goals."""
    text, lost = [], []
    for world, domain in (("V", V), ("B", B)):
        recall = rates_of(evidence, world, "GI", "relation.recall")
        lost.append((sum(value < 90 for value in recall.values()), len(recall)))
        text.append(
            f"{NAMED[domain]}: {lost[-1][0]} of {len(recall)} models, recall {min(recall.values()):.0f} to "
            f"{max(recall.values()):.0f} %"
        )
    return most_of(*lost, text=f"more than a tenth of the relation goals is left out, {'; '.join(text)}")


def order_of_subgoal_errors(evidence: Evidence) -> Finding:
    answers = evidence.answers(Suite(V, SD))
    counts = {kind: _having(answers, kind) for kind in RUNTIME}
    rarer = max(counts["wrong_order"], counts["affordance"])
    ahead = [counts[kind] > rarer for kind in ("missing_step", "additional_step")]
    first = counts["additional_step"] == max(counts.values())
    shown = ", ".join(f"{kind.replace('_', ' ')} {number:,}" for kind, number in counts.items())
    return Finding(
        by_degree(all(ahead) and first, any(ahead)), f"answers with subgoals in VirtualHome: {shown}"
    )


def cut_off(evidence: Evidence) -> Finding:
    plans = [record for domain in (V, B) for record in _plans(evidence, domain) if _is_unreadable(record)]
    ends = sum(map(_is_open, plans))
    return if_so(
        ends > len(plans) / 2,
        f"of {len(plans)} unreadable plans {ends} have an open bracket at the end",
        in_part=ends > 0,
    )


def stopped_early(evidence: Evidence) -> Finding:
    """Look for short plans with open brackets, and for those of them that lack more than a last brace."""
    short, _, text = _open_plans(evidence)
    complete = sum(_is_json(each.rstrip().removesuffix("]") + "}]") for each in short)
    return if_so(
        complete < len(short),
        f"{text}; {complete} of the {len(short)} lack nothing but the last brace",
        in_part=bool(short),
    )


def too_long(evidence: Evidence) -> Finding:
    """Compare plans with open brackets, together with their questions, with the smallest context window."""
    _, long, text = _open_plans(evidence)
    question = max(
        len(f"{prompt.system or ''}{prompt.user}")
        for prompt in (find_benchmark(B).official_prompts(Ability(AS), evidence.published) or {}).values()
    )
    size = (question + max(map(len, long), default=0)) / CHARACTERS_PER_TOKEN
    return if_so(
        size > SMALLEST_WINDOW,
        f"{text}; with its question the longest has about {size / 1000:.0f} thousand tokens, "
        f"and the smallest context window of these models is {SMALLEST_WINDOW / 1000:.0f} thousand",
        in_part=bool(long),
    )


def _is_unreadable(record: Record) -> bool:
    """Return whether an answer cannot be read."""
    return record.verdict.error is not None and record.verdict.error.kind.value == "parsing"


def _is_json(text: str) -> bool:
    try:
        json.loads(text)
    except ValueError:
        return False
    return True


def _plans(evidence: Evidence, domain: str) -> Iterator[Record]:
    for records in evidence.suites[Suite(domain, AS)].values():
        yield from records


def _is_open(record: Record) -> bool:
    text = record.response
    return text.count("[") > text.count("]") or text.count("{") > text.count("}")


def _open_plans(evidence: Evidence) -> tuple[list[str], list[str], str]:
    """Return BEHAVIOR's plans with open brackets that are shorter and longer than most, and their lengths."""
    bad = [record.response for record in _plans(evidence, B) if _is_unreadable(record) and _is_open(record)]
    short = [text for text in bad if len(text) < LONG_PLAN]
    long = [text for text in bad if len(text) >= LONG_PLAN]
    told = (
        f"of {len(bad)} BEHAVIOR plans with an open bracket {len(short)} have less than {LONG_PLAN:,} "
        f"characters, {len(long)} have more, up to {max(map(len, bad), default=0):,}"
    )
    return short, long, told


def next_to_the_floor(evidence: Evidence) -> Finding:
    steps = [
        each
        for each in evidence.of(evidence.tables.steps, Suite(B, AS))
        if each.name in PLYWOOD and re.search("PLACE_NEXTTO room_floor", f"{each.operator} {each.objects}")
    ]
    right_hand = sum(each.operator == "RIGHT_PLACE_NEXTTO" for each in steps)
    models = {map_files_to_paper_models()[each.model] for each in steps}
    return if_so(
        right_hand > 0,
        f"{len(steps)} steps of {len(models)} models in {' and '.join(PLYWOOD)}, {right_hand} with the right "
        "hand",
        in_part=bool(steps),
    )


def plans_that_go_wrong(evidence: Evidence) -> Finding:
    text = []
    shares = []
    for suite in PLANS:
        found = rate(evidence.answers(suite), lambda each: not each.success)
        shares.append(found.value or 0)
        text.append(f"{suite}: {found.value:.0f} % fail")
    return if_so(
        all(share > 50 for share in shares), "; ".join(text), in_part=any(share > 50 for share in shares)
    )


def _first_in(evidence: Evidence, domain: str, ability: str, kind: str) -> tuple[int, int]:
    models = list(evidence.suites[Suite(domain, ability)])
    hits = 0
    for model in models:
        answers = evidence.answers(Suite(domain, ability), model)
        counts = {each: _having(answers, each) for each in RUNTIME}
        hits += max(counts, key=lambda name: counts[name]) == kind
    return hits, len(models)


def _most_frequent(evidence: Evidence, domain: str, ability: str, kind: str) -> Finding:
    hits, number = _first_in(evidence, domain, ability, kind)
    return Finding(by_degree(hits >= number - 1, hits > number / 2), f"true for {hits} of {number} models")


def _having(answers: Iterable[AnswerTableLine], kind: str) -> int:
    if kind == "additional_step":
        return sum(bool(each.additional_steps) for each in answers)
    return sum(each.error_kind == kind for each in answers)


def _unreadable(evidence: Evidence, domain: str, ability: str, name: str) -> tuple[int, int]:
    answers = [each for model in _files([name]) for each in evidence.answers(Suite(domain, ability), model)]
    return sum(each.error_kind == "parsing" for each in answers), len(answers)


def _files(names: Collection[str]) -> list[str]:
    return [file for file, name in map_files_to_paper_models().items() if name in names]


def _both(counts: Iterable[tuple[int, int]], what: str) -> str:
    (v, n), (b, m) = counts
    return f"VirtualHome {v} of {n} ({100 * v / n:.1f} %), BEHAVIOR {b} of {m} ({100 * b / m:.1f} %) {what}"


def _errors_with(evidence: Evidence, kind: str, actions: Collection[str]) -> Finding:
    errors = [
        each.verdict.error.detail
        for each in evidence.suites[Suite(V, AS)][GPT_4O]
        if each.verdict.error is not None and each.verdict.error.kind.value == kind
    ]
    named = {
        action
        for action in actions
        if any(re.search(rf"\b{action}\b", each, re.IGNORECASE) for each in errors)
    }
    shown = "; ".join(dict.fromkeys(errors)) or "none"
    return Finding(
        by_degree(len(named) == len(actions), bool(named)),
        f"GPT-4o's {kind.replace('_', ' ')} errors: {shown}",
    )


def _has_quantifier(text: str) -> bool:
    return re.search(r"\b(forall|exists|forn|forpairs|fornpairs)\b", text) is not None
