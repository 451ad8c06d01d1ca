"""Rendered pictures and films in commands."""

from __future__ import annotations

import json
import re
from importlib.util import find_spec
from pathlib import Path

import pytest
from PIL import Image

from by_path import ROOT
from cli.test_scene import JARS
from command_line import Command
from eai.abilities.protocol import Ability
from eai.base.errors import EaiError
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.suite import open_suite
from eai.cli import app
from eai.extensions.scenes.rendered import render_task_images
from eai.results.batch import Scoring
from eai.results.responses import Response, ResponseFile
from eai.studies.perception.choice import ScenePresentationOptions
from eai.studies.perception.scenes import make_scenes_for_prompts_without_captioner
from eai.tasks.prompts.template import PromptTemplates
from eai.tasks.source import Source
from explorer_pages import read_explorer
from extensions.scenes.rooms import kitchen, task_of
from extensions.scenes.test_questions import must_ask_with_pictures
from studies.report.samples import write_runs
from studies.report.test_commands import RUNNER


def test_pictures_of_bodies_and_films_are_written(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    can_draw()
    command = ("export", "pictures", "--domain", "behavior", "--tasks", JARS, "--out", tmp_path)
    assert eai(*command, "--format", "rendered").status == eai(*command, "--format", "gif").status == 0
    endings = ("_head.png", "_near.png", "_top.png", ".gif", ".json")
    assert {path.name for path in tmp_path.iterdir()} == {f"{JARS}{end}" for end in endings}
    refused = eai(*command[:3], "virtualhome", "--tasks", "27_2", "--format", "rendered", "--out", tmp_path)
    assert (refused.status, refused.err[:26]) == (2, "eai: cannot build a scene:")


def test_the_course_of_an_answer_is_filmed(eai: Command, data_store: DataPackStore, tmp_path: Path) -> None:
    can_draw()
    steps = '[{"action": "OPEN", "object": "fridge_97"}, {"action": "LEFT_GRASP", "object": "peach_0"}]'
    (tmp_path / "m_outputs.json").write_text(json.dumps([{"identifier": JARS, "llm_output": steps}]))
    suite = ("--domain", "behavior", "--ability", "action_sequencing")
    assert eai("score", tmp_path / "m_outputs.json", *suite, "--out", tmp_path / "out").status == 0
    films = tmp_path / "report" / "films"
    films.mkdir(parents=True)
    assert eai("explain", tmp_path / "out", JARS, "--film", films).status == 0
    (film,) = films.iterdir()
    with Image.open(film) as moving:
        assert moving.n_frames == 3  # type: ignore[attr-defined]
    assert eai("report", tmp_path / "out", "--no-plots", "--out", films.parent).status == 0
    (run,) = read_explorer((films.parent / "explorer.html").read_text(encoding="utf-8"))["runs"]
    assert [answer["F"] for answer in run["answers"] if "F" in answer] == [f"films/{film.name}"]
    refused = eai("explain", tmp_path / "out", "--failed", "--film", film)
    assert (refused.status, refused.err[:35]) == (2, "eai: --film: expected one answer, f")


@pytest.mark.parametrize(
    ("scene", "told"),
    [
        ("numbered", r"\n0 strawberry_0, 1 fridge_97, 2 peach_0, "),
        ("pointed", r"\nfridge_97: picture [12], \(\d+, \d+\)\n"),
    ],
)
def test_what_numbers_and_pixels_stand_for_is_told(scene: str, told: str, data_store: DataPackStore) -> None:
    can_draw()
    suite = open_suite("behavior", Ability.ACTION_SEQUENCING)
    tasks = {JARS: suite.tasks[JARS]}
    believed = make_scenes_for_prompts_without_captioner(
        ScenePresentationOptions(scene=scene), suite.benchmark, tasks, PromptTemplates()
    )
    belief = believed.beliefs[JARS]
    assert belief.initial is not None
    assert re.search(told, belief.initial)
    assert len(belief.images) == 2


def can_draw() -> None:
    """Skip where scenes with bodies cannot be drawn."""
    if find_spec("mujoco") is None:
        pytest.skip("the extra physics is not installed")
    try:
        render_task_images(task_of(kitchen()), ("near",))
    except EaiError as error:
        pytest.skip(str(error))


@pytest.mark.parametrize("scene", ["rendered", "numbered"])
def test_questions_come_with_rendered_pictures(scene: str, data_store: DataPackStore, tmp_path: Path) -> None:
    can_draw()
    must_ask_with_pictures(scene, tmp_path)


def test_pictures_are_written_with_their_truth(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    done = eai(
        "export", "pictures", "--domain", "behavior", "--tasks", JARS, "--format", "svg", "--out", tmp_path
    )
    assert done.status == 0, done.err
    assert done.out == f"1 picture, each with its scene graph; in {tmp_path}\n"
    assert sorted(file.name for file in tmp_path.iterdir()) == [f"{JARS}.json", f"{JARS}.svg"]
    assert json.loads((tmp_path / f"{JARS}.json").read_text(encoding="utf-8"))["facts"]


def test_pictures_come_from_the_data_set(data_store: DataPackStore, tmp_path: Path) -> None:
    suite = open_suite("behavior", Ability.ACTION_SEQUENCING, source=Source(data_store))
    gold = open_gold_answers(suite.benchmark, suite.ability, suite.source)[suite.task_ids[0]]
    answers = ResponseFile("me", (Response(suite.task_ids[0], gold.text),))
    runs = write_runs(
        tmp_path, [list(Scoring().score_records(suite, answers.model, answers.responses, explanations=True))]
    )
    command = ["report", str(runs), "--no-plots", "--no-prompts", "--pictures", "--out"]
    done = RUNNER.invoke(app, [*command, str(tmp_path / "out"), "--data", str(data_store.folder)])
    assert done.exit_code == 0, done.exception
    data = read_explorer((tmp_path / "out" / "explorer.html").read_text(encoding="utf-8"))
    (answer,) = data["runs"][0]["answers"]
    assert len(answer["P"]) == len(answer["s"]) + 1
    assert max(answer["P"]) < len(answer["chunk"]["scenes"])
    refused = RUNNER.invoke(app, [*command, str(tmp_path / "out"), "--data", str(tmp_path / "none")])
    assert "--pictures: the data set is not on this machine" in str(refused.exception)


def test_the_number_of_pictures_is_printed_as_json(
    eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(ROOT / "examples" / "lamps")
    done = eai(
        "export", "pictures", "--domain", "lamps:lamps", "--format", "svg", "--out", tmp_path, "--json"
    )
    assert done.status == 0, done.err
    assert json.loads(done.out) == {"folder": str(tmp_path), "pictures": 2}
