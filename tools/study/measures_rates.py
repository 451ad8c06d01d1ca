"""Measures of statements that need only the rates of the 18 models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from statistics import fmean

from claim import Finding, by_degree
from evidence import AS, GI, NAMED, SD, TM, B, Evidence, V
from rates import (
    AVERAGE,
    RateColumn,
    all_of,
    first_places,
    if_so,
    mean_of,
    most_of,
    pairs_of,
    printed_rates,
    range_over_models,
    rank_of,
    rates_of,
)

from eai.results.paper_tables import map_files_to_paper_models, read_paper_table, read_published_scores

OPEN_WEIGHT = ("Llama 3 8B", "Llama 3 70B", "Mistral Large", "Mixtral 8x22B MoE")
"""The models that the paper counts as open; Cohere's weights are open too."""

OPEN_MODELS = (*OPEN_WEIGHT, "Cohere Command R", "Cohere Command R+")
STRONG = (
    "Claude-3 Opus",
    "Claude-3.5 Sonnet",
    "GPT-4-turbo",
    "GPT-4o",
    "Gemini 1.5 Pro",
    "o1-mini",
    "o1-preview",
)
"""The models that the paper calls state of the art in one place or another."""

GRAMMAR = ("parsing", "hallucination", "argument_number")
RUNTIME = ("wrong_order", "missing_step", "affordance", "additional_step")
CATEGORIES = (
    "object_states",
    "object_orientation",
    "object_affordance",
    "spatial_relations",
    "non_spatial_relations",
)
FAMILIES = {
    "Claude-3 Opus": ("Claude-3 Haiku", "Claude-3 Sonnet"),
    "GPT-4o": ("GPT-3.5-turbo", "GPT-4-turbo"),
    "o1-preview": ("o1-mini",),
    "Mistral Large": ("Mixtral 8x22B MoE",),
}
"""The models that the paper names as better, and the others of their families."""

SIZES = (
    ("Llama 3 70B", "Llama 3 8B"),
    ("Cohere Command R+", "Cohere Command R"),
    ("Claude-3 Opus", "Claude-3 Sonnet"),
    ("Claude-3 Sonnet", "Claude-3 Haiku"),
    ("Gemini 1.5 Pro", "Gemini 1.5 Flash"),
    ("o1-preview", "o1-mini"),
)
"""Pairs of a larger and a smaller model of one maker; the size of Mistral Large is not published."""

BY_SIZE = ("Mixtral 8x22B MoE", "Cohere Command R+", "Llama 3 70B", "Cohere Command R", "Llama 3 8B")
"""The models of published size, from the largest to the smallest."""

AGES = (
    ("Claude-3.5 Sonnet", "Claude-3 Sonnet"),
    ("Gemini 1.5 Pro", "Gemini 1.0 Pro"),
    ("GPT-4-turbo", "GPT-3.5-turbo"),
    ("GPT-4o", "GPT-4-turbo"),
)
"""Pairs of a newer and an older edition of a model."""


def number_of_models(evidence: Evidence) -> Finding:
    models = {map_files_to_paper_models().get(name, name) for name in evidence.models}
    return if_so(len(models) == 18, f"public answers of {len(models)} models")


def number_of_runs(evidence: Evidence) -> Finding:
    runs = len(evidence.names) * len(evidence.suites)
    return if_so(runs == 180, f"{len(evidence.names)} models, two worlds and four abilities are {runs} runs")


def number_of_queries(evidence: Evidence) -> Finding:
    answers = len(evidence.tables.answers)
    return if_so(answers == 84_960, f"the public answers are {answers:,}, one a task and model")


def fifteen_models(evidence: Evidence) -> Finding:
    return if_so(len(evidence.names) == 15, f"the paper's tables have {len(evidence.names)} models")


def goals_below_half(evidence: Evidence) -> Finding:
    low = {world: _below(rates_of(evidence, world, "GI", "overall.f1"), 50) for world in "VB"}
    return most_of(
        low["V"],
        low["B"],
        text=f"F1 below 50 %: {_told(low['V'])} models in VirtualHome, {_told(low['B'])} in BEHAVIOR",
    )


