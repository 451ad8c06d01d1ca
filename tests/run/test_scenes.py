"""Options of perceived scenes in Inspect's tasks: the questions, and the records of a log."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from pathlib import Path

import pytest
from inspect_ai.log import read_eval_log

from eai.abilities.protocol import Ability, Protocol
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.suite import open_suite
from eai.results.codec import read_study_summary, record_from_json
from eai.run.registry import TASKS
from eai.studies.perception.belief import make_scene_graph_vocabulary
from eai.studies.perception.errors import find_perception_errors
from eai.studies.perception.noise import parse_noise, perceive_with_noise
from eai.studies.perception.verdict import ScenePerceptionErrorCounts
from processes import own_process
from run.child import (
    Asked,
    Whom,
    evaluate_experiment_in_child,
    score_in_child,
)

PLANS = Ability.ACTION_SEQUENCING
JARS = "bottling_fruit_0_Wainscott_0_int_0_2021-05-24_19-46-46"
MAKE = TASKS["behavior_action_sequencing"]


@pytest.fixture(scope="module")
def process() -> Iterator[Executor]:
    """A process of its own for Inspect."""
    with own_process() as pool:
        yield pool


def test_a_question_lists_the_perceived_scene_with_its_errors(data_store: DataPackStore) -> None:
    settings = ["unseen=0.3", "invented=0.3", "seed=2"]
    (sample,) = MAKE(tasks=[JARS], prompts="eai", scene="noisy", noise=settings).dataset
    assert isinstance(sample.input, list)
    _, _, own = sample.input[-1].text.rpartition("Your task")
    listed = own.partition("Objects [kind]: properties\n")[2].partition("\n\n")[0].splitlines()
    suite = open_suite("behavior", PLANS)
    words = make_scene_graph_vocabulary(suite.benchmark)
    seen = perceive_with_noise(suite.tasks[JARS], words, parse_noise(settings))
    there = {*words.list_object_names(suite.tasks[JARS])}
    assert {line.partition(" [")[0] for line in listed} == {*seen.mentioned_objects}
    assert {*seen.mentioned_objects} - there
    assert {*words.make_true_graph(suite.tasks[JARS]).mentioned_objects} - {*seen.mentioned_objects}


@pytest.mark.parametrize("domain", ["behavior", "virtualhome"])
def test_a_question_states_a_broader_context_after_the_facts(data_store: DataPackStore, domain: str) -> None:
    """The context has other objects of the scene, further facts, and states that do not hold; it needs no
    picture.
    """
    make, suite = TASKS[f"{domain}_action_sequencing"], open_suite(domain, PLANS)
    task_id = next(i for i in suite.task_ids if suite.tasks[i].unplannable_reason is None)
    questions = {}
    for context in ("none", "some", "many"):
        (sample,) = make(tasks=[task_id], prompts="eai", context=context).dataset
        assert isinstance(sample.input, list)
        questions[context] = sample.input[-1].text.rpartition("Your task")[2]
    task, words = suite.tasks[task_id], make_scene_graph_vocabulary(suite.benchmark).wording
    assert words.describe_initial_state(task) in questions["some"]
    assert len(questions["none"]) < len(questions["some"]) <= len(questions["many"])
    listed = questions["some"].partition("[kind]: properties\n")[2].partition("[kind]: properties\n")[2]
    others = [line.partition(" [")[0] for line in listed.partition("\n\n")[0].splitlines()]
    names = [words.object_name(task, index) for index in task.relevant]
    assert not set(others) & set(names)
    assert (others == ["-"]) == (domain == "behavior")
    untrue = questions["some"].partition("do not hold at the start:\n")[2].partition("\n\n")[0]
    held = set(words.describe_initial_state(task).splitlines())
    assert untrue
    assert not held & {line.removeprefix("not ") for line in untrue.splitlines()}


def test_invalid_scene_options_are_refused(data_store: DataPackStore) -> None:
    for wrong, message in (
        ({"scene": "image"}, "published prompts show scenes only in their own format"),
        ({"scene": "seen"}, "perception.scene: expected 'text', 'image', "),
        ({"scene": "predicted"}, "scene: a task in Inspect cannot ask a second model for scenes"),
        ({"scene": "image", "noise": "missing=0.1"}, "has no effect with perception.scene image"),
        ({"scene": "noisy", "prompts": "eai"}, "expected rates of errors"),
        ({"scene": "noisy", "prompts": "eai", "noise": "mising=1"}, "did you mean missing"),
        (
            {"scene": "numbered", "prompts": "eai", "replans": 1, "world": "continue"},
            "perception.scene numbered: cannot be combined with replanning.replans, "
            "slip or until; the scene is only ",
        ),
        ({"noise": "missing=0.1"}, "has no effect with perception.scene text"),
    ):
        with pytest.raises(InputError, match=message):
            MAKE(tasks=[JARS], **wrong)
    with pytest.raises(InputError, match="questions of transition_modeling describe no scene"):
        TASKS["behavior_transition_modeling"](scene="image", prompts="eai")


def test_records_of_a_log_have_the_perceived_scene(
    data_store: DataPackStore, process: Executor, tmp_path: Path
) -> None:
    """The planner acts on the perceived scene; scoring the log again changes nothing."""
    asked = Asked("behavior", PLANS, Protocol.STRICT, [JARS])
    settings = ["missing=0.3", "seed=1"]
    told = {"scene": "noisy", "noise": settings, "prompts": "eai"}
    path = process.submit(evaluate_experiment_in_child, asked, Whom("eai/planner", {}), tmp_path, told)
    scored = process.submit(score_in_child, path.result(), asked).result()
    suite = open_suite("behavior", PLANS)
    task, words = suite.tasks[JARS], make_scene_graph_vocabulary(suite.benchmark)
    expected = find_perception_errors(task, words, perceive_with_noise(task, words, parse_noise(settings)))
    for log in (read_eval_log(path.result()), read_eval_log(scored)):
        (sample,) = log.samples or ()
        record = record_from_json((sample.scores or {})[PLANS.value].metadata or {})
        assert record.experiment is not None
        assert record.experiment.label == "scene-noisy-missing-0.3-seed-1"
        assert read_study_summary(record, "perception", ScenePerceptionErrorCounts) == expected
        assert expected.missing > 0
