"""Questions with pictures: the prompts, the requests to a server, and the answers."""

from __future__ import annotations

import json
from collections import defaultdict
from importlib.util import find_spec
from pathlib import Path

import inspect_ai
import pytest
from inspect_ai.model import ContentImage

from cli.test_scene import HOW, JARS, PLANS, lines_of, with_options
from command_line import Command
from eai.abilities.protocol import SCENE_GRAPH, Ability
from eai.agents.play import EpisodeFactory
from eai.agents.setting import ACTING
from eai.base.store import DataPackStore
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.extensions.scenes.diagrams import draw_scene, make_words_for_picture_labels
from eai.extensions.scenes.drawing import to_png
from eai.run.registry import TASKS
from eai.studies.perception.belief import make_scene_graph_vocabulary
from eai.tasks.source import Source
from explorer_pages import read_explorer
from processes import eai as run_eai
from run.server import Reply, serve
from run.test_acting import call, scripted, tool
from run.test_pictures_http import LOCAL, url_of
from studies.perception.test_declaration import ASKED, LIMIT

pytest.importorskip("matplotlib")


def test_a_model_sees_for_another_one(data_store: DataPackStore, tmp_path: Path) -> None:
    """The second run reads the scene graph from the journal."""
    predicted = with_options(
        "scene=predicted", "scene_model=eai/captioner", "scene_args.rate=0.5", "clutter=some"
    )
    abilities = ("--ability", "subgoal_decomposition", *PLANS[1:])
    folder = tmp_path / "behavior" / "scene_graph" / "eai_captioner" / "scene-image-some"
    for _ in range(2):
        command = (*HOW, PLANS[0], *abilities, *predicted, "--out", tmp_path)
        done = run_eai(*command)
        assert done.status == 0, done.err
        assert "BEHAVIOR, scene graphs, protocol strict" in done.out
        assert len(lines_of(folder / "answers.jsonl")) == 1
    (seen,) = lines_of(folder / "records.jsonl")
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    lost = seen["seen"]["missing"] + seen["seen"]["misplaced"]
    assert summary["predicate_error"]["numerator"] == lost > 0
    for ability in ("action_sequencing", "subgoal_decomposition"):
        label = "scene-predicted-eai_captioner-some"
        (line,) = lines_of(tmp_path / "behavior" / ability / "eai_planner" / label / "records.jsonl")
        assert line["study"]["perception"]["summary"] == seen["seen"]


def must_ask_with_pictures(scene: str, folder: Path) -> None:
    """Fail unless gold answers stay right: pictures change the question, and not its scoring."""
    asked = ("eai/oracle", "--ability", "goal_interpretation", *with_options(f"scene={scene}"))
    assert run_eai(*HOW, *asked, "--out", folder).status == 0
    (line,) = lines_of(
        folder / "behavior" / "goal_interpretation" / "eai_oracle" / f"scene-{scene}" / "records.jsonl"
    )
    assert line["counts"]["all"][1:] == [0, 0]
    assert "perceived" not in line


@pytest.mark.parametrize("scene", ["image", "both"])
def test_questions_come_with_pictures(scene: str, data_store: DataPackStore, tmp_path: Path) -> None:
    must_ask_with_pictures(scene, tmp_path)