def best_overall(evidence: Evidence) -> Finding:
    """Use the paper's table, because Claude-3.5 Sonnet's public goals cannot be read in VirtualHome."""
    named = {"o1-preview", "Claude-3.5 Sonnet", "Gemini 1.5 Pro"}
    text, right = [], []
    for domain in (V, B):
        rates = printed_rates(RateColumn(domain, "", AVERAGE))
        order = [name for _, name in sorted((-rate, name) for name, rate in rates.items())]
        right.append(set(order[:3]) == named)
        text.append(f"{NAMED[domain]}: {', '.join(f'{name} {rates[name]:.1f}' for name in order[:4])}")
    return Finding(by_degree(all(right), any(right)), f"first by the table's averages, {'; '.join(text)}")


def first_place_columns(evidence: Evidence, model: str, columns: Sequence[Sequence[str]]) -> tuple[int, int]:
    """Return in how many columns a model is first, and how many columns there are."""
    rates = [rates_of(evidence, *words) for words in columns]
    return sum(model in first_places(each) for each in rates), len(rates)


def first_places_of_o1(evidence: Evidence) -> Finding:
    columns = [(world, ability, metric) for world in "VB" for ability, metric in _OVERVIEW]
    hits = first_place_columns(evidence, "o1-preview", columns)
    return all_of(hits, text=f"o1-preview is first in {_told(hits)} columns of the overview")


def object_states(evidence: Evidence) -> Finding:
    columns = [
        *((world, "GI", "state.f1") for world in "VB"),
        *((world, ability, "state_goal") for world in "VB" for ability in ("AS", "SD")),
        *((world, "TM", f"object_states.{metric}") for world in "VB" for metric in ("f1", "planner_success")),
    ]
    hits = first_place_columns(evidence, "Gemini 1.5 Pro", columns)
    return Finding(
        by_degree(hits[0] > hits[1] / 2, hits[0] > 0),
        f"Gemini 1.5 Pro is first in {_told(hits)} rates about object states",
    )


def open_weight(evidence: Evidence) -> Finding:
    order = {world: _averages(evidence, world, OPEN_WEIGHT) for world in "VB"}
    right = [set(each[:2]) == {"Llama 3 70B", "Mistral Large"} for each in order.values()]
    return Finding(
        by_degree(all(right), any(right)),
        f"by average performance VirtualHome: {', '.join(order['V'])}; BEHAVIOR: {', '.join(order['B'])}",
    )


def commercial_gap(evidence: Evidence) -> Finding:
    gaps = []
    for world in "VB":
        rates = rates_of(evidence, world, "average")
        gaps.append(max(rates.values()) - max(rates[model] for model in OPEN_WEIGHT))
    return if_so(
        min(gaps) > 0, f"average performance: {gaps[0]:.1f} points in VirtualHome, {gaps[1]:.1f} in BEHAVIOR"
    )


def open_weight_operators(evidence: Evidence) -> Finding:
    return _first_of_open(
        evidence, "Mixtral 8x22B MoE", ("TM", "overall.f1"), ("TM", "overall.planner_success")
    )


def open_weight_goals(evidence: Evidence) -> Finding:
    return _first_of_open(evidence, "Llama 3 70B", ("GI", "overall.f1"))


def lead_of_llama(evidence: Evidence) -> Finding:
    """Call a lead of five points over the next open model large."""
    gaps = {}
    for world in "VB":
        rates = rates_of(evidence, world, "GI", "overall.f1")
        gaps[world] = rates["Llama 3 70B"] - max(rates[m] for m in OPEN_WEIGHT if m != "Llama 3 70B")
    return Finding(
        by_degree(min(gaps.values()) >= 5, max(gaps.values()) > 0),
        f"F1 of Llama 3 70B less that of the next of the four open models of the paper: VirtualHome "
        f"{gaps['V']:+.1f}, BEHAVIOR {gaps['B']:+.1f} points",
    )


def execution_by_world(evidence: Evidence) -> Finding:
    return _higher_in_virtualhome(evidence, ("AS", "execution_success"), ("SD", "execution_success"))


def plans_by_world(evidence: Evidence) -> Finding:
    return _higher_in_virtualhome(evidence, ("AS", "task_success"))


def subgoals_by_world(evidence: Evidence) -> Finding:
    return _higher_in_virtualhome(evidence, ("SD", "task_success"))


def goals_of_subgoals_by_world(evidence: Evidence) -> Finding:
    return _higher_in_virtualhome(evidence, ("SD", "state_goal"), ("SD", "relation_goal"))


