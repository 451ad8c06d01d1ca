"""Claims that the paper's own tables decide: prose against tables, pipelines, replanning, vision."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from claim import Claim, Finding, Row, Status, by_degree, fisher, sign_test
from elsewhere import NOTHING
from evidence import AS, GI, NAMED, SD, TM, B, Evidence, V

from eai.results.paper_tables import PaperColumn, PaperTable, read_paper_table

SOLVED = "task_success"
EXECUTED = "execution_success"


class Quoted(NamedTuple):
    """A figure of the paper's summary of findings, and the table cell that it must equal."""

    model: str
    table: str
    column: PaperColumn
    figure: float


def _quoted(table: str, ability: str, metric: str, domain: str, *figures: tuple[str, float]) -> list[Quoted]:
    return [Quoted(model, table, PaperColumn(ability, metric, domain), figure) for model, figure in figures]


PLANS, SUBGOALS = "action_sequencing_trajectory", "subgoal_decomposition_trajectory"
GOALS, OPERATORS = "goal_interpretation", "transition_modeling_behavior_logic"
QUOTED: Sequence[Quoted] = (
    *_quoted(GOALS, GI, "overall.f1", V, ("Gemini 1.5 Pro", 82.0)),
    *_quoted(GOALS, GI, "overall.recall", V, ("Claude-3 Opus", 89.1)),
    *_quoted(PLANS, AS, SOLVED, B, ("o1-preview", 81.0), ("o1-mini", 56.0), ("GPT-4o", 47.0)),
    *_quoted(PLANS, AS, EXECUTED, B, ("o1-preview", 91.0), ("o1-mini", 65.0), ("GPT-4o", 53.0)),
    *_quoted(PLANS, AS, SOLVED, V, ("Mistral Large", 73.4), ("Gemini 1.5 Pro", 73.1), ("o1-preview", 71.1)),
    *_quoted(PLANS, AS, EXECUTED, V, ("Mistral Large", 83.6), ("Gemini 1.5 Pro", 83.3), ("o1-preview", 78.4)),
    *_quoted(PLANS, AS, "parsing", B, ("GPT-3.5-turbo", 4.0)),
    *_quoted(PLANS, AS, "missing_step", B, ("GPT-4o", 36.0)),
    *_quoted(PLANS, AS, "wrong_order", B, ("GPT-4o", 9.0)),
    *_quoted("goal_satisfaction", AS, "state_goal", V, ("GPT-4o", 82.0)),
    *_quoted("goal_satisfaction", AS, "relation_goal", V, ("GPT-4o", 67.8)),
    *_quoted(SUBGOALS, SD, SOLVED, V, ("o1-preview", 89.4), ("Gemini 1.5 Flash", 89.1)),
    *_quoted(SUBGOALS, SD, SOLVED, V, ("Claude-3.5 Sonnet", 89.1)),
    *_quoted(SUBGOALS, SD, SOLVED, B, ("o1-preview", 57.0)),
    *_quoted(OPERATORS, TM, "object_states.f1", B, ("Claude-3.5 Sonnet", 78.8)),
    *_quoted(OPERATORS, TM, "non_spatial_relations.f1", B, ("o1-preview", 83.5)),
    *_quoted(
        "transition_modeling_virtualhome_logic", TM, "non_spatial_relations.f1", V, ("o1-preview", 11.9)
    ),
)
"""Figures of “Summary of Empirical Findings” that are also in a table of all models."""


O1 = ("o1-preview", "o1-mini")
_F1, _RECALL = "overall.f1", "overall.recall"
ORDERS: Sequence[tuple[str, str, PaperColumn, str, int, Sequence[str]]] = (
    *(("highest F1 of goals", GOALS, PaperColumn(GI, _F1, d), "Gemini 1.5 Pro", 1, ()) for d in (V, B)),
    *(
        ("highest recall of goals", GOALS, PaperColumn(GI, _RECALL, d), "Claude-3 Opus", 1, ())
        for d in (V, B)
    ),
    ("second in plans", PLANS, PaperColumn(AS, SOLVED, B), "o1-mini", 2, ()),
    ("best in plans except the o1 series", PLANS, PaperColumn(AS, SOLVED, B), "GPT-4o", 1, O1),
    *(("best in subgoals", SUBGOALS, PaperColumn(SD, SOLVED, d), "o1-preview", 1, ()) for d in (V, B)),
)
"""Orders of models in the summary: words, table, column, model, rank, excluded models."""


