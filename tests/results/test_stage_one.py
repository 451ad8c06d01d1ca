"""The first stage of a pipeline: its beliefs from any answer, which do not change verdicts."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite, open_suite
from eai.results.batch import score_run
from eai.results.codec import hash_text, record_from_json, record_to_json
from eai.results.epochs import GoalsAndScenesStatedInPrompts
from eai.results.options import ScoringOptions
from eai.results.record import Record
from eai.results.responses import Response, ResponseFile
from eai.studies.pipeline.stage_one import (
    make_interpreted_goals_for_prompts,
    read_goal_interpretation_answers,
    read_interpreted_goals_for_prompts,
)
from eai.tasks.source import Source
from experiments import experiment
from record_files import write_records
from suites import answer_book

BEHAVIOR = find_benchmark("behavior")
JARS = "bottling_fruit_0_Wainscott_0_int_0_2021-05-24_19-46-46"
GIFTS = "assembling_gift_baskets_0_Beechwood_0_int_0_2021-10-26_12-46-37"


@pytest.fixture
def source(data_store: DataPackStore) -> Source:
    return Source(data_store)


def believed(answer: str, source: Source) -> GoalsAndScenesStatedInPrompts:
    return make_interpreted_goals_for_prompts(("m", {JARS: answer}), BEHAVIOR, source)


LEFT = ("stage_1_unreadable", "stage_1_unknown", "stage_1_left_out")


def said(read: GoalsAndScenesStatedInPrompts) -> Mapping[str, Any]:
    """Return the summary of the stated goals of the one task."""
    return read.summaries[JARS]["pipeline"]


def test_a_gold_answer_states_its_goals(source: Source, data_store: DataPackStore) -> None:
    gold = answer_book("behavior", Ability.GOAL_INTERPRETATION, data_store)[JARS].text
    read = believed(gold, source)
    stated = said(read)
    assert stated["goals_sha256"] == hash_text(gold)
    assert stated["goal_counts"] == [8, 0, 0]
    assert [stated[name] for name in LEFT] == [False, [], 0]
    assert read.beliefs[JARS].task.goals
    assert read.beliefs.keys() == read.summaries.keys() == {JARS}


@pytest.mark.parametrize(
    ("answer", "counts", "unreadable", "unknown", "left_out"),
    [
        ("I do not know.", (0, 0, 8), True, (), 0),
        ('{"node goals": [], "edge goals": []}', (0, 0, 8), False, (), 0),
        ('{"node goals": [["sliced", "peach.n.03_1"]]}', (1, 0, 7), False, (), 0),
        ('{"node goals": [["sliced", "peach.n.03_7"]]}', (0, 1, 8), False, ("peach.n.03_7",), 0),
        ('{"node goals": [["eaten", "peach.n.03_1"]]}', (0, 1, 8), False, ("eaten",), 0),
        ('{"node goals": [["sliced"], 5]}', (0, 2, 8), False, (), 2),
    ],
)
def test_stated_goals_are_counted_by_kind_and_fault(
    answer: str,
    counts: tuple[int, ...],
    unreadable: bool,
    unknown: tuple[str, ...],
    left_out: int,
    source: Source,
) -> None:
    stated = said(believed(answer, source))
    assert stated["goal_counts"] == [*counts]
    assert [stated[name] for name in LEFT] == [unreadable, [*unknown], left_out]


def test_a_wrong_belief_changes_no_verdict(source: Source, data_store: DataPackStore) -> None:
    """The scorer has the true task: the gold plan stays right with any stated goals."""
    suite = open_suite("behavior", Ability.ACTION_SEQUENCING, source=source)
    gold = answer_book("behavior", Ability.ACTION_SEQUENCING, data_store)
    answers = ResponseFile("m", tuple(Response(task, gold[task].text) for task in (GIFTS, JARS)))
    plain = score_run(suite, answers, {}, ScoringOptions())
    wrong = believed('{"node goals": [["open", "jar.n.01_1"], ["not", ["sliced", "peach.n.03_1"]]]}', source)
    marked = [wrong.add_experiment_and_study_summaries(record) for record in plain]
    assert all(getattr(record.verdict, "success", False) for record in plain)
    assert [replace(record, experiment=None, summaries={}) for record in marked] == plain
    assert {record.experiment for record in marked} == {experiment(goals_from="m")}
    assert [record.summaries.get("pipeline") for record in marked] == [None, said(wrong)]
    assert suite.tasks[JARS].goals != wrong.beliefs[JARS].task.goals


def test_records_have_the_stated_goals_in_their_summary(source: Source) -> None:
    suite = open_suite("behavior", Ability.ACTION_SEQUENCING, source=source)
    (plain,) = score_run(suite, ResponseFile("m", (Response(JARS, "[]"),)), {}, ScoringOptions())
    marked = believed(
        '{"node goals": [["eaten", "peach.n.03_1"]]}', source
    ).add_experiment_and_study_summaries(plain)
    written = json.loads(json.dumps(record_to_json(marked)))
    part = written["study"]["pipeline"]
    assert (part["label"], part["options"]) == ("goals-m", {"goals_from": "m"})
    assert part["summary"]["goal_counts"] == [0, 1, 8]
    assert part["summary"]["stage_1_unknown"] == ["eaten"]
    assert record_from_json(written) == marked


def goal_records(suite: Suite, model: str) -> list[Record]:
    answers = ResponseFile(model, (Response(JARS, f'{{"node goals": [["{model}", "x"]]}}'),))
    return score_run(suite, answers, {GIFTS: "the provider failed"}, ScoringOptions(explanations=False))


def test_answers_are_found_in_responses_records_and_folders(source: Source, tmp_path: Path) -> None:
    suite = open_suite("behavior", Ability.GOAL_INTERPRETATION, source=source)
    responses = tmp_path / "files" / "alpha_outputs.json"
    responses.parent.mkdir()
    responses.write_text(json.dumps([{"identifier": JARS, "llm_output": "said"}]), encoding="utf-8")
    for path in (responses, responses.parent):
        assert read_goal_interpretation_answers(path, BEHAVIOR, source) == ("alpha", {JARS: "said"})
    runs = tmp_path / "runs"
    for model in ("alpha", "org_beta"):
        (runs / model).mkdir(parents=True)
        write_records(runs / model / "records.jsonl", goal_records(suite, model))
    alone = read_goal_interpretation_answers(runs / "alpha" / "records.jsonl", BEHAVIOR, source)
    assert alone == ("alpha", {JARS: '{"node goals": [["alpha", "x"]]}'})
    assert read_goal_interpretation_answers(runs / "alpha", BEHAVIOR, source) == alone
    assert read_goal_interpretation_answers(runs, BEHAVIOR, source, "org/beta")[0] == "org_beta"
    with pytest.raises(InputError, match="of one model, found alpha, org_beta"):
        read_goal_interpretation_answers(runs, BEHAVIOR, source, "gamma")
    with pytest.raises(InputError, match="goal_interpretation of one model, found none"):
        read_goal_interpretation_answers(
            runs / "alpha" / "records.jsonl", find_benchmark("virtualhome"), source
        )


def test_two_runs_of_a_model_are_refused(source: Source, tmp_path: Path) -> None:
    """Two runs of one model may differ in prompts or scenes, so their answers are not mixed."""
    suite = open_suite(BEHAVIOR, Ability.GOAL_INTERPRETATION, source=source)
    answers = ResponseFile("m", (Response(JARS, '{"node goals": []}'),))
    records = [*score_run(suite, answers, {}, ScoringOptions())]
    write_records(tmp_path / "plain" / "records.jsonl", records)
    assert read_goal_interpretation_answers(tmp_path, BEHAVIOR, source)[0] == "m"
    varied = [replace(each, experiment=experiment(prompt_name="eai-brief")) for each in records]
    write_records(tmp_path / "brief" / "records.jsonl", varied)
    with pytest.raises(InputError, match="2 runs of m answer behavior goal_interpretation; give the folder"):
        read_goal_interpretation_answers(tmp_path, BEHAVIOR, source)
    assert read_goal_interpretation_answers(tmp_path / "brief", BEHAVIOR, source)[0] == "m"


def test_only_plans_and_subgoals_have_a_first_stage(source: Source, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="questions of transition_modeling state no goals"):
        read_interpreted_goals_for_prompts(tmp_path, BEHAVIOR, Ability.TRANSITION_MODELING, source)
