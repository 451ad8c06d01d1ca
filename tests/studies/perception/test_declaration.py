"""Scene graphs as an ability: they are asked for, judged, recorded and compared as any other is."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from command_line import Command
from eai.abilities.declaration import AnswerOutcome
from eai.base.store import Store
from eai.benchmarks.gold_answers import open_answer_book
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.results.batch import Scoring
from eai.results.codec import record_from_json, record_to_json
from eai.results.responses import Response
from eai.results.summary import outcome, summarise
from eai.studies.perception.scenes import SCENE_GRAPH
from processes import eai as run_eai

LIMIT = 3
ASKED = ("--domain", "behavior", "--ability", "scene_graph", "--limit", LIMIT)


def test_right_wrong_and_no_scene_graphs_are_told_apart(data_store: Store) -> None:
    suite = open_suite("behavior", SCENE_GRAPH)
    task_ids = suite.task_ids[:LIMIT]
    gold = [open_answer_book(suite.benchmark, SCENE_GRAPH, suite.source)[i].text for i in task_ids]
    less = json.dumps({**json.loads(gold[1]), "facts": json.loads(gold[1])["facts"][1:]})
    answers = [Response(*each) for each in zip(task_ids, (gold[0], less, "I see nothing"), strict=True)]
    records = list(Scoring().records(suite, "m", answers, explanations=True))
    outcomes = [AnswerOutcome.SUCCESS, AnswerOutcome.PARTLY_RIGHT, AnswerOutcome.PARSING]
    assert [outcome(record) for record in records] == outcomes
    assert [record_from_json(record_to_json(record)) for record in records] == records
    notes = [() if each.explanation is None else each.explanation.notes for each in records]
    assert [len(each) for each in notes[:2]] == [0, 1]
    assert notes[1][0].startswith("not listed: ")
    rates = summarise([record.verdict for record in records], SCENE_GRAPH)
    assert (rates["right"].numerator, rates["right"].denominator) == (1, LIMIT)
    assert rates["facts.precision"].percent == 100
    assert (rates["parsing"].numerator, rates["predicate_error"].numerator > 1) == (1, True)
    unanswered = suite.unanswered(task_ids[0])
    assert (unanswered.error, outcome(records[0])) == (None, AnswerOutcome.SUCCESS)


def test_a_question_shows_a_picture_and_takes_a_template_of_the_users(
    data_store: Store, tmp_path: Path
) -> None:
    pytest.importorskip("matplotlib")
    from eai.benchmarks.prompt_library import Library

    benchmark = find_benchmark("behavior")
    (tmp_path / "scene_graph.txt").write_text("Look at $objects", encoding="utf-8")
    for folder, begins in ((None, "You see a picture of a scene"), (tmp_path, "Look at ")):
        prompts = Library("official", folder).open(benchmark, SCENE_GRAPH)
        prompt = prompts[next(iter(prompts))]
        assert prompt.user.startswith(begins)
        (image,) = prompt.images
        assert (image.media_type, image.data[1:4]) == ("image/png", b"PNG")


def test_it_is_run_scored_reported_and_compared(eai: Command, data_store: Store, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    out = tmp_path / "out"
    captioner = ("--model", "eai/captioner", "-M", "rate=0.4")
    done = run_eai("run", *captioner, *ASKED, "--out", out)
    assert done.status == 0, done.err
    assert run_eai("run", "--model", "eai/oracle", *ASKED, "--out", out).status == 0
    (own, other) = (out / "behavior" / "scene_graph" / f"eai_{name}" for name in ("oracle", "captioner"))
    answers = other / "eai_captioner_outputs.json"
    again = eai("score", answers, *ASKED[:4], "--out", tmp_path / "again", "--json", "--allow-missing")
    assert again.status == 0, again.err
    (scored,) = json.loads(again.out)
    assert scored["metrics"]["right"]["numerator"] < LIMIT
    compared = eai("compare", own, other, "--json")
    assert compared.status == 0, compared.err
    assert '"scene_graph"' in compared.out
    assert eai("report", out, "--out", tmp_path / "report", "--no-plots").status == 0
    assert "Scene graphs" in (tmp_path / "report" / "report.md").read_text(encoding="utf-8")
    assert '"scene_graph"' in (tmp_path / "report" / "explorer.html").read_text(encoding="utf-8")
