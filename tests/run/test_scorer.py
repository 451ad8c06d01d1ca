"""Inspect's logs have the rates of ``eai run`` and ``eai score``; their samples explain the scores."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor
from pathlib import Path

import pytest
from inspect_ai.log import EvalLog, EvalSample, read_eval_log
from inspect_ai.scorer import Score

from agents.switches import SWITCHES
from eai.abilities.declaration import get_declaration
from eai.abilities.experiment import Experiment
from eai.abilities.protocol import PAPER_ABILITIES, Ability, Protocol
from eai.agents.setting import ACTING
from eai.base.files import to_file_name
from eai.base.store import DataPackStore
from eai.benchmarks.errata import load_all_errata
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite, open_suite
from eai.results.batch import Scoring
from eai.results.codec import record_from_json
from eai.results.rate import Rate
from eai.results.responses import Response, read_responses
from eai.results.summary import compute_metric_rates, find_answer_outcome
from eai.run.scorer import add_study_results_to_record
from eai.run.tasks import read_answers
from eai.tasks.source import ErrataChoice, Source
from processes import own_process
from protocols import PROTOCOLS
from run.child import (
    PLANNER,
    Asked,
    Whom,
    evaluate_answers_in_child,
    evaluate_in_child,
    run_in_child,
    score_in_child,
)
from suites import answer_book, official_prompts
from sweeps import first_of

PLANS = ("virtualhome", Ability.ACTION_SEQUENCING)
SUITES = [(domain, ability) for domain in ("virtualhome", "behavior") for ability in PAPER_ABILITIES]
TASK_COUNT = 12
NOISY = Whom("eai/noisy", {"rate": 0.6, "seed": 3})


@pytest.fixture(scope="module")
def process() -> Iterator[Executor]:
    """A process of its own for Inspect."""
    with own_process() as pool:
        yield pool


def some_tasks(domain: str, ability: Ability, protocol: Protocol) -> tuple[Suite, Asked]:
    """A suite, and some tasks from its whole range."""
    suite = Asked(domain, ability, protocol, ()).suite()
    count = TASK_COUNT if get_declaration(ability).answers_are_plans else TASK_COUNT // 3
    chosen = suite.task_ids[:: len(suite.task_ids) // count][:count]
    return suite, Asked(domain, ability, protocol, chosen)


def paper(log: EvalLog) -> dict[str, float]:
    """Return the paper's columns in a log."""
    assert log.results is not None
    (columns,) = (score.metrics for score in log.results.scores if "accuracy" not in score.metrics)
    return {name: found.value for name, found in columns.items()}


def shares(rates: Mapping[str, Rate]) -> dict[str, float]:
    return {name: share for name, rate in rates.items() if (share := rate.share) is not None}


def score_in(sample: EvalSample, ability: Ability) -> Score:
    assert sample.scores is not None
    assert list(sample.scores) == [ability.value]
    return sample.scores[ability.value]


