"""The course of an answer: its pictures are those of the states that it passed through."""

from __future__ import annotations

from dataclasses import replace

import pytest

from agents.switches import SWITCHES, WON
from eai.abilities.attempt import Attempt
from eai.abilities.explanation import StepReport, VerdictExplanation, parse_statement
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict
from eai.agents.setting import ACTING
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite, open_suite
from eai.extensions.scenes.course import (
    make_scene_diagram_maker,
    make_scene_diagrams_after_each_step,
    replay_steps,
)
from eai.extensions.scenes.diagrams import make_words_for_picture_labels
from eai.results.batch import Scoring
from eai.results.record import Record
from eai.results.responses import Response
from eai.studies.report.explorer import SceneDiagrams
from eai.tasks.source import Source
from eai.tasks.wording import list_objects_in_prompt
from eai.world.execution import execute_plan
from experiments import experiment
from extensions.scenes.tile_facts import told_by
from studies.perception.kitchen import DOMAIN, KITCHEN, WORDS, fact, kitchen_task

DONE = ("TAKE(cup_1)", "PUT_ON(cup_1, table_1)", "LIGHT(lamp_2)")


def scored(suite: Suite, task_id: str, text: str) -> Record:
    (record,) = Scoring().score_records(suite, "me", [Response(task_id, text)], explanations=True)
    return record


def told(course: SceneDiagrams, agent: str) -> list[set[str]]:
    """The facts in each picture."""
    return [{str(each) for tile in scene for each in told_by(tile, agent)} for scene in course]


def reports(*actions: str) -> tuple[StepReport, ...]:
    return tuple(StepReport(action, "executed", call=parse_statement(action)) for action in actions)


def test_each_step_is_carried_out_again_and_no_other() -> None:
    took, put, _ = reports(*DONE)
    vain = (
        StepReport("LIGHT(cup_1)", "affordance", call=parse_statement("LIGHT(cup_1)")),
        StepReport("LIGHT(lamp_2)", "slip", call=parse_statement("LIGHT(lamp_2)")),
    )
    states = replay_steps(DOMAIN, kitchen_task().initial, [took, *vain, put])
    assert states is not None
    seen = [
        {str(each) for each in WORDS.make_true_graph(replace(kitchen_task(), initial=s)).facts}
        for s in states
    ]
    assert "in(cup_1, box_1)" in seen[0]
    assert "holds(robot, cup_1)" in seen[1]
    assert seen[1] == seen[2] == seen[3]
    assert seen[4] == {str(fact(each)) for each in ("on cup_1 table_1", "on box_1 table_1", "lit lamp_1")}
    assert replay_steps(DOMAIN, kitchen_task().initial, [put]) is None


def test_an_episode_has_a_scene_for_each_turn() -> None:
    suite = open_suite(SWITCHES, ACTING)
    commands = [*WON, "DONE"]
    record, *_ = Scoring().score_records(
        suite, "m", [Response("both", "\n".join(commands))], explanations=True
    )
    assert len(make_scene_diagrams_after_each_step(record, suite)) == 1 + len(commands)


def test_a_world_that_goes_on_begins_where_the_attempt_before_ended() -> None:
    suite = open_suite(KITCHEN, Ability.ACTION_SEQUENCING)
    record = scored(suite, "1", "[]")
    first, last = (VerdictExplanation(steps=reports(*part)) for part in (DONE[:1], DONE[1:]))
    attempts = tuple(Attempt("", PlanVerdict(), explanation=each) for each in (first, last))
    goes_on = replace(record, experiment=experiment(1, "continue"), attempts=attempts, explanation=last)
    start, *rest = told(make_scene_diagrams_after_each_step(goes_on, suite), "robot")
    assert "holds(robot, cup_1)" in start
    assert len(rest) == 2
    begins_anew = replace(goes_on, experiment=experiment(1, "restart"))
    assert (
        make_scene_diagrams_after_each_step(begins_anew, suite) == ()
    )  # the agent cannot put down an object that it has not taken


def test_nothing_is_shown_of_other_data_and_of_what_has_no_plan() -> None:
    suite = open_suite(KITCHEN, Ability.ACTION_SEQUENCING)
    done = replace(scored(suite, "1", "[]"), explanation=VerdictExplanation(steps=reports(*DONE)))
    assert len(make_scene_diagrams_after_each_step(done, suite)) == 4
    assert make_scene_diagrams_after_each_step(replace(done, data_sha256="0" * 64), suite) == ()
    assert make_scene_diagrams_after_each_step(replace(done, task_id="2"), suite) == ()
    assert make_scene_diagram_maker(Source())(replace(done, domain="nowhere")) == ()


@pytest.mark.parametrize("name", ["behavior", "virtualhome"])
@pytest.mark.parametrize("ability", [Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION])
def test_pictures_of_households_begin_and_end_with_what_is_so(
    name: str, ability: Ability, data_store: DataPackStore
) -> None:
    source, benchmark = Source(data_store), find_benchmark(name)
    suite, course = open_suite(name, ability, source=source), make_scene_diagram_maker(source)
    words, book = make_words_for_picture_labels(benchmark), open_gold_answers(benchmark, ability, source)
    for task_id in list(suite.task_ids)[::40]:
        record, task = scored(suite, task_id, book[task_id].text), suite.tasks[task_id]
        assert record.explanation is not None
        scenes = course(record)
        assert len(scenes) == len(record.explanation.steps) + 1
        agent = "" if task.scene.agent is None else words.list_object_names(task)[task.scene.agent]
        first, *_, last = told(scenes, agent)
        assert {str(each) for each in words.make_true_graph(task).facts} <= first
        if ability is Ability.ACTION_SEQUENCING:
            end = execute_plan(benchmark.domain, task.initial, task.script).final_state
            there = words.make_true_graph(replace(task, initial=end), list_objects_in_prompt(task)).facts
            assert {str(each) for each in there} <= last
