"""The tables, the figure and the printed lines of `eai analyze logs`, and its refusals."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import pytest

from agents.switches import DOMAIN, initial
from command_line import Command
from eai import Benchmark, make_task, use_tasks
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.registry import find_benchmark
from eai.extensions.logs import readers, study
from eai.extensions.logs.episode import EpisodeEndReason, EpisodeOutcome, LoggedEpisode, LoggedStep
from eai.extensions.logs.readers import LogReader, read_log, read_logs
from eai.extensions.logs.twin import make_table_of_benchmark_tasks_named_in_logs
from eai.studies.records import StudyRecords
from eai.tasks.source import Source
from eai.world.fault import FaultKind

STEPS = (
    LoggedStep("go to shelf", True, None, "done", 0.0),
    LoggedStep("take cup", False, FaultKind.MISSING_STEP, "no", 0.5),
    LoggedStep("take cup", False, None, "no", 0.25),
)
LOST = LoggedEpisode(
    "t1", EpisodeOutcome.GOAL_UNMET, EpisodeEndReason.BY_AGENT, STEPS, "a", "s", unknown=("seconds",)
)
WON = LoggedEpisode("t2", EpisodeOutcome.WON, EpisodeEndReason.GOAL, STEPS[:1], "a", "s", progress=1.0)


def record(success: int) -> dict[str, object]:
    reward = {"success": success, "deterministic": 1, "n_actions": 5}
    return {"state": "success" if success else "failed", "exception": None, "reward": reward, "progress": 0.5}


def written(folder: Path, name: str, **tasks: int) -> Path:
    records = {task: {"limited": record(success)} for task, success in tasks.items()}
    path = folder / name
    path.write_text(json.dumps({"v": 1, "benchmark": "behavior-1k", "run": "agent", "tasks": records}))
    return path


def read_rows(file: Path) -> list[dict[str, str]]:
    with file.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


def test_the_command_writes_two_tables_and_a_figure_and_says_what_it_took(
    eai: Command, tmp_path: Path
) -> None:
    log, out = written(tmp_path, "run.json", sweep=0, mop=1), tmp_path / "out"
    printed = eai("analyze", "logs", log, "--out", out)
    assert printed.status == 0, printed.err
    assert f"{log}: EAI v2, 2 episodes; not in the log: errors of steps (2)" in printed.out
    (row,) = read_rows(out / "outcomes.csv")
    assert (row["agent"], row["episodes"], row["won"], row["goal unmet"], row["cannot tell"]) == (
        *("agent", "2", "1"),
        *("1", "0"),
    )
    rows = read_rows(out / "episodes.csv")
    assert [(row["task"], row["outcome"], row["best"]) for row in rows] == [
        ("sweep", "goal unmet", "50.0"),
        ("mop", "won", "100.0"),
    ]
    assert (out / "logs.svg").is_file()


def test_first_error_best_moment_and_repeats_come_from_the_steps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    reader = LogReader("made", lambda content: True, lambda path, content: [LOST, WON])
    monkeypatch.setattr(readers, "list_readers", lambda: (reader,))
    (tmp_path / "log").write_text("any")
    (analysis,) = study.LOGS.analyze(StudyRecords((tmp_path / "log",)), study._EpisodeLogOptions())  # type: ignore[misc]
    outcomes, episodes = analysis.tables
    (group,) = outcomes.row_dicts()
    assert (group["log"], group["errors"], str(group["proven"])) == ("made", 2, "50 (1/2)")
    lost, won = episodes.row_dicts()
    assert (lost["actions"], lost["first_error"], lost["kind"]) == (3, 2, "missing_step")
    assert (lost["best"], lost["best_action"], lost["end"], lost["repeats"]) == (50.0, 2, None, 2)
    assert (won["first_error"], won["kind"], won["best"], won["best_action"]) == (None, "", 100.0, None)
    assert analysis.remarks == [f"{tmp_path / 'log'}: made, 2 episodes; not in the log: seconds (1)"]


def test_an_episode_that_is_in_two_logs_is_refused(tmp_path: Path) -> None:
    first, second = written(tmp_path, "a.json", sweep=0), written(tmp_path, "b.json", mop=0, sweep=1)
    with pytest.raises(InputError, match=r"b\.json: the episode agent sweep limited occurs twice"):
        read_logs([first, second])


def test_a_log_without_agents_that_is_given_twice_is_refused(tmp_path: Path) -> None:
    text = "You are in the middle of a room.\nYour task is to: look.\nAct 1: go\nObs 1: done\n"
    (tmp_path / "react.txt").write_text(text)
    with pytest.raises(InputError, match=r"react\.txt: this log is given twice"):
        read_logs([tmp_path, tmp_path / "react.txt"])


def test_a_folder_of_logs_is_read_as_one_run(eai: Command, tmp_path: Path) -> None:
    folder = tmp_path / "logs"
    (folder / "more").mkdir(parents=True)
    (folder / ".DS_Store").write_text("hidden")
    written(folder, "b.json", sweep=0)
    written(folder / "more", "a.json", mop=1)
    text = (
        "Environment #0:\nYou are in the middle of a room.\nYour task is to: look.\nAct 1: go\nObs 1: done\n"
    )
    (folder / "react.txt").write_text(text)
    assert [episode.task for episode in read_logs([folder])[folder]] == ["sweep", "mop", "Environment #0"]
    printed = eai("analyze", "logs", folder)
    assert f"{folder}: EAI v2, ALFWorld, 3 episodes; not in the log" in printed.out, printed.err
    assert f"{folder}: EAI v2, ALFWorld, 3 episodes" in eai("score", folder).out
    assert f"{folder}: EAI v2, ALFWorld, 3 episodes" in eai("explain", folder).out


@pytest.mark.parametrize("command", [["score"], ["analyze", "logs"], ["explain"]])
@pytest.mark.parametrize(
    ("content", "message"),
    [("{}", "unknown log format; expected one of"), ('{"v": 1, "benchmark": "b", "run"', "")],
)
def test_a_folder_with_a_foreign_or_damaged_file_is_refused_with_its_path(
    eai: Command, tmp_path: Path, command: list[str], content: str, message: str
) -> None:
    folder = tmp_path / "logs"
    folder.mkdir()
    written(folder, "a.json", sweep=0)
    (folder / "b.json").write_text(content)
    refused = eai(*command, folder)
    assert (refused.status, refused.out) == (2, "")
    assert refused.err.startswith(f"eai: {folder / 'b.json'}")
    assert message in refused.err


def test_an_empty_folder_has_no_logs(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected logs, found an empty folder"):
        read_logs([tmp_path])


def test_a_folder_with_answers_is_scored(eai: Command, tmp_path: Path) -> None:
    written(tmp_path, "a.json", sweep=0)
    (tmp_path / "m_outputs.json").write_text("[]")
    assert "give --domain and --ability" in eai("score", tmp_path).err


def test_a_log_of_two_forms_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    reader = LogReader("made", lambda content: True, lambda path, content: [LOST])
    monkeypatch.setattr(readers, "list_readers", lambda: (reader, reader))
    with pytest.raises(InputError, match="several log formats fit this file"):
        read_log(written(tmp_path, "a.json", sweep=0))


def test_a_benchmark_with_the_tasks_describes_their_twins_by_length(tmp_path: Path) -> None:
    tasks = [
        make_task("far", "Open the box.", initial(), "not shut(box)", domain=DOMAIN),
        make_task("near", "Light the lamp.", initial(), "lit(lamp)", domain=DOMAIN),
        replace(
            make_task("odd", "Both.", initial(), "lit(lamp)", domain=DOMAIN),
            unsolvable="it contradicts itself",
        ),
    ]
    table = make_table_of_benchmark_tasks_named_in_logs(
        read_log(written(tmp_path, "run.json", odd=1, far=0, near=0, absent=1)),
        {task.id: task for task in tasks},
        Benchmark("switches", DOMAIN, use_tasks(*tasks)),
    )
    near, far, odd = table.row_dicts()
    assert {row["labels"] for row in (near, far, odd)} == {"horizon-atomic"}
    assert (near["task"], near["outcomes"], near["plan"]) == ("near", "limited: goal unmet", 1)
    assert (far["task"], far["plan"], far["conditions"], far["at_start"], far["reason"]) == (
        "far",
        2,
        1,
        0,
        "",
    )
    assert (odd["outcomes"], odd["plan"], odd["reason"]) == ("limited: won", None, "it contradicts itself")


def test_the_outcomes_beside_a_twin_say_which_episodes_ran_out_of_time() -> None:
    late = replace(LOST, task="near", ending=EpisodeEndReason.OUT_OF_TIME)
    task = make_task("near", "Light the lamp.", initial(), "lit(lamp)", domain=DOMAIN)
    benchmark = Benchmark("switches", DOMAIN, use_tasks(task))
    (row,) = make_table_of_benchmark_tasks_named_in_logs(
        [late, replace(WON, task="near")], {"near": task}, benchmark
    ).row_dicts()
    assert row["outcomes"] == "s: goal unmet (out of time), s: won"


def test_hidden_objects_of_a_twin_are_those_that_its_gold_plan_uses_and_nobody_sees(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    benchmark = find_benchmark("behavior-1k")
    tasks = benchmark.tasks(Source(data_store))
    table = make_table_of_benchmark_tasks_named_in_logs(
        read_log(written(tmp_path, "run.json", bringing_water=0, turning_on_radio=1)), tasks, benchmark
    )
    radio, water = table.row_dicts()
    assert (radio["hidden"], radio["plan"]) == ("", 1)
    assert (water["hidden"], water["plan"], water["conditions"]) == ("bottle_1, bottle_2", 6, 3)
    assert radio["labels"] == "device-operation horizon-atomic"