def goals_by_world(evidence: Evidence) -> Finding:
    hits = pairs_of(evidence, ("B", "GI", "overall.f1"), ("V", "GI", "overall.f1"))
    return all_of(hits, text=f"true for {_told(hits)} models whose answers can be read")


def recall_of_relations(evidence: Evidence) -> Finding:
    hits = [
        pairs_of(evidence, (world, "GI", "state.recall"), (world, "GI", "relation.recall")) for world in "VB"
    ]
    return all_of(
        *hits, text=f"true for {_told(hits[0])} models in VirtualHome, {_told(hits[1])} in BEHAVIOR"
    )


def non_spatial(evidence: Evidence) -> Finding:
    return _lower_category(evidence, ("spatial_relations",), "non_spatial_relations", "f1")


def non_spatial_low(evidence: Evidence) -> Finding:
    rates = rates_of(evidence, "V", "TM", "non_spatial_relations.f1").values()
    return if_so(max(rates) < 20, f"F1 of {min(rates):.1f} to {max(rates):.1f} %")


def hardest_category(evidence: Evidence) -> Finding:
    counts = []
    for world, names in (("V", CATEGORIES), ("B", (CATEGORIES[0], *CATEGORIES[3:]))):
        rates = {name: rates_of(evidence, world, "TM", f"{name}.f1") for name in names}
        models = list(rates[names[0]])
        lowest = [min(names, key=lambda name, m=m: rates[name][m]) for m in models]  # type: ignore[misc]
        counts.append((lowest.count("non_spatial_relations"), len(models), lowest.count("spatial_relations")))
    (v, n, _), (b, m, spatial) = counts
    return most_of(
        (v, n),
        (b, m),
        text=f"lowest F1 of all categories: {v} of {n} models in VirtualHome, {b} of {m} in BEHAVIOR, "
        f"where {spatial} are lowest in spatial relations",
    )


def opus_spatial(evidence: Evidence) -> Finding:
    rates = rates_of(evidence, "V", "TM", "spatial_relations.f1")
    rank = rank_of(rates, "Claude-3 Opus")
    return if_so(
        rank > len(rates) / 2, f"{rates['Claude-3 Opus']:.1f} %, number {rank} of {len(rates)} in VirtualHome"
    )


def orientation(evidence: Evidence) -> Finding:
    means = {name: mean_of(evidence, "V", "TM", f"{name}.f1") for name in CATEGORIES}
    order = sorted(means, key=lambda name: means[name])
    rank = order.index("object_orientation") + 1
    text = ", ".join(f"{name.replace('_', ' ')} {means[name]:.0f}" for name in order)
    return if_so(rank == 1, f"mean F1 of the models in VirtualHome, from below: {text}", in_part=rank == 2)


def planner_orientation(evidence: Evidence) -> Finding:
    means = {name: mean_of(evidence, "V", "TM", f"{name}.planner_success") for name in CATEGORIES}
    order = sorted(means, key=lambda name: means[name])
    text = ", ".join(f"{name.replace('_', ' ')} {means[name]:.0f}" for name in order)
    return if_so(
        order[0] == "object_orientation",
        f"mean planner success in VirtualHome, from below: {text}",
        in_part=order[1] == "object_orientation",
    )


def planner_non_spatial(evidence: Evidence) -> Finding:
    return _lower_category(evidence, ("non_spatial_relations",), "spatial_relations", "planner_success")


def planner_of_two(evidence: Evidence) -> Finding:
    ranks = [
        (name, rank_of(rates_of(evidence, "V", "TM", f"{category}.planner_success"), name), category)
        for name, category in (
            ("GPT-4o", "non_spatial_relations"),
            ("Claude-3 Opus", "object_states"),
            ("Claude-3 Opus", "object_affordance"),
        )
    ]
    low = [rank > 9 for _, rank, _ in ranks]
    text = "; ".join(f"{name} is number {rank} in {kind.replace('_', ' ')}" for name, rank, kind in ranks)
    return Finding(by_degree(all(low), any(low)), f"{text}, of 18 in VirtualHome")


