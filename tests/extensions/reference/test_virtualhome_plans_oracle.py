"""Verdicts and summaries under `eai-1.0.5` against those of the reference, row by row."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any, TypeAlias

import pytest

from by_path import ROOT
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.verdict import PlanVerdict, Verdict
from eai.base.store import DataPackStore
from eai.benchmarks.suite import open_suite
from eai.extensions.reference.virtualhome_quirks import QUIRKS
from eai.results.rate import Rate
from eai.results.summary import compute_metric_rates
from eai.tasks.source import Source
from oracle import MODELS, Oracle, read_shared
from sweeps import first_of

REFERENCE = Protocol("eai-1.0.5")
PAGE = ROOT / "docs" / "extensions" / "reference" / "README.md"
MEASURED = ROOT / "bench" / "README.md"

WITHOUT_IDS = "helm_gpt-4o-2024-05-13.eai-1.0.5"
"""Answers without ids. The last release of the reference reads none of them."""

SYNTHETIC = ("gold_script.eai-1.0.5", "perturbed.eai-1.0.5", "perturbed2.eai-1.0.5")
"""Made responses with ids; a task has several rows in the perturbed ones."""

KINDS = {
    "parsing error": "parsing",
    "hallucination error": "hallucination",
    "parameter error": "argument_number",
    "missing_step": "missing_step",
    "affordance_error": "affordance",
    "wrong_temporal_order": "wrong_order",
    None: None,
}
"""The reference's names of errors -> ours."""

ADDITIONAL_STEP = 4
"""The reference's code for it; a step with any other code ends the plan."""

RATES = {
    "execution_success_rate": "execution_success",
    "parsing": "parsing",
    "hallucination": "hallucination",
    "predicate_argument_number": "argument_number",
    "wrong_order": "wrong_order",
    "missing_step": "missing_step",
    "affordance_error": "affordance",
    "additional_step": "additional_step",
    "state_goal": "state_goal",
    "relation_goal": "relation_goal",
    "task_success_rate": "task_success",
    "action_goal": "action_goal",
    "total_goal": "total_goal",
}
"""The reference's names of the rates -> ours."""

DIGITS = {"execution_success_rate": 1}
"""Number of decimals that the reference prints, if it is not 4."""


@dataclass(frozen=True, slots=True)
class Scored:
    """The verdicts of one oracle file, row by row."""

    rows: Sequence[Mapping[str, Any]]
    verdicts: Sequence[Verdict]
    reference: Mapping[str, Any]


Score: TypeAlias = Callable[[str], Scored]
"""The name of an oracle file -> its verdicts."""


@pytest.fixture(scope="module")
def score(data_store: DataPackStore, oracle: Oracle) -> Score:
    """Scores a file, once."""
    return cache(partial(scored, oracle=oracle, store=data_store))


def scored(name: str, *, oracle: Oracle, store: DataPackStore) -> Scored:
    reference = oracle("virtualhome", "action_sequencing", name)
    rows = reference["tasks"]
    suite = open_suite(
        "virtualhome",
        Ability.ACTION_SEQUENCING,
        Protocol("eai-1.0.5"),
        source=Source(store),
    ).choose_suite_for_answers([row["llm_output"] for row in rows])
    verdicts = [suite.score(row["id"].partition("@")[0], row["llm_output"]) for row in rows]
    return Scored(rows, verdicts, reference)


