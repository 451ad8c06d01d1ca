"""Runs that combine studies: every pair, its records, its rescored log, and its analyses."""

from __future__ import annotations

import json
from collections.abc import Mapping
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest

from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.results.record import Record
from eai.results.records import read_records
from eai.run.spec import read_spec
from eai.studies.records import StudyRecords
from processes import Outcome, eai

NOISE = "--with perception.scene=noisy --with perception.noise.missing=0.1"
CHOICES: Mapping[str, str] = {
    "goals": "--with pipeline.goals=own",
    "scene": NOISE,
    "replanning": "--with replanning.replans=2 --with replanning.slip=0.1",
    "prompt": "--with prompts.name=mine",
}
WHAT = "--domain behavior --ability action_sequencing --limit 3 --set eai"
RUN = f"run {WHAT} --quiet --model eai/noisy -M rate=0.3"
SUITE = Path("behavior", "action_sequencing")


def command(text: str, folder: Path) -> Outcome:
    """Run a command and return its output files; ``@`` stands for the folder."""
    return eai(*text.replace("@", f"{folder}").split())


def records_in(folder: Path) -> list[Record]:
    files = [*(folder / SUITE).rglob("records.jsonl")]
    assert len(files) == 1
    return [*read_records(files[0])]


def as_scored(record: Record) -> dict[str, Any]:
    """Return a record without its origin, which a log does not have."""
    attempts = [(each.response, each.verdict, each.slipped_at) for each in record.attempts]
    return {
        "task": record.task_id,
        "verdict": record.verdict,
        "experiment": record.experiment,
        "summaries": record.summaries,
        "attempts": attempts,
    }


@pytest.mark.parametrize("pair", [*combinations(CHOICES, 2), tuple(CHOICES)], ids="+".join)
def test_a_run_combines_studies_and_its_log_gets_the_same_scores(
    pair: tuple[str, ...], data_store: DataPackStore, tmp_path: Path
) -> None:
    done = command(f"{RUN} {' '.join(CHOICES[name] for name in pair)} --out @/runs", tmp_path)
    assert done.status == 0, done.err
    records = records_in(tmp_path / "runs")
    (experiment,) = {record.experiment for record in records}
    assert experiment is not None
    said = {
        "goals": "goals-eai_noisy" in experiment.label and all("pipeline" in r.summaries for r in records),
        "scene": "scene-" in experiment.label and all("perception" in r.summaries for r in records),
        "replanning": "replans-2" in experiment.label and all(record.attempts for record in records),
        "prompt": experiment.label.endswith("prompt-mine"),
    }
    assert {name for name, is_so in said.items() if is_so} == set(pair)
    (log,) = (tmp_path / "runs" / "logs").glob("*action-sequencing*.eval")
    again = f"score {log} --domain behavior --ability action_sequencing --out @/again"
    assert command(again, tmp_path).status == 0
    scored = [*read_records(tmp_path / "again" / "records.jsonl")]
    asked = {record.task_id for record in records}
    assert [as_scored(each) for each in scored if each.task_id in asked] == [*map(as_scored, records)]
    assert {record.experiment for record in scored} == {experiment}


def test_goals_are_interpreted_in_the_perceived_scene(data_store: DataPackStore, tmp_path: Path) -> None:
    """The first stage is a run with the perceived scene of the second, and its records state the scene."""
    done = command(f"{RUN} {CHOICES['goals']} {NOISE} --out @/runs", tmp_path)
    assert done.status == 0, done.err
    (file,) = (tmp_path / "runs" / "behavior" / "goal_interpretation").rglob("records.jsonl")
    (label,) = {record.experiment and record.experiment.label for record in read_records(file)}
    assert label == "scene-noisy-missing-0.1-seed-0"


def test_analyses_compare_runs_that_differ_in_one_study(data_store: DataPackStore, tmp_path: Path) -> None:
    for names in (("replanning",), ("replanning", "goals"), ("replanning", "scene")):
        done = command(f"{RUN} {' '.join(CHOICES[name] for name in names)} --out @/runs", tmp_path)
        assert done.status == 0, done.err
    for study, table in (
        ("pipeline", "stages"),
        ("perception", "perception_runs"),
        ("replanning", "attempts"),
    ):
        done = command(f"analyze {study} @/runs/behavior/action_sequencing --out @/{study}", tmp_path)
        assert done.status == 0, done.err
        assert (tmp_path / study / f"{table}.csv").is_file()
    scenes = (tmp_path / "perception" / "perception_runs.csv").read_text().splitlines()[1:]
    assert [line.partition(",")[0] for line in scenes] == ["text", "noisy-missing-0.1-seed-0"]
    report = command("report @/runs --out @/report", tmp_path)
    assert report.status == 0, report.err
    page = (tmp_path / "report" / "report.md").read_text()
    assert "scene-noisy-missing-0.1-seed-0+replans-2-restart-explained" in page
    shown = command("explain @/runs/behavior/action_sequencing assembling", tmp_path)
    assert "goals-eai_noisy+replans-2" in "".join(shown.out.split())