def low_in_operators(evidence: Evidence) -> Finding:
    named = ("Llama 3 8B", "Llama 3 70B", "Cohere Command R+")
    ranks = [
        (name, world, rank_of(rates_of(evidence, world, "TM", "overall.f1"), name))
        for world in "VB"
        for name in named
    ]
    low = sum(rank > 9 for *_, rank in ranks)
    text = ", ".join(f"{name} {world} {rank}" for name, world, rank in ranks)
    return all_of((low, len(ranks)), text=f"ranks by F1 of 18: {text}")


def range_of_operators(evidence: Evidence) -> Finding:
    return range_over_models(evidence, "overall.f1", "F1")


def plans_that_fail(evidence: Evidence) -> Finding:
    """Call a tenth of the plans many."""
    text, lost = [], []
    for domain in (V, B):
        suite = read_published_scores("strict").suites[f"{domain}/{TM}"]
        rates = [suite.find_rates(model) for model in suite.models]
        found = sum(each["overall.planner_success"].numerator for each in rates)
        works = sum(each["overall.plan_works"].numerator for each in rates)
        lost.append(works < 0.9 * found)
        text.append(f"{NAMED[domain]}: {works:g} of {found:g} plans work with the true operators")
    return if_so(all(lost), f"under `strict`, {'; '.join(text)}")


def gemini_close(evidence: Evidence) -> Finding:
    gaps = {}
    for world in "VB":
        for metric in ("precision", "recall", "f1"):
            rates = rates_of(evidence, world, "GI", f"overall.{metric}")
            gaps[world, metric] = max(rates.values()) - rates["Gemini 1.5 Pro"]
    near = sum(gap <= 5 for gap in gaps.values())
    (world, metric), worst = max(gaps.items(), key=lambda item: item[1])
    return all_of(
        (near, len(gaps)),
        text=f"at most 5 points behind in {near} of {len(gaps)}; {worst:.1f} points in {metric} ({world})",
    )


def over_91(evidence: Evidence) -> Finding:
    rates = rates_of(evidence, "V", "SD", "state_goal")
    named = ("GPT-4-turbo", "Gemini 1.5 Flash", "o1-preview")
    text = ", ".join(f"{name} {rates[name]:.1f} %" for name in named)
    return all_of((sum(rates[name] > 91 for name in named), 3), text=text)


def over_80(evidence: Evidence) -> Finding:
    rates = rates_of(evidence, "V", "SD", "total_goal")
    hits = sum(rates[name] > 80 for name in STRONG), len(STRONG)
    return most_of(
        hits,
        text=f"true for {_told(hits)} strong models, and {sum(r > 80 for r in rates.values())} of all 18",
    )


def llama_below_70(evidence: Evidence) -> Finding:
    rates = [rates_of(evidence, "V", "SD", f"{kind}_goal")["Llama 3 8B"] for kind in ("relation", "action")]
    return if_so(max(rates) < 70, f"{rates[0]:.1f} % and {rates[1]:.1f} %")


def missing_in_half(evidence: Evidence) -> Finding:
    rates = rates_of(evidence, "B", "SD", "missing_step")
    hits = sum(rate > 50 for rate in rates.values()), len(rates)
    return most_of(hits, text=f"true for {_told(hits)} models")


def additional_by_world(evidence: Evidence) -> Finding:
    return _higher_in_virtualhome(evidence, ("SD", "additional_step"))


def all_make_additional(evidence: Evidence) -> Finding:
    rates = rates_of(evidence, "V", "SD", "additional_step")
    least = min(rates, key=lambda name: rates[name])
    return all_of(
        (sum(rate > 0 for rate in rates.values()), len(rates)),
        text=f"from {rates[least]:.1f} % ({least}) to {max(rates.values()):.1f} %; GPT-4o "
        f"{rates['GPT-4o']:.1f} %, "
        f"Claude-3 Opus {rates['Claude-3 Opus']:.1f} %",
    )


def action_goals(evidence: Evidence) -> Finding:
    rates = [rates_of(evidence, "V", "AS", f"{kind}_goal") for kind in ("state", "relation", "action")]
    low = sum(rates[2][name] < min(rates[0][name], rates[1][name]) for name in rates[2])
    return most_of(
        (low, len(rates[2])), text=f"met least of the three kinds in {low} of {len(rates[2])} models"
    )


