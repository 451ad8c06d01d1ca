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
    ("best in plans but for the o1 series", PLANS, PaperColumn(AS, SOLVED, B), "GPT-4o", 1, O1),
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
        f"{same} of {len(QUOTED)} figures of the text are those of the tables; all others are VirtualHome's."
        " Those of its goal interpretation (82.0 and 89.1) are denied by more than twenty points; those of"
        f" its plans are what the public answers give. Of {len(orders)} orders of models {len(wrong)} are "
        f"denied by the tables, {in_behavior} of them in BEHAVIOR.",
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
        f"In VirtualHome {ahead[V]} of {models} models are better at subgoals, in BEHAVIOR {ahead[B]}: the "
        "claim holds in one world and not in the other, and the two abilities are scored by different rules.",
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
                    f"{ability.replace('_', ' ')}: {named}, pipeline less modular, mean of "
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
            "GPT-4o's subgoals, its example",
            "48.0 % to 38.0 %",
            f"of 100 tasks each: p = {fisher(48, 38, 100):.2f} unpaired",
        )
    )
    return Finding(
        by_degree(all(lower) and all(similar), any(lower)),
        "By the paper's own table success is lower over models, in both pipelines; execution cannot be told "
        "from equal, which is not the same as similar. Of a single model ten points of 100 tasks may be "
        "chance.",
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
        "No table and no answers: two pairs of figures of the text. The script is that of VirtualHome's "
        "replanning, which tells the model nothing of what went wrong. And asking again what failed can only "
        "gain: without an arm that is asked again and told nothing, no gain is feedback's.",
        [
            Row("task success without and with", "47.0 %, 59.0 %", f"unpaired p = {fisher(47, 59, 100):.2f}"),
            Row("execution without and with", "53.0 %, 63.0 %", f"unpaired p = {fisher(53, 63, 100):.2f}"),
            Row("additional steps without and with", "0.0 %, 3.0 %", f"p = {fisher(0, 3, 100):.2f}"),
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
                    f"slips of {chance}: {named} without and with",
                    f"{without:.0f} %, {replanned:.0f} %",
                    f"{hits[0]} and {hits[1]} of {SLIPS_TASKS}: p = {p:.2g}",
                )
            )
    return Finding(
        by_degree(all(clear), any(clear)),
        f"Of {SLIPS_TASKS} episodes each: at a chance of 0.05 neither gain can be told from none, at 0.1 and "
        "0.2 both can. With seed 0 the draw has 16 distinct tasks, and the model is told the state, not that "
        "anything failed.",
        rows,
    )


def vision(evidence: Evidence) -> Finding:
    return Finding(
        Status.CANNOT_BE_CHECKED,
        "Neither answers nor pictures are published, nor how many tasks were asked: it cannot have been "
        "100, which gives neither 11.1 % nor 2.5 % (the smallest numbers that do are 1 of 9 and 1 of 40).",
        [
            Row("goal interpretation, F1: scene graph, image, both", "31.5, 9.1, 25.8", "–"),
            Row("success of plans: scene graph, image, both", "11.1 %, 2.5 %, 11.0 %", "–"),
        ],
    )


def context(evidence: Evidence) -> Finding:
    return Finding(
        Status.CANNOT_BE_CHECKED,
        "What the “broader context” was is not said, nor of how many tasks the figures are. Were they of "
        f"100, 11 and 14 successes would differ with p = {fisher(11, 14, 100):.2f}; gains of 0.4 and 0.1 "
        "points of F1 carry no finding.",
        [
            Row("Llama 3: F1, success", "31.5 to 31.9, 11.1 % to 13.9 %", "–"),
            Row("LLaVA with a scene graph: F1, success", "25.8 to 25.9, 11.0 % to 12.3 %", "–"),
        ],
    )


def perception(evidence: Evidence) -> Finding:
    best, middle, worst, tasks = 6, 4, 1, 8
    return Finding(
        Status.CANNOT_BE_CHECKED,
        "Success rates are eighths, of 8 tasks that are not named; what the rates of errors are shares of is "
        "not said, nor which model planned. The order of three models is no curve of success by error.",
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
        "The figures of the text",
        "The summary of findings gives figures, such as an F1 of 82.0 and a recall of 89.1 in VirtualHome's "
        "goal interpretation.",
        "appendix, “Summary of Empirical Findings”",
        NOTHING,
        "all figures that a table has, too, are that table's",
        prose,
    ),
    Claim(
        "D3",
        "Subgoal decomposition is not easier than action sequencing",
        "With abstract actions it is not strictly easier to state subgoals than to plan.",
        "results; appendix, “Summary of Empirical Findings”",
        NOTHING,
        "in neither world do more than half of the models succeed more often with subgoals",
        easier,
        "From the paper's overview of all 18 models. A search helps an answer with subgoals, and none helps "
        "a plan.",
    ),
    Claim(
        "I2",
        "Replanning in BEHAVIOR",
        "With replanning GPT-4o's success rises from 47.0 to 59.0 %, its execution from 53.0 to 63.0 %, and "
        "additional steps from none to 3.0 %.",
        "appendix, “Summary of Empirical Findings”",
        NOTHING,
        "none: no answers are published",
        replanning_behavior,
        "See [replanning](analyses.md).",
    ),
    Claim(
        "I3",
        "Replanning helps where actions slip",
        "In BEHAVIOR replanning raises GPT-4o's execution and success where actions fail with a chance of "
        "0.05, 0.1 or 0.2, and the more, the more often they do.",
        "appendix, “Replanning with Stochastic Actions”",
        NOTHING,
        "every gain with p < 0.05",
        slips,
        "Episodes count as independent here, though tasks were drawn twice; pairs are not published.",
    ),
    Claim(
        "J1",
        "Pipelines execute as often and succeed less",
        "Where a model plans for goals that it interpreted itself, execution is similar and success lower, "
        "for errors add up.",
        "appendix, “Pipeline-Based vs Modularized”",
        NOTHING,
        "over models success is lower with p < 0.05 in both pipelines, and execution is not",
        pipelines,
        "A sign test over models, which share tasks. The answers of the paper's pipeline with plans are not "
        "published; how ours come out is in [Pipelines](pipelines.md).",
    ),
    Claim(
        "K1",
        "An image helps less than a scene graph",
        "LLaVA plans worse from an image than Llama 3 from a scene graph, and with both no better.",
        "appendix, “Comparative Experiments with LLMs and VLMs”",
        NOTHING,
        "none: no answers are published",
        vision,
        "[Perception](perception.md) makes the comparison for any model.",
    ),
    Claim(
        "K2",
        "What helps a language model helps a vision model",
        "Broader context raises goal interpretation and plans of both.",
        "appendix, “Why LLMs Benchmarking is Useful”",
        NOTHING,
        "none: what was done is not said",
        context,
    ),
    Claim(
        "K3",
        "Errors of perception lower success",
        "Subgoals planned from scene graphs that vision models saw succeed less, the more errors these have.",
        "appendix, “Impact of Perception and State Estimation Errors”",
        NOTHING,
        "none: no answers are published",
        perception,
        "[Perception](perception.md) measures success at known rates of errors.",
    ),
)