def prose(evidence: Evidence) -> Finding:
    rows = []
    for model, table, column, figure in QUOTED:
        printed = read_paper_table(table).find_printed_number(model, column)
        if printed is None or abs(printed - figure) > 0.05:
            what = f"{NAMED[column.domain]}, {column.ability.replace('_', ' ')}: {model}, {column.metric}"
            rows.append(Row(what, f"{figure:.1f} in the text", f"{_told(printed)} in the table"))
    same = len(QUOTED) - len(rows)
    orders = list(_orders())
    rows += orders
    wrong = [row for row in orders if row.printed != row.ours]
    in_behavior = sum(row.what.startswith(NAMED[B]) for row in wrong)
    return Finding(
        by_degree(same == len(QUOTED) and not wrong, same > len(QUOTED) / 2),
        f"{same} of {len(QUOTED)} figures of the text agree with the tables; all others are about "
        "VirtualHome. The figures of its goal interpretation (82.0 and 89.1) differ from the table by more "
        "than twenty points. The figures of its plans agree with the public answers. The tables contradict "
        f"{len(wrong)} of {len(orders)} orders of models, {in_behavior} of them in BEHAVIOR.",
        rows,
    )


def _orders() -> Iterator[Row]:
    """Yield the models that the text puts first or second, beside those of the tables."""
    for what, table_name, column, said, rank, others in ORDERS:
        table = read_paper_table(table_name)
        models = [model for model in table.rows if model not in others]
        order = sorted(models, key=lambda model: -(table.find_printed_number(model, column) or 0))
        yield Row(f"{NAMED[column.domain]}: {what}", said, order[rank - 1])


def _told(figure: float | None) -> str:
    return "–" if figure is None else f"{figure:.1f}"


def easier(evidence: Evidence) -> Finding:
    rows, ahead = [], {}
    overview = read_paper_table("overview")
    for domain in (V, B):
        pairs = [
            (overview.find_printed_number(model, PaperColumn(SD, SOLVED, domain)), plans)
            for model in overview.rows
            if (plans := overview.find_printed_number(model, PaperColumn(AS, SOLVED, domain))) is not None
        ]
        known = [(subgoals, plans) for subgoals, plans in pairs if subgoals is not None]
        ahead[domain] = sum(subgoals > plans for subgoals, plans in known)
        p = sign_test(ahead[domain], sum(subgoals < plans for subgoals, plans in known))
        rows.append(
            Row(
                f"{NAMED[domain]}: models that succeed more often with subgoals than with plans",
                "",
                f"{ahead[domain]} of {len(known)}, sign test p = {p:.2g}",
            )
        )
    models = len(overview.rows)
    return Finding(
        by_degree(max(ahead.values()) <= models / 2, min(ahead.values()) <= models / 2),
        f"In VirtualHome, {ahead[V]} of {models} models are better at subgoals; in BEHAVIOR, {ahead[B]}. So "
        "the claim holds in one of the two worlds. The two abilities are scored by different rules.",
        rows,
    )


def pipelines(evidence: Evidence) -> Finding:
    rows, fewer = [], []
    for ability in (AS, SD):
        table = read_paper_table(f"pipeline_{ability}")
        for metric in (SOLVED, EXECUTED):
            column = PaperColumn(ability, metric, B)
            differences = list(_differences(table, column))
            less, more = (sum(sign * each > 0 for each in differences) for sign in (-1, 1))
            p = sign_test(less, more)
            mean = sum(differences) / len(differences)
            named = metric.replace("_", " ")
            rows.append(
                Row(
                    f"{ability.replace('_', ' ')}: {named}, pipeline minus modular, mean of "
                    f"{len(differences)} models",
                    "lower" if metric == SOLVED else "similar",
                    f"{mean:+.1f} points; lower in {less}, higher in {more}, p = {p:.2g}",
                )
            )
            fewer.append((metric, p < 0.05 and less > more))
    lower = [found for metric, found in fewer if metric == SOLVED]
    similar = [not found for metric, found in fewer if metric == EXECUTED]
    rows.append(
        Row(
            "GPT-4o's subgoals, the paper's example",
            "48.0 % to 38.0 %",
            f"of 100 tasks each: p = {fisher(48, 38, 100):.2f} unpaired",
        )
    )
    return Finding(
        by_degree(all(lower) and all(similar), any(lower)),
        "In the paper's own table, success over models is lower in both pipelines. For execution, no "
        "difference can be detected, which does not show that it is similar. For a single model, ten points "
        "of 100 tasks may be due to chance.",
        rows,
    )