@pytest.mark.parametrize("protocol", first_of(PROTOCOLS), ids=lambda protocol: protocol.value)
@pytest.mark.parametrize(("domain", "ability"), SUITES, ids=str)
def test_all_ways_of_scoring_give_the_same_rates(
    data_store: DataPackStore,
    process: Executor,
    tmp_path: Path,
    domain: str,
    ability: Ability,
    protocol: Protocol,
) -> None:
    suite, asked = some_tasks(domain, ability, protocol)
    ran = process.submit(run_in_child, asked, NOISY, tmp_path).result()
    kinds = {find_answer_outcome(record) for record in ran.records}
    assert len(kinds) >= 3 or not get_declaration(ability).answers_are_plans
    numbers = shares(ran.rates)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert {name: summary[name]["value"] for name in numbers} == pytest.approx(
        {name: 100 * number for name, number in numbers.items()}
    )
    assert paper(read_eval_log(ran.log)) == pytest.approx(numbers)
    evaluated = process.submit(evaluate_in_child, asked, NOISY, tmp_path).result()
    log = read_eval_log(evaluated)
    assert paper(log) == pytest.approx(numbers)
    errata = suite.source.errata.value
    assert errata == ("current" if protocol == Protocol.STRICT else "none"), "the paper has no errata"
    rules = {"benchmark": domain, "protocol": protocol.value, "planner": PLANNER.value, "errata": errata}
    assert [scorer.options for scorer in log.eval.scorers or ()] == [rules]
    scored = process.submit(score_in_child, evaluated, asked).result()
    assert paper(read_eval_log(scored)) == pytest.approx(numbers)
    written = read_responses(tmp_path / f"{to_file_name(NOISY.model)}_outputs.json", suite.task_ids)
    for answers in (read_answers(ran.log, suite), read_answers(evaluated, suite)):
        assert answers.model == written.model
        assert set(answers.responses) == set(written.responses)
    together = suite.choose_suite_for_answers([response.text for response in written.responses])
    verdicts = [
        record.verdict for record in Scoring().score_records(together, written.model, written.responses)
    ]
    assert shares(compute_metric_rates(verdicts, ability)) == pytest.approx(numbers)


@pytest.mark.parametrize(
    ("protocol", "errata"),
    [
        (Protocol.STRICT, ErrataChoice.NONE),
        (Protocol.STRICT, ErrataChoice.CURRENT),
        *((protocol, None) for protocol in PROTOCOLS[1:]),
    ],
    ids=str,
)
def test_gold_answers_equal_the_published_ones_without_errata(
    data_store: DataPackStore,
    process: Executor,
    tmp_path: Path,
    protocol: Protocol,
    errata: ErrataChoice | None,
) -> None:
    entry = next(each for each in load_all_errata().entries if each.plan)
    domain, ability, task_id = entry.domain, Ability.ACTION_SEQUENCING, entry.tasks[0]
    asked = Asked(domain, ability, protocol, (task_id,), errata or ErrataChoice.CURRENT)
    ran = process.submit(run_in_child, asked, Whom("eai/oracle", {}), tmp_path).result()
    source = Source(data_store, errata=errata or ErrataChoice.NONE)
    gold = open_gold_answers(find_benchmark(domain), ability, source)[task_id].text
    assert [record.response for record in ran.records] == [gold]
    corrected = answer_book(domain, ability, data_store)[task_id].text
    assert (gold == corrected) is (errata is ErrataChoice.CURRENT)


@pytest.mark.parametrize(("domain", "ability"), SUITES, ids=str)
def test_gold_answers_are_right_and_are_the_targets(
    data_store: DataPackStore, process: Executor, tmp_path: Path, domain: str, ability: Ability
) -> None:
    _, asked = some_tasks(domain, ability, Protocol.STRICT)
    asked = asked._replace(task_ids=asked.task_ids[:2])
    path = process.submit(evaluate_in_child, asked, Whom("eai/oracle", {}), tmp_path).result()
    log = read_eval_log(path)
    gold = answer_book(domain, ability, data_store)
    for sample in log.samples or ():
        score = score_in(sample, ability)
        assert (score.value, score.answer) == ("C", sample.target)
        assert sample.target == gold[str(sample.id)].text
    assert log.results is not None
    assert log.results.headline is not None
    assert log.results.headline.metric in ("task_success", "overall.f1")
    assert paper(log)[log.results.headline.metric] == 1.0


