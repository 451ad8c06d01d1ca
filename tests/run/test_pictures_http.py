"""Pictures over HTTP: a server gets the user's pictures, and its scene graphs are passed on."""

from __future__ import annotations

import base64
import json
from collections import defaultdict
from pathlib import Path

from eai.base.store import DataPackStore
from processes import eai
from run.server import Reply, serve

JARS = "bottling_fruit_0_Wainscott_0_int_0_2021-05-24_19-46-46"
HOW = ("run", "--domain", "behavior", "--ability", "action_sequencing", "--tasks", JARS, "--set", "eai")
LOCAL = "openai-api/local/scripted"


def url_of(data: bytes, media_type: str) -> str:
    return f"data:{media_type};base64,{base64.b64encode(data).decode()}"


def test_a_users_pictures_go_to_the_first_model_and_its_list_to_the_second(
    data_store: DataPackStore, tmp_path: Path
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
