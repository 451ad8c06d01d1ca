from __future__ import annotations

from dataclasses import replace

import pytest

from abilities import test_goals_over_time as over_time
from abilities.test_trial import BOTH, LAMP, SUITE, plan
from by_path import ROOT
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.protocol import Protocol
from eai.abilities.replanning_options import ReplanningOptions
from eai.benchmarks.registry import find_benchmark
from eai.extensions.reference.protocol import _TrialWithRandomFailures
from eai.results.runs import Run, RunKey, recount_errors_as_in_paper
from eai.results.summary import compute_metric_rates
from studies.test_replanning import EARLY, NONE, run_of


def test_the_published_counts_know_of_no_error_before_the_last_attempt() -> None:
    """Three tasks: one reached its goals and failed on attempt 1, one did on attempt 3, one never did."""
    through, lost = [plan(*BOTH, LAMP)], [EARLY, EARLY, EARLY]
    runs = run_of(NONE, [through, [EARLY, EARLY, plan(*BOTH, LAMP)], lost])
    reached = [  # as the rules of the reference have it, goals count although the plan fails after
        replace(
            record,
            attempts=tuple(
                replace(each, verdict=replace(each.verdict, success=all(each.verdict.goals_satisfied)))
                for each in record.attempts
            ),
        )
        for record in (replace(r, attempts=r.attempts[:3]) for r in runs)
    ]
    reached = [replace(record, verdict=record.attempts[-1].verdict) for record in reached]
    plain = compute_metric_rates([record.verdict for record in reached], SUITE.ability)
    key = RunKey(Protocol.STRICT, reached[0].domain, SUITE.ability, "m")
    counted = recount_errors_as_in_paper(Run(key, tuple(reached))).records
    then = compute_metric_rates([record.verdict for record in counted], SUITE.ability)
    assert [rates["task_success"].numerator for rates in (plain, then)] == [2, 2]
    assert [rates["execution_success"].numerator for rates in (plain, then)] == [0, 0]
    assert [rates["wrong_order"].numerator for rates in (plain, then)] == [2, 1]
    assert [rates["missing_step"].numerator for rates in (plain, then)] == [1, 1]


def test_a_further_attempt_keeps_the_history_of_the_world(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "examples" / "lamps")
    lamps = find_benchmark("lamps:lamps")
    task = over_time.task(lamps, "lit(lamp_1)", over_time.TAKEN)
    scorer = ActionSequencingScorer(task, lamps.domain, lamps.notation.plans)
    trial = _TrialWithRandomFailures(scorer, ReplanningOptions(replans=2, world="continue", until="goal"))
    failed = trial.try_answer(over_time.plan(lamps, task, "GO ball, TAKE ball, GO lamp_1, TAKE lamp_1"))
    assert not failed.verdict.executable
    assert trial.try_answer(over_time.plan(lamps, task, "PRESS lamp_1")).verdict.success
