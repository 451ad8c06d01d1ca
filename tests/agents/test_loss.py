"""Episodes that are lost for good: a box that cannot be shut again must stay shut."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from agents.switches import DOMAIN, SWITCHES, initial
from eai import Benchmark, make_task, use_tasks
from eai.agents.declaration import compute_contributions_to_metrics
from eai.agents.setting import ACTING
from eai.agents.verdict import EpisodeVerdict, Recoverability, describe_goal_reachability
from eai.benchmarks.suite import Suite, open_suite
from eai.logic.formula import Atom, Constant, Eventually
from eai.results.batch import score_run
from eai.results.codec import record_from_json, record_to_json
from eai.results.options import ScoringOptions
from eai.results.responses import Response, ResponseFile
from eai.world.action import Action

SUITE = open_suite(SWITCHES, ACTING)


def looked_back(task_id: str, *commands: str, states: int = 1_000, suite: Suite = SUITE) -> EpisodeVerdict:
    look_back = suite.scorer(task_id).assess("\n".join(commands)).analyze_failure
    assert look_back is not None
    verdict = look_back(states)
    assert isinstance(verdict, EpisodeVerdict)
    return verdict


@pytest.mark.parametrize(
    ("commands", "outlook", "lost_at"),
    [
        ((), "open", None),
        (("GO(shed)", "DONE"), "open", None),
        (("PRESS(lamp)", "DONE"), "open", None),
        (("GO(shed)", "OPEN(box)", "GO(hall)", "PRESS(lamp)", "DONE"), "lost", 2),
        (("LOOK", "FLY(box)", "GO(shed)", "OPEN(box)"), "lost", 4),
    ],
)
def test_the_first_turn_after_which_the_goals_are_lost_is_found(
    commands: tuple[str, ...], outlook: Recoverability, lost_at: int | None
) -> None:
    verdict = looked_back("half", *commands)
    assert (verdict.outlook, verdict.lost_at) == (outlook, lost_at)
    assert compute_contributions_to_metrics(verdict)["lost_for_good"] == (outlook == "lost", 1)
    assert compute_contributions_to_metrics(verdict)["outlook_unknown"] == (0, 1)


def test_a_search_that_is_cut_off_proves_nothing() -> None:
    verdict = looked_back("half", "GO(shed)", "OPEN(box)", states=1)
    assert (verdict.outlook, verdict.lost_at) == ("unknown", None)
    assert compute_contributions_to_metrics(verdict)["lost_for_good"] == (0, 0)
    assert compute_contributions_to_metrics(verdict)["outlook_unknown"] == (1, 1)
    assert describe_goal_reachability(verdict).endswith("is not known")


def test_goals_over_time_can_only_be_proved_lost() -> None:
    lit, shut = (Atom(name, (Constant(thing),)) for name, thing in (("lit", "lamp"), ("shut", "box")))
    over_time = make_task("over", "Keep the box shut.", initial(), Eventually(lit), shut)
    index = over_time.scene.index
    over_time = replace(over_time, script=(Action("PRESS", (index["lamp"],)),))
    suite = open_suite(Benchmark("over_time", DOMAIN, use_tasks(over_time)), ACTING)
    assert looked_back("over", "PRESS(lamp)", suite=suite).outlook == "unknown"
    lost = looked_back("over", "GO(shed)", "OPEN(box)", suite=suite)
    assert (lost.outlook, lost.lost_at) == ("lost", 2)


def test_records_have_the_loss_if_a_search_was_requested() -> None:
    answers = ResponseFile("model", (Response("half", "GO(shed)\nOPEN(box)"),))
    (plain,) = score_run(SUITE, answers, {}, ScoringOptions())
    assert isinstance(plain.verdict, EpisodeVerdict)
    assert (plain.verdict.outlook, compute_contributions_to_metrics(plain.verdict)["lost_for_good"]) == (
        None,
        (0, 0),
    )
    (record,) = score_run(SUITE, answers, {}, ScoringOptions(look_back=1_000))
    written = json.loads(json.dumps(record_to_json(record)))
    assert (written["outlook"], written["lost_at"]) == ("lost", 2)
    assert record_from_json(written) == record
    assert isinstance(record.verdict, EpisodeVerdict)
    assert (
        describe_goal_reachability(record.verdict)
        == "lost for good after turn 2: no actions lead to the goals any more"
    )