def test_of_several_answers_the_most_frequent_one_counts(
    data_store: DataPackStore, process: Executor, tmp_path: Path
) -> None:
    suite, asked = some_tasks(*PLANS, Protocol.STRICT)
    noisy = NOISY._replace(epochs=3)
    ran = process.submit(run_in_child, asked, noisy, tmp_path).result()
    numbers = shares(ran.rates)
    assert any(rates != ran.rates for rates in ran.of_epochs)
    for path in (ran.log, process.submit(evaluate_in_child, asked, noisy, tmp_path).result()):
        log = read_eval_log(path)
        assert len(log.samples or ()) == 3 * TASK_COUNT
        assert paper(log) == pytest.approx(numbers)
        assert len(read_answers(path, suite).responses) == TASK_COUNT
        assert log.results is not None
        right, counted = (
            sum(getattr(rates["task_success"], side) for rates in ran.of_epochs)
            for side in ("numerator", "denominator")
        )
        (accuracy,) = (s.metrics["accuracy"].value for s in log.results.scores if "accuracy" in s.metrics)
        assert accuracy == pytest.approx(right / counted)


def test_a_sample_shows_the_explanation_of_its_score(
    data_store: DataPackStore, process: Executor, tmp_path: Path
) -> None:
    asked = Asked(*PLANS, Protocol.STRICT, ("27_2",))
    ran = process.submit(run_in_child, asked, Whom("eai/noisy", {"rate": 0.35, "seed": 5}), tmp_path).result()
    (sample,) = read_eval_log(ran.log).samples or ()
    (record,) = ran.records
    score = score_in(sample, PLANS[1])
    assert isinstance(sample.input, list)
    assert sample.input[-1].text == official_prompts(*PLANS, data_store)["27_2"].user
    assert sample.target == answer_book(*PLANS, data_store)["27_2"].text
    assert sample.messages[-1].text == score.answer == record.response
    assert record.verdict.error is not None
    assert record.explanation is not None
    assert score.value == "I"
    assert score.explanation is not None
    assert score.explanation.startswith("**")
    assert record.verdict.error.detail in score.explanation
    for step in record.explanation.steps:
        assert f"`{step.action}`: " in score.explanation
    for goal in record.explanation.goals:
        assert f"{'✓' if goal.satisfied else '✗'} {goal.kind} `{goal.goal}`" in score.explanation
    told = record_from_json(score.metadata or {})
    assert (told.verdict, told.origin) == (record.verdict, record.origin)


def test_a_failed_request_is_shown_and_counts_as_a_failure(
    data_store: DataPackStore, process: Executor, tmp_path: Path
) -> None:
    _, asked = some_tasks(*PLANS, Protocol.STRICT)
    asked = asked._replace(task_ids=asked.task_ids[:3])
    answers = [answer_book(*PLANS, data_store)[asked.task_ids[0]].text, None, None]
    log = read_eval_log(process.submit(evaluate_answers_in_child, asked, answers, tmp_path).result())
    assert log.results is not None
    assert [(s.scored_samples, s.unscored_samples) for s in log.results.scores] == [(3, 0)] * 2
    assert paper(log)["task_success"] == pytest.approx(1 / 3)
    failed = [sample for sample in log.samples or () if sample.error is not None]
    assert len(failed) == 2
    for sample in failed:
        score = score_in(sample, PLANS[1])
        assert (score.value, score.explanation) == ("I", "**Not answered: the request failed**")


def test_a_log_cannot_hide_the_rules_of_its_episodes() -> None:
    suite = open_suite(SWITCHES, ACTING)
    easy = {"view": "scene", "observe": "partial", "feedback": "changes", "max_steps": None, "until": "goal"}
    text = json.dumps({"turns": [{"said": "PRESS(lamp)"}], "rules": easy, "harness": "mine"})
    answers = [Response("half", text), Response("both", "", unanswered="the request failed")]
    records = [*Scoring().score_records(suite, "m", answers)]
    for stated, rules in {
        None: "budget-none_until-goal",
        "tokens-9": "budget-none_until-goal",
        "budget-none_tokens-9_until-goal": "budget-none_tokens-9_until-goal",
    }.items():
        older = {"effort": "high", "rules": stated}
        about = {"experiment": older if stated else {"agent": older}}
        found = [add_study_results_to_record(record, suite, about, 1).experiment for record in records]
        assert found == [
            Experiment(harness="mine", effort="high", rules=rules),
            Experiment(effort="high", rules=stated),
        ]
