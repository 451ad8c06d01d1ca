"""The ability scene_graph: its questions, verdicts, records and comparisons."""

from __future__ import annotations

import json

from eai.abilities.declaration import AnswerOutcome
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.suite import open_suite
from eai.results.batch import Scoring
from eai.results.codec import record_from_json, record_to_json
from eai.results.responses import Response
from eai.results.summary import compute_metric_rates, find_answer_outcome
from eai.studies.perception.scenes import SCENE_GRAPH

LIMIT = 3
ASKED = ("--domain", "behavior", "--ability", "scene_graph", "--limit", LIMIT)


def test_right_wrong_and_unreadable_scene_graphs_have_different_outcomes(data_store: DataPackStore) -> None:
    suite = open_suite("behavior", SCENE_GRAPH)
    task_ids = suite.task_ids[:LIMIT]
    gold = [open_gold_answers(suite.benchmark, SCENE_GRAPH, suite.source)[i].text for i in task_ids]
    less = json.dumps({**json.loads(gold[1]), "facts": json.loads(gold[1])["facts"][1:]})
    answers = [Response(*each) for each in zip(task_ids, (gold[0], less, "I see nothing"), strict=True)]
    records = list(Scoring().score_records(suite, "m", answers, explanations=True))
    outcomes = [AnswerOutcome.SUCCESS, AnswerOutcome.PARTLY_RIGHT, AnswerOutcome.PARSING]
    assert [find_answer_outcome(record) for record in records] == outcomes
    assert [record_from_json(record_to_json(record)) for record in records] == records
    notes = [() if each.explanation is None else each.explanation.notes for each in records]
    assert [len(each) for each in notes[:2]] == [0, 1]
    assert notes[1][0].startswith("not listed: ")
    rates = compute_metric_rates([record.verdict for record in records], SCENE_GRAPH)
    assert (rates["right"].numerator, rates["right"].denominator) == (1, LIMIT)
    assert rates["facts.precision"].percent == 100
    assert (rates["parsing"].numerator, rates["predicate_error"].numerator > 1) == (1, True)
    unanswered = suite.score_missing_answer(task_ids[0])
    assert (unanswered.error, find_answer_outcome(records[0])) == (None, AnswerOutcome.SUCCESS)