def _differences(table: PaperTable, column: PaperColumn) -> Iterator[float]:
    """Yield the rate of the pipeline minus the modular rate for each model."""
    for name in table.rows:
        model, _, way = name.rpartition(" ")
        if way == "(modular)":
            before = table.find_printed_number(name, column)
            after = table.find_printed_number(f"{model} (pipeline)", column)
            if before is not None and after is not None:
                yield after - before


def replanning_behavior(evidence: Evidence) -> Finding:
    return Finding(
        Status.CANNOT_BE_CHECKED,
        "The paper gives pairs of figures in its text, but no table and no answers. The script is the one "
        "for VirtualHome's replanning, which does not tell the model what went wrong. Asking again after "
        "failures can only raise success. Without a control that is asked again without feedback, no gain "
        "can be attributed to feedback.",
        [
            Row(f"{name} without and with replanning", said, f"unpaired p = {fisher(*counts, 100):.2f}")
            for name, said, counts in (
                ("task success", "47.0 %, 59.0 %", (47, 59)),
                ("execution", "53.0 %, 63.0 %", (53, 63)),
                ("additional steps", "0.0 %, 3.0 %", (0, 3)),
            )
        ],
    )


SLIPS_TASKS = 20
"""Number of tasks that the script draws with replacement; printed figures are multiples of 5 percent."""


def slips(evidence: Evidence) -> Finding:
    table = read_paper_table("replanning_stochastic")
    rows, clear = [], []
    for chance in ("0.05", "0.1", "0.2"):
        for metric, named in ((EXECUTED, "execution"), (SOLVED, "success")):
            column = PaperColumn(AS, metric, B)
            without = table.find_printed_number(f"GPT-4o, p = {chance}", column) or 0.0
            replanned = table.find_printed_number(f"GPT-4o w/ replanning, p = {chance}", column) or 0.0
            hits = [round(figure * SLIPS_TASKS / 100) for figure in (without, replanned)]
            p = fisher(*hits, SLIPS_TASKS)
            clear.append(p < 0.05)
            rows.append(
                Row(
                    f"chance of {chance}: {named} without and with replanning",
                    f"{without:.0f} %, {replanned:.0f} %",
                    f"{hits[0]} and {hits[1]} of {SLIPS_TASKS}: p = {p:.2g}",
                )
            )
    return Finding(
        by_degree(all(clear), any(clear)),
        f"Each rate is of {SLIPS_TASKS} episodes. At a chance of 0.05, neither gain can be distinguished "
        "from zero; at 0.1 and 0.2, both can. With seed 0, the drawn sample has 16 distinct tasks. The model "
        "is told the state, but not that an action failed.",
        rows,
    )


def vision(evidence: Evidence) -> Finding:
    return Finding(
        Status.CANNOT_BE_CHECKED,
        "Answers, pictures and the number of tasks are not published. The number cannot have been 100, "
        "because 100 tasks give neither 11.1 % nor 2.5 %. The smallest counts with these rates are 1 of 9 "
        "and 1 of 40.",
        [
            Row("goal interpretation, F1: scene graph, image, both", "31.5, 9.1, 25.8", "–"),
            Row("success of plans: scene graph, image, both", "11.1 %, 2.5 %, 11.0 %", "–"),
        ],
    )


def context(evidence: Evidence) -> Finding:
    return Finding(
        Status.CANNOT_BE_CHECKED,
        "The paper does not say what the “broader context” was, nor how many tasks there were. With 100 "
        f"tasks, 11 and 14 successes would differ with p = {fisher(11, 14, 100):.2f}. Gains of 0.4 and 0.1 "
        "points of F1 support no conclusion.",
        [
            Row("Llama 3: F1, success", "31.5 to 31.9, 11.1 % to 13.9 %", "–"),
            Row("LLaVA with a scene graph: F1, success", "25.8 to 25.9, 11.0 % to 12.3 %", "–"),
        ],
    )