def of_reference(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return the reference's verdict on a row, in our terms."""
    if not row["gold_test_pass"]:
        return {"excluded": True}
    error, reached, steps = row["error_info"] or {}, row["pred"], row["executed_steps"]
    kind = KINDS[error.get("error_type")]
    ran_into_it = bool(steps) and not steps[-1]["ok"] and steps[-1]["final_code"] != ADDITIONAL_STEP
    return {
        "excluded": False,
        "executable": error.get("executable", True),
        "kind": kind,
        "step": len(steps) - 1 if ran_into_it else None,
        "additional_steps": sum(step.get("final_code") == ADDITIONAL_STEP for step in steps),
        "success": bool(reached and reached["all"]),
        "goals": [
            (reached[kind] if reached else 0, total)
            for kind, total in zip(("node", "edge", "action"), row["gold_counts"], strict=True)
        ],
    }


def of_ours(verdict: Verdict) -> dict[str, Any]:
    if verdict.excluded is not None:
        return {"excluded": True}
    assert verdict.goals is not None
    error = verdict.error
    before_running = {"parsing", "hallucination", "argument_number"}
    return {
        "excluded": False,
        "executable": verdict.executable,
        "kind": error and error.kind.value,
        "step": None if error is None or error.kind.value in before_running else error.step,
        "additional_steps": verdict.additional_steps,
        "success": verdict.success,
        "goals": [tuple(tally) for tally in verdict.goals],
    }


@pytest.mark.parametrize("name", [*MODELS, *SYNTHETIC])
def test_every_row_has_the_verdict_of_the_reference(name: str, score: Score) -> None:
    rows = score(name).rows
    compared = [(r, v) for r, v in zip(rows, score(name).verdicts, strict=True) if not crashed(r)]
    differing = {row["id"]: (of_reference(row), of_ours(v)) for row, v in compared}
    assert {i: pair for i, pair in differing.items() if pair[0] != pair[1]} == {}
    assert len(compared) >= 342


def test_the_documentation_says_how_many_answers_were_compared_and_what_is_left_out(oracle: Oracle) -> None:
    files = [oracle("virtualhome", "action_sequencing", name)["tasks"] for name in (*MODELS, *SYNTHETIC)]
    unread = oracle("virtualhome", "action_sequencing", WITHOUT_IDS)["tasks"]
    assert {(row["error_info"] or {}).get("error_type") for row in unread if row["gold_test_pass"]} == {
        "parsing error"
    }
    stopped = sum(crashed(row) for rows in files for row in rows)
    page = PAGE.read_text(encoding="utf-8")
    assert f"on all {sum(map(len, files)) - stopped:,} answers" in page
    left_out = f"Another {stopped + len(unread)} answers cannot be compared: {stopped} abort the reference"
    assert f"{left_out}, and {len(unread)} have" in page


@pytest.mark.parametrize("name", [*MODELS, *SYNTHETIC])
def test_the_summary_is_what_the_reference_prints(name: str, score: Score) -> None:
    """The order of two action goals is the reference's, too: that of hash seed 0."""
    executed = [
        in_order_of_hash_seed_0(verdict)
        for row, verdict in zip(score(name).rows, score(name).verdicts, strict=True)
        if not crashed(row)
    ]
    rates = summary(executed)
    printed = dict(leaves(score(name).reference["summary"]))
    assert {key: rounded(rates[ours], DIGITS.get(key, 4)) for key, ours in RATES.items()} == printed


@pytest.mark.parametrize("name", MODELS)
def test_a_summary_takes_action_goals_in_data_set_order(name: str, score: Score) -> None:
    known = read_shared("oracle", "virtualhome", "hash_order_sensitivity.json")
    rates = summary(score(name).verdicts)
    assert rounded(rates["task_success"], 2) == known[name]["dataset_order"]
    assert rates["action_goal"].numerator == known[name]["action_goal_dataset"]
    assert rates["task_success"].denominator == known[name]["n"] == 305


@pytest.mark.parametrize("name", first_of(MODELS))
def test_a_third_party_got_the_same_verdicts_and_rates_from_the_paper_s_package(
    name: str, score: Score
) -> None:
    """Their run lists no plan that equals the data set's script."""
    run = read_shared("oracle", "virtualhome", "action_sequencing", "third_party_run.json.gz")[name]
    verdicts = {row["id"]: v for row, v in zip(score(name).rows, score(name).verdicts, strict=True)}
    ours = {task_id: of_ours(verdicts[task_id]) for task_id in run["rows"]}
    assert {task_id: (row["executable"], row["kind"]) for task_id, row in ours.items()} == {
        task_id: (executable, KINDS[kind]) for task_id, (executable, kind) in run["rows"].items()
    }
    assert len(ours) >= 300
    rates = summary(score(name).verdicts)
    printed = {"execution_success": 1}
    assert {rate: rounded(rates[rate], printed.get(rate, 4)) for rate in run["rates"]} == run["rates"]


def test_row_verdicts_and_summaries_differ_in_the_order_of_action_goals(score: Score) -> None:
    verdicts = score("gemini-1.5-pro-preview-0409").verdicts
    by_row = summary([in_order_of_hash_seed_0(verdict) for verdict in verdicts])
    assert (by_row["action_goal"].numerator, summary(verdicts)["action_goal"].numerator) == (98, 101)


@pytest.mark.parametrize("name", MODELS)
def test_the_documentation_shows_the_rates_of_both_protocols(
    name: str, score: Score, data_store: DataPackStore
) -> None:
    """bench/README.md, "Both protocols on public answers"."""
    reference = summary(score(name).verdicts)
    answers = {row["id"]: row["llm_output"] for row in score(name).rows}
    suite = open_suite("virtualhome", Ability.ACTION_SEQUENCING, source=Source(data_store))
    strict = summary([suite.score(*answer) for answer in answers.items()], Protocol.STRICT)
    cells = [
        f"{rates[rate].percent:.1f}"
        for rate in ("task_success", "execution_success")
        for rates in (reference, strict)
    ]
    assert f"\n| {name} | {' | '.join(cells)} |\n" in MEASURED.read_text(encoding="utf-8")


def test_the_documentation_names_every_quirk_of_the_simulator() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert [quirk.__name__ for quirk in QUIRKS if f"`{quirk.__name__}`" not in page] == []


def summary(verdicts: Sequence[Verdict], protocol: Protocol = REFERENCE) -> dict[str, Rate]:
    return compute_metric_rates(verdicts, Ability.ACTION_SEQUENCING)


def in_order_of_hash_seed_0(verdict: Verdict) -> Verdict:
    """Return the verdict, counted with action goals in the order of hash seed 0."""
    assert isinstance(verdict, PlanVerdict)
    if verdict.counted is None or verdict.goals is None:
        return verdict
    as_told = replace(verdict.counted, success=bool(verdict.success), goals=verdict.goals)
    return replace(verdict, counted=as_told)


def rounded(rate: Rate, digits: int) -> float:
    assert rate.percent is not None
    return round(rate.percent, digits)


def leaves(tree: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from leaves(value)
        else:
            yield key, value


def crashed(row: Mapping[str, Any]) -> bool:
    """Whether the reference crashes on this row."""
    return bool(row.get("reference_crash"))