def closed_in_behavior(evidence: Evidence) -> Finding:
    rates = rates_of(evidence, "B", "AS", "task_success")
    best = max(rates[name] for name in OPEN_MODELS)
    above = sum(rate > best for name, rate in rates.items() if name not in OPEN_MODELS)
    return most_of(
        (above, 18 - len(OPEN_MODELS)),
        text=f"{above} of {18 - len(OPEN_MODELS)} closed models exceed every open one",
    )


def half_of_behavior(evidence: Evidence) -> Finding:
    rates = rates_of(evidence, "B", "AS", "task_success")
    above = sorted((name for name in rates if rates[name] > 50), key=lambda name: -rates[name])
    text = ", ".join(f"{name} {rates[name]:.0f} %" for name in above)
    return if_so(max(rates.values()) < 55, f"above half: {text}")


def grammar_in_families(evidence: Evidence) -> Finding:
    return _fewer_grammar_errors(
        evidence, [(better, other) for better, others in FAMILIES.items() for other in others]
    )


def grammar_by_size(evidence: Evidence) -> Finding:
    return _fewer_grammar_errors(evidence, SIZES)


def grammar_by_age(evidence: Evidence) -> Finding:
    return _fewer_grammar_errors(evidence, AGES, is_tendency=True)


def runtime_by_world(evidence: Evidence) -> Finding:
    sums = {world: _sums(evidence, world, "AS", RUNTIME[:3]) for world in "VB"}
    hits = sum(sums["V"][name] < sums["B"][name] for name in sums["V"]), len(sums["V"])
    return all_of(hits, text=f"true for {_told(hits)} models (without additional steps)")


def fewest_runtime_errors(evidence: Evidence) -> Finding:
    first = []
    for world in "VB":
        sums = _sums(evidence, world, "AS", RUNTIME)
        order = sorted(sums, key=lambda name: sums[name])
        first.append((order.index("o1-preview") + 1, order[0], sums[order[0]], sums["o1-preview"]))
    text = "; ".join(
        f"{world}: number {rank} with {own:.1f} points of errors, first is {name} with {best:.1f}"
        for world, (rank, name, best, own) in zip(("VirtualHome", "BEHAVIOR"), first, strict=True)
    )
    return all_of((sum(rank == 1 for rank, *_ in first), 2), text=text)


def strong_in_runtime(evidence: Evidence) -> Finding:
    named = ("o1-preview", "GPT-4-turbo", "Gemini 1.5 Pro", "Claude-3 Opus")
    hits = number = 0
    for world in "VB":
        for metric in RUNTIME:
            rates = rates_of(evidence, world, "AS", metric)
            worst = max(rates[name] for name in named)
            hits += all(worst <= rate for name, rate in rates.items() if name not in named)
            number += 1
    return all_of(
        (hits, number), text=f"in {hits} of {number} rates no other model is better than one of the four"
    )


def good_at_relations(evidence: Evidence) -> Finding:
    named = ("Claude-3 Sonnet", "Mistral Large")
    ranks = [
        (name, world, rank_of(rates_of(evidence, world, "AS", "relation_goal"), name))
        for name in named
        for world in "VB"
    ]
    text = ", ".join(f"{name} {world} {rank}" for name, world, rank in ranks)
    return all_of((sum(rank <= 3 for *_, rank in ranks), 4), text=f"ranks of 18: {text}")


def o1_state_over_relation(evidence: Evidence) -> Finding:
    rates = [
        (
            rates_of(evidence, world, "AS", "state_goal")["o1-preview"],
            rates_of(evidence, world, "AS", "relation_goal")["o1-preview"],
        )
        for world in "VB"
    ]
    text = " and ".join(f"{state:.1f} against {relation:.1f} %" for state, relation in rates)
    return all_of((sum(state > relation for state, relation in rates), 2), text=text)


def size_order(evidence: Evidence) -> Finding:
    pairs = tuple(dict.fromkeys((*SIZES, *combinations(BY_SIZE, 2))))
    against = []
    for world, domain in (("V", V), ("B", B)):
        for metric in ("task_success", "execution_success"):
            rates = rates_of(evidence, world, "AS", metric)
            against += [
                f"{small} above {large} in {metric.replace('_', ' ')}, {NAMED[domain]}"
                for large, small in pairs
                if rates[small] > rates[large]
            ]
    return if_so(
        bool(against),
        f"the smaller model leads in {len(against)} of {4 * len(pairs)} comparisons of plans: "
        f"{'; '.join(against) or 'none'}",
    )