def perception(evidence: Evidence) -> Finding:
    best, middle, worst, tasks = 6, 4, 1, 8
    return Finding(
        Status.CANNOT_BE_CHECKED,
        "Success rates are multiples of 1/8, from 8 tasks that are not named. The paper does not name the "
        "denominators of the error rates, or the model that planned. An order of three models is not a curve "
        "of success by error rate.",
        [
            Row(
                "75.0 % against 12.5 % (8 % and 83 % wrong predicates)",
                "falls",
                f"{best} and {worst} of {tasks}: p = {fisher(best, worst, tasks):.2f}",
            ),
            Row(
                "75.0 % against 50.0 % (8 % and 20 % wrong predicates)",
                "falls",
                f"{best} and {middle} of {tasks}: p = {fisher(best, middle, tasks):.2f}",
            ),
        ],
    )


CLAIMS: Sequence[Claim] = (
    Claim(
        "D2",
        "Figures in the text",
        "The summary of findings gives figures, such as an F1 of 82.0 and a recall of 89.1 in VirtualHome's "
        "goal interpretation.",
        "appendix, “Summary of Empirical Findings”",
        NOTHING,
        "every figure and every order of models that is also in a table agrees with that table",
        prose,
    ),
    Claim(
        "D3",
        "Subgoal decomposition is not easier than action sequencing",
        "With abstract actions, stating subgoals is not strictly easier than planning actions.",
        "results; appendix, “Summary of Empirical Findings”",
        NOTHING,
        "in neither world do more than half of the models succeed more often with subgoals",
        easier,
        "The figures are from the paper's overview of all 18 models. A search completes an answer with "
        "subgoals, but no search completes a plan.",
    ),
    Claim(
        "I2",
        "Replanning in BEHAVIOR",
        "With replanning, GPT-4o's success rises from 47.0 to 59.0 %, and its execution from 53.0 to 63.0 %. "
        "Additional steps rise from none to 3.0 %.",
        "appendix, “Summary of Empirical Findings”",
        NOTHING,
        "none, because no answers are published",
        replanning_behavior,
        "The page on [replanning](replanning.md#measure-the-effect-of-feedback) describes such a control.",
    ),
    Claim(
        "I3",
        "Replanning helps if actions fail by chance",
        "In BEHAVIOR, replanning raises GPT-4o's execution and success if actions fail with a chance of "
        "0.05, 0.1 or 0.2. The gain grows with this chance.",
        "appendix, “Replanning with Stochastic Actions”",
        NOTHING,
        "every gain has p < 0.05",
        slips,
        "The test treats episodes as independent, although some tasks were drawn twice. Pairs of episodes "
        "are not published.",
    ),
    Claim(
        "J1",
        "Pipelines have similar execution and lower success",
        "If a model plans for goals that it interpreted itself, execution is similar and success is lower, "
        "because errors add up.",
        "appendix, “Pipeline-Based vs Modularized”",
        NOTHING,
        "over models, success is lower with p < 0.05 in both pipelines, and execution is not",
        pipelines,
        "The test is a sign test over models, which share tasks. The answers of the paper's pipeline with "
        "plans are not published. The page on [pipelines](pipelines.md) shows how to run and score others.",
    ),
    Claim(
        "K1",
        "An image helps less than a scene graph",
        "LLaVA plans worse from an image than Llama 3 from a scene graph. With both inputs, LLaVA plans no "
        "better.",
        "appendix, “Comparative Experiments with LLMs and VLMs”",
        NOTHING,
        "none, because no answers are published",
        vision,
        "[Perception](perception.md) shows how to make this comparison with any model.",
    ),
    Claim(
        "K2",
        "Broader context helps language models and vision models",
        "Broader context improves goal interpretation and plans of both.",
        "appendix, “Why LLMs Benchmarking is Useful”",
        NOTHING,
        "none, because the paper does not say what was done",
        context,
    ),
    Claim(
        "K3",
        "Perception errors lower success",
        "Subgoals are planned from scene graphs that vision models produced. The more errors these graphs "
        "have, the less often the subgoals succeed.",
        "appendix, “Impact of Perception and State Estimation Errors”",
        NOTHING,
        "none, because no answers are published",
        perception,
        "[Perception](perception.md) measures success at known error rates.",
    ),
)