def test_tidy_tables_never_pool_combinations(data_store: DataPackStore, tmp_path: Path) -> None:
    """Several experiments without a plain run cannot be analysed together."""
    for choice in (CHOICES["scene"], f"{CHOICES['scene']} {CHOICES['prompt']}"):
        assert command(f"{RUN} {choice} --out @/runs", tmp_path).status == 0
    notes: list[str] = []
    records = StudyRecords((tmp_path / "runs",), note=notes.append)
    with pytest.raises(
        InputError,
        match="runs of several experiments cannot be compared in one table; give records of one "
        "of them: scene-",
    ):
        records.make_tidy_tables_of_comparable_runs()
    assert len({line.experiment for line in records.make_all_tables().answers}) == 2
    assert command(f"{RUN} --out @/runs", tmp_path).status == 0
    tables = StudyRecords((tmp_path / "runs",), note=notes.append).make_tidy_tables_of_comparable_runs()
    assert {line.experiment for line in tables.answers} == {None}
    assert len(notes) == 1
    assert "left out because they are experiments: runs with scene-" in notes[0]


def test_two_studies_that_change_the_same_option_are_refused_with_a_reason() -> None:
    with pytest.raises(InputError) as refused:
        read_spec(
            {
                "replanning": {"replans": 1, "world": "continue"},
                "perception": {"scene": "predicted", "scene_model": "eai/captioner"},
            }
        )
    assert str(refused.value).count("\n") == 0
    assert json.dumps(str(refused.value)).count("cannot be combined with") == 1


def test_prompts_in_other_words_are_named_and_compared(data_store: DataPackStore, tmp_path: Path) -> None:
    for model in ("eai/oracle", "eai/noisy"):
        for words in ("eai-brief", "facts"):
            run = f"run --domain behavior --ability action_sequencing --limit 3 --quiet --model {model}"
            done = command(f"{run} --set {words} --out @/runs", tmp_path)
            assert done.status == 0, done.err
    files = sorted((tmp_path / "runs" / SUITE).rglob("records.jsonl"))
    names = [{record.experiment and record.experiment.label for record in read_records(f)} for f in files]
    assert names == [{"prompt-eai-brief"}, {"prompt-facts"}] * 2
    assert command("analyze prompts @/runs --out @/prompts", tmp_path).status == 0
    (table,) = (tmp_path / "prompts").rglob("prompts.csv")
    assert table.read_text().count("eai-brief") == 2
    drawn = {path.stem for path in (tmp_path / "prompts").rglob("*.svg")}
    if drawn:
        assert drawn == {"prompts", "prompts-by-eai_noisy", "prompts-by-eai_oracle"}


@pytest.mark.parametrize("scene", ["", NOISE])
def test_a_chain_states_goals_and_subgoals_of_the_model(
    scene: str, data_store: DataPackStore, tmp_path: Path
) -> None:
    """Every task breaks the chain at one ability, or at none; its log gets the same scores."""
    chain = "--with pipeline.goals=own --with pipeline.subgoals=own"
    for choice in (scene, f"{scene} {chain}"):
        done = command(f"{RUN} {choice} --out @/runs", tmp_path)
        assert done.status == 0, done.err
    files = [file for file in (tmp_path / "runs" / SUITE).rglob("records.jsonl") if "subgoals" in str(file)]
    records = [*read_records(files[0])]
    assert len(files) == 1
    for record in records:
        assert record.experiment is not None
        assert record.experiment.label.startswith("goals-eai_noisy+subgoals-eai_noisy")
        assert record.summaries["pipeline"]["subgoals_success"] in (True, False)
        assert ("perception" in record.summaries) == bool(scene)
    logs = sorted((tmp_path / "runs" / "logs").glob("*action-sequencing*.eval"))
    again = f"score {logs[-1]} --domain behavior --ability action_sequencing --out @/again"
    assert command(again, tmp_path).status == 0
    scored = {each.task_id: each for each in read_records(tmp_path / "again" / "records.jsonl")}
    assert [as_scored(scored[each.task_id]) for each in records] == [*map(as_scored, records)]
    done = command("analyze pipeline @/runs/behavior/action_sequencing --out @/pipeline", tmp_path)
    assert done.status == 0, done.err
    (table,) = (tmp_path / "pipeline").rglob("chain.csv")
    lines = [line.split(",") for line in table.read_text().splitlines()[1:]]
    assert [line[0] for line in lines] == [
        *("goal interpretation", "subgoal decomposition", "action sequencing", "nowhere")
    ]
    assert sum(int(line[1]) for line in lines) == len(records)


def test_subgoals_of_a_chain_need_goals_plans_and_our_prompts(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    for options, why in (
        (
            "--with pipeline.subgoals=own",
            "pipeline.subgoals: also give pipeline.goals, because subgoals are",
        ),
        (
            "--with pipeline.goals=own --with pipeline.subgoals=own --ability subgoal_decomposition",
            "pipeline.subgoals: only questions of action_sequencing can state subgoals",
        ),
        (
            "--with pipeline.goals=own --with pipeline.subgoals=own",
            "pipeline.subgoals: published prompts state no subgoals; choose the prompts of eai by --set eai",
        ),
    ):
        run = f"run --domain behavior --limit 1 --quiet --model eai/oracle {options} --out @/runs"
        done = command(run, tmp_path)
        assert done.status == 2
        assert why in done.err
