"""The scene in ``eai run``: every arm runs without a model, goes on where it was, and says what was seen."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from command_line import Command
from eai.base.store import DataPackStore
from eai.results.codec import read_study_summary, record_from_json
from eai.studies.perception.verdict import ScenePerceptionErrorCounts
from processes import eai as run_eai
from studies.told import told_tables

JARS = "bottling_fruit_0_Wainscott_0_int_0_2021-05-24_19-46-46"
HOW = ("run", "--domain", "behavior", "--tasks", JARS, "--set", "eai", "--model")
PLANS = ("eai/planner", "--ability", "action_sequencing")

CONTINUED = ("--with", "replanning.replans=1", "--with", "replanning.world=continue")


def with_options(*options: str) -> tuple[str, ...]:
    return tuple([part for each in options for part in ("--with", f"perception.{each}")])


def lines_of(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


def test_a_noisy_scene_is_told_counted_and_analysed(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    noise = with_options("scene=noisy", "noise.missing=0.3", "noise.seed=1")
    assert run_eai(*HOW, *PLANS, *noise, "--out", tmp_path).status == 0
    folder = tmp_path / "behavior" / "action_sequencing" / "eai_planner" / "scene-noisy-missing-0.3-seed-1"
    (line,) = lines_of(folder / "records.jsonl")
    record = record_from_json(line)
    assert record.experiment is not None
    assert record.settings_by_study["perception"].options == {"scene": "noisy-missing-0.3-seed-1"}
    perceived = read_study_summary(record, "perception", ScenePerceptionErrorCounts)
    assert perceived is not None
    assert perceived.missing == perceived.facts - perceived.perceived > 0
    done = eai("analyze", "perception", tmp_path, "--out", tmp_path / "told", "--no-plots")
    assert (done.status, done.out) == (0, f"4 tables, 0 plots; in {tmp_path / 'told'}\n")
    assert len([*(tmp_path / "told").glob("perception_*.csv")]) == 4
    again = eai("analyze", "perception", tmp_path, "--out", tmp_path / "again", "--no-plots", "--json")
    rows = told_tables(again.out)["perception_runs"]
    (row,) = [row for row in rows if row["scene"] != "text"]
    assert int(row["missing_numerator"]) == perceived.missing
    refused = eai("analyze", "perception", folder.parent / "nothing", "--out", tmp_path / "told")
    assert refused.status == 2


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (with_options("noise.missing=0.1"), "perception.noise: has no effect with perception.scene text"),
        (with_options("scene=noisy"), "perception.scene noisy: expected rates of errors"),
        (
            with_options("scene=image", "noise.missing=0.1"),
            "perception.noise: has no effect with perception.scene image",
        ),
        (
            with_options("scene=predicted"),
            "perception.scene predicted: also give perception.scene_model, the model that lists the scene",
        ),
        (
            with_options("scene=image", "scene_model=eai/captioner"),
            "perception.scene_model: has no effect with perception.scene image",
        ),
        (
            with_options("scene=predicted", "scene_model=eai/oracle"),
            "perception.scene_model eai/oracle: expected eai/captioner",
        ),
        (
            with_options("scene=image", "scene_args.rate=1"),
            "perception.scene_args, perception.scene_base_url: have no effect without "
            "perception.scene_model; also give the model to which they belong",
        ),
        (
            (*with_options("scene=image", "images=x"), *CONTINUED),
            "perception.scene image: cannot be combined with replanning.replans, "
            "slip or until; the scene is only shown at",
        ),
        (
            (*with_options("scene=image"), *CONTINUED, "--with", "replanning.feedback_form=chat"),
            "perception.scene image: cannot be combined with replanning.replans, "
            "slip or until; a chat cannot show pictures",
        ),
        (
            (*with_options("scene=image"), "--ability", "transition_modeling"),
            "perception.scene image: questions of transition_",
        ),
        (
            with_options("scene=image", "images=x", "clutter=some"),
            "perception.clutter: has no effect on your own pictures",
        ),
        (with_options("scene=image", "images=nowhere"), "images nowhere: no picture of 1 of 1 tasks"),
        (
            (*with_options("scene=image"), "--set", "official"),
            "perception.scene image: published prompts show scenes only in their",
        ),
    ],
)
def test_what_makes_no_sense_is_said_in_one_line(
    options: tuple[str, ...], why: str, eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    done = eai(*HOW, "eai/planner", *options, "--out", tmp_path)
    assert done.status == 2
    assert done.err.startswith(f"eai: {why}")
    assert done.err.count("\n") == 1


def test_the_captioner_only_lists_scenes(eai: Command, tmp_path: Path) -> None:
    done = eai("run", "--model", "eai/captioner", "--out", tmp_path)
    assert (done.status, done.err.partition(":")[0]) == (2, "eai")
    assert "this model only lists scenes" in done.err
