"""Pictures over HTTP: a server is sent the very bytes that are drawn, and its scene graphs are told on."""

from __future__ import annotations

import base64
import json
from collections import defaultdict
from pathlib import Path

import pytest

from eai.abilities.protocol import Ability
from eai.base.store import Store
from eai.benchmarks.registry import find_benchmark
from eai.studies.perception.belief import scene_words
from eai.studies.perception.drawing import png
from eai.studies.perception.picture import picture_of, picture_words
from eai.tasks.source import Source
from processes import eai
from run.server import Reply, serve

pytest.importorskip("matplotlib")

JARS = "bottling_fruit_0_Wainscott_0_int_0_2021-05-24_19-46-46"
HOW = ("run", "--domain", "behavior", "--ability", "action_sequencing", "--tasks", JARS, "--set", "eai")
LOCAL = "openai-api/local/scripted"


def url_of(data: bytes, media_type: str) -> str:
    return f"data:{media_type};base64,{base64.b64encode(data).decode()}"


@pytest.mark.parametrize(("scene", "clutter"), [("image", "none"), ("both", "many")])
def test_a_server_is_sent_the_picture(scene: str, clutter: str, data_store: Store, tmp_path: Path) -> None:
    task = find_benchmark("behavior").tasks_for(Ability.ACTION_SEQUENCING, Source(data_store))[JARS]
    benchmark = find_benchmark("behavior")
    drawn = png(picture_of(task, picture_words(benchmark), clutter)[0])
    wording = scene_words(benchmark).wording
    shown = ("--with", f"perception.scene={scene}", "--with", f"perception.clutter={clutter}")
    how = (*shown, "-M", "api_key=none", "--out", tmp_path)
    with serve(defaultdict(lambda: [Reply("[]")])) as served:
        done = eai(*HOW, "--model", LOCAL, "--model-base-url", served.url, *how)
        assert done.status == 0, done.err
    (request,) = served.log.requests
    shown, told = request["messages"][-1]["content"]
    assert shown["image_url"]["url"] == url_of(drawn, "image/png")
    facts = wording.initial(task).splitlines()
    assert all((fact in told["text"]) is (scene == "both") for fact in facts)
    assert wording.objects(task) in told["text"]
    said = (
        "The picture shows the same."
        if scene == "both"
        else "Initial state:\nWhat holds is in the picture alone."
    )
    assert f"{said}\n\nGoals:" in told["text"]


def test_own_pictures_go_to_the_model_that_sees_and_its_list_to_the_other(
    data_store: Store, tmp_path: Path
) -> None:
    for view, data in (("left", b"one"), ("right", b"two")):
        (tmp_path / f"{JARS}_{view}.jpg").write_bytes(data)
    graph = json.dumps({"objects": ["fridge_97"], "facts": [["open", "fridge_97"], ["cosy", "fridge_97"]]})
    captioner = {
        "scene": "predicted",
        "scene_model": LOCAL,
        "scene_args.api_key": "none",
        "images": tmp_path,
    }
    out = tmp_path / "out"
    with serve(defaultdict(lambda: [Reply(f"```json\n{graph}\n```")])) as served:
        chosen = {**captioner, "scene_base_url": served.url}
        options = [part for name in chosen for part in ("--with", f"perception.{name}={chosen[name]}")]
        address = ("--model-base-url", served.url)
        done = eai(*HOW, "--model", LOCAL, "-M", "api_key=none", *options, *address, "--out", out)
        assert done.status == 0, done.err
    look, plan = served.log.requests
    *pictures, question = look["messages"][-1]["content"]
    assert [part["image_url"]["url"] for part in pictures] == [
        url_of(b, "image/jpeg") for b in (b"one", b"two")
    ]
    assert "scene graph" in question["text"]
    assert "Initial state:\nopen(fridge_97)\n\nGoals:" in plan["messages"][-1]["content"]
    folder = out / "behavior" / "scene_graph" / "openai-api_local_scripted" / "scene-image-own"
    (line,) = (folder / "records.jsonl").read_text().splitlines()
    listed = json.loads(line)
    assert (listed["repairs"], listed["seen"]["ill_formed"]) == (["code_fence"], 1)
    assert 'no fact: ["cosy", "fridge_97"]' in listed["explanation"]["notes"]