def wrong_order_by_openness(evidence: Evidence) -> Finding:
    rates = rates_of(evidence, "V", "SD", "wrong_order")
    means = [
        fmean(rate for name, rate in rates.items() if (name in OPEN_WEIGHT) == is_open)
        for is_open in (True, False)
    ]
    return if_so(means[0] > means[1], f"mean of open models {means[0]:.1f} %, of the others {means[1]:.1f} %")


def replanning_rates(evidence: Evidence) -> Finding:
    table = read_paper_table("replanning")
    plain, again = (table.rows[name] for name in ("GPT-4o", "GPT-4o w/ replanning"))
    worse, same = [], []
    for column in table.columns:
        if column.metric in ("task_success", "execution_success"):
            continue
        before, after = plain[column] or 0, again[column] or 0
        (worse if after > before else same if after == before else []).append(column.metric.replace("_", " "))
    return if_so(
        worse == ["additional step"] and not same,
        f"by the table, these rates get worse: {', '.join(worse)}; unchanged: {', '.join(same) or 'none'}",
        in_part=worse == ["additional step"],
    )


def gains_of_replanning(evidence: Evidence) -> Finding:
    gains = [again - plain for plain, again in _replanned()]
    return all_of(
        (sum(gain > 10.05 for gain in gains), len(gains)),
        text=f"printed gains in success and execution: {', '.join(f'{gain:.1f}' for gain in gains)} points",
    )


def relative_gains_of_replanning(evidence: Evidence) -> Finding:
    gains = [100 * (again - plain) / plain for plain, again in _replanned()]
    shown = ", ".join(f"{gain:.0f}" for gain in gains)
    return all_of(
        (sum(gain > 10 for gain in gains), len(gains)),
        text=f"printed gains in success and execution, in percent of the rate without replanning: {shown}",
    )


def human_average(evidence: Evidence) -> Finding:
    table = read_paper_table("human")
    text, right = [], []
    for model in ("Human Annotation", "GPT-4o"):
        figures = {f"{c.ability}.{c.metric}": v or 0 for c, v in table.rows[model].items()}
        own = (
            figures[f"{GI}.overall.f1"]
            + figures[f"{SD}.task_success"]
            + figures[f"{AS}.task_success"]
            + (figures[f"{TM}.overall.f1"] + figures[f"{TM}.overall.planner_success"]) / 2
        ) / 4
        right.append(abs(own - figures[f".{AVERAGE}"]) <= 0.051)
        text.append(f"{model}: {own:.1f}, printed {figures[f'.{AVERAGE}']:.1f}")
    return Finding(by_degree(all(right), any(right)), f"from the table's own columns {'; '.join(text)}")


def pipelines_lack_steps(evidence: Evidence) -> Finding:
    rates = [
        figure
        for name in ("pipeline_action_sequencing", "pipeline_subgoal_decomposition")
        for row in read_paper_table(name).rows.values()
        for column, figure in row.items()
        if column.metric == "missing_step" and figure is not None
    ]
    return if_so(
        min(rates) > 0, f"by the tables of pipelines {min(rates):.0f} to {max(rates):.0f} % of cases"
    )


def pipelines_execute(evidence: Evidence) -> Finding:
    rates = [
        figure
        for name in ("pipeline_action_sequencing", "pipeline_subgoal_decomposition")
        for row, figures in read_paper_table(name).rows.items()
        for column, figure in figures.items()
        if column.metric == "execution_success" and figure is not None and row.endswith("(pipeline)")
    ]
    return if_so(min(rates) > 0, f"by the tables {min(rates):.0f} to {max(rates):.0f} % are executed")


def grammar_in_pipelines(evidence: Evidence) -> Finding:
    totals: dict[str, float] = {}
    for name in ("pipeline_action_sequencing", "pipeline_subgoal_decomposition"):
        for row, figures in read_paper_table(name).rows.items():
            model = row.partition(" (")[0]
            errors = sum(figure or 0 for column, figure in figures.items() if column.metric in GRAMMAR)
            totals[model] = max(totals.get(model, 0), errors)
    strong = {name: totals[name] for name in STRONG if name in totals}
    named = [totals[name] for name in ("Gemini 1.0 Pro", "GPT-3.5-turbo", *OPEN_WEIGHT)]
    return if_so(
        max(strong.values()) < min(named),
        f"largest share of grammar errors by the tables: strong models up to {max(strong.values()):.0f} %, "
        f"the others {min(named):.0f} to {max(named):.0f} %",
        in_part=fmean(strong.values()) < fmean(named),
    )