@pytest.mark.parametrize(("scene", "clutter"), [("image", "none"), ("both", "many")])
def test_a_server_is_sent_the_picture(
    scene: str, clutter: str, data_store: DataPackStore, tmp_path: Path
) -> None:
    task = find_benchmark("behavior").tasks_for(Ability.ACTION_SEQUENCING, Source(data_store))[JARS]
    benchmark = find_benchmark("behavior")
    drawn = to_png(draw_scene(task, make_words_for_picture_labels(benchmark), clutter)[0])
    wording = make_scene_graph_vocabulary(benchmark).wording
    shown = ("--with", f"perception.scene={scene}", "--with", f"perception.clutter={clutter}")
    how = (*shown, "-M", "api_key=none", "--out", tmp_path)
    with serve(defaultdict(lambda: [Reply("[]")])) as served:
        whom = (LOCAL, *PLANS[1:], "--model-base-url", served.url)
        done = run_eai(*HOW, *whom, *how)
        assert done.status == 0, done.err
    (request,) = served.log.requests
    shown, told = request["messages"][-1]["content"]
    assert shown["image_url"]["url"] == url_of(drawn, "image/png")
    facts = wording.describe_initial_state(task).splitlines()
    assert all((fact in told["text"]) is (scene == "both") for fact in facts)
    assert wording.describe_objects(task) in told["text"]
    said = (
        "The picture shows the same."
        if scene == "both"
        else "Initial state:\nWhat holds is in the picture alone."
    )
    assert f"{said}\n\nGoals:" in told["text"]


@pytest.mark.parametrize(("scene", "told"), [("image", False), ("both", True)])
def test_a_task_shows_pictures(data_store: DataPackStore, scene: str, told: bool) -> None:
    (sample,) = TASKS["behavior_action_sequencing"](
        tasks=[JARS], prompts="eai", scene=scene, clutter="none"
    ).dataset
    assert isinstance(sample.input, list)
    picture, *_ = sample.input[-1].content
    assert isinstance(picture, ContentImage)
    assert picture.image.startswith("data:image/png;base64,")
    suite = open_suite("behavior", Ability.ACTION_SEQUENCING)
    facts = (
        make_scene_graph_vocabulary(suite.benchmark)
        .wording.describe_initial_state(suite.tasks[JARS])
        .splitlines()
    )
    assert all((fact in sample.input[-1].text) is told for fact in facts)


def test_a_question_shows_a_picture_and_takes_a_template_of_the_users(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    benchmark = find_benchmark("behavior")
    (tmp_path / "scene_graph.txt").write_text("Look at $objects", encoding="utf-8")
    for folder, begins in ((None, "You see a picture of a scene"), (tmp_path, "Look at ")):
        prompts = PromptLibrary("official", folder).open(benchmark, SCENE_GRAPH)
        prompt = prompts[next(iter(prompts))]
        assert prompt.user.startswith(begins)
        (image,) = prompt.images
        assert (image.media_type, image.data[1:4]) == ("image/png", b"PNG")


def test_it_is_run_scored_reported_and_compared(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
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
    page = (tmp_path / "report" / "explorer.html").read_text(encoding="utf-8")
    assert '"scene_graph"' in json.dumps(read_explorer(page))


@pytest.mark.filterwarnings("ignore")  # Inspect's
def test_a_model_is_shown_the_world_after_each_action(data_store: DataPackStore, tmp_path: Path) -> None:
    if find_spec("mujoco") is None:
        pytest.skip("the extra physics is not installed")
    suite = open_suite("behavior", ACTING)
    picked = next(each for each in suite.task_ids if each.startswith("installing_a_modem"))
    first = (EpisodeFactory(suite.benchmark).make_setup(suite.tasks[picked]).reference.commands or ())[0]
    setting = {"feedback": "pictures", "observe": "full"}
    task = TASKS["behavior_acting"](tasks=[picked], **setting)
    model = scripted([call(first), call("FLY(moon)"), tool("done")])
    (log,) = inspect_ai.eval(task, model=model, log_dir=str(tmp_path), display="none")
    (sample,) = log.samples or ()
    assert sample.error is None, sample.error
    asked, moved, failed, over = [each for each in sample.messages if each.role in ("user", "tool")]
    assert "Now:\nWhat the pictures show." in asked.text
    shown = [[part.image for part in each.content if part.type == "image"] for each in (asked, moved, failed)]
    assert [len(images) for images in shown] == [2, 2, 2]
    assert shown[0] != shown[1] == shown[2]
    assert over.text.endswith("The episode is over.")
    assert over.text == over.content