_OVERVIEW = (
    ("GI", "overall.f1"),
    ("AS", "task_success"),
    ("AS", "execution_success"),
    ("SD", "task_success"),
    ("SD", "execution_success"),
    ("TM", "overall.f1"),
    ("TM", "overall.planner_success"),
)


def _replanned() -> list[tuple[float, float]]:
    """Return printed rates of success and execution without and with replanning, of both worlds."""
    return [
        (plain[column] or 0, again[column] or 0)
        for table in (read_paper_table("replanning"), read_paper_table("replanning_prose"))
        for plain, again in [[table.rows[name] for name in ("GPT-4o", "GPT-4o w/ replanning")]]
        for column in table.columns
        if column.metric in ("task_success", "execution_success")
    ]


def _averages(evidence: Evidence, world: str, models: Sequence[str] = ()) -> list[str]:
    """Return models by average performance, the best first."""
    rates = rates_of(evidence, world, "average")
    return sorted(models or rates, key=lambda name: -rates.get(name, 0))


def _first_of_open(evidence: Evidence, model: str, *places: tuple[str, str]) -> Finding:
    first, text = [], []
    for world in "VB":
        for ability, metric in places:
            rates = rates_of(evidence, world, ability, metric)
            best = max(OPEN_WEIGHT, key=lambda name: rates[name])
            first.append(best == model)
            text.append(f"{metric.split('.')[-1].replace('_', ' ')} {world}: {best} {rates[best]:.1f}")
    return Finding(by_degree(all(first), any(first)), f"first of four open models: {'; '.join(text)}")


def _higher_in_virtualhome(evidence: Evidence, *places: tuple[str, str]) -> Finding:
    hits = [pairs_of(evidence, ("V", *place), ("B", *place)) for place in places]
    text = " and ".join(
        f"{_told(each)} models ({metric.replace('_', ' ')}, {ability})"
        for each, (ability, metric) in zip(hits, places, strict=True)
    )
    return all_of(*hits, text=f"higher in VirtualHome in {text}")


def _lower_category(evidence: Evidence, higher: Sequence[str], lower: str, metric: str) -> Finding:
    hits = [
        pairs_of(evidence, (world, "TM", f"{higher[0]}.{metric}"), (world, "TM", f"{lower}.{metric}"))
        for world in "VB"
    ]
    what = f"{lower.replace('_', ' ')} below {higher[0].replace('_', ' ')}"
    return most_of(
        *hits, text=f"{what} in {_told(hits[0])} models in VirtualHome, {_told(hits[1])} in BEHAVIOR"
    )


def _sums(evidence: Evidence, world: str, ability: str, metrics: Sequence[str]) -> Mapping[str, float]:
    columns = [rates_of(evidence, world, ability, metric) for metric in metrics]
    return {name: sum(column[name] for column in columns) for name in columns[0]}


def _fewer_grammar_errors(
    evidence: Evidence, pairs: Sequence[tuple[str, str]], *, is_tendency: bool = False
) -> Finding:
    """Count the pairs in whose plans the first model makes fewer grammar errors; a tendency takes most."""
    counts, text = [], []
    for world, domain in (("V", V), ("B", B)):
        totals = _sums(evidence, world, "AS", GRAMMAR)
        others = [f"{first} and {other}" for first, other in pairs if totals[first] >= totals[other]]
        counts.append((len(pairs) - len(others), len(pairs)))
        exceptions = f" (not {', '.join(others)})" if others else ""
        text.append(f"{NAMED[domain]} {_told(counts[-1])}{exceptions}")
    judge = most_of if is_tendency else all_of
    return judge(*counts, text=f"pairs with fewer grammar errors of plans: {'; '.join(text)}")


def _below(rates: Mapping[str, float], limit: float) -> tuple[int, int]:
    return sum(rate < limit for rate in rates.values()), len(rates)


def _told(count: tuple[int, int]) -> str:
    return f"{count[0]} of {count[1]}"
