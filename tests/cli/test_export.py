from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import eai as library
from by_path import ROOT
from command_line import Command
from eai.abilities.attempt import AnswerUsage
from eai.base.store import DataPackStore
from eai.results.epochs import ModelAnswers, score_answers
from eai.results.options import ScoringOptions
from eai.results.trials import Answer
from suites import answer_book, official_prompts

SUITE = ("--domain", "behavior", "--ability", "action_sequencing")


def read(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


@pytest.fixture
def records(data_store: DataPackStore, tmp_path: Path) -> Path:
    """Right answers to five tasks, the same from another model, and ones that stop half way."""
    suite = library.open("behavior", "action_sequencing")
    task_ids = suite.task_ids[:5]
    book = answer_book("behavior", suite.ability)
    asked = official_prompts("behavior", suite.ability)
    prompts = {task_id: asked[task_id] for task_id in task_ids}
    right = {task_id: book[task_id].parts for task_id in task_ids}
    half = {task_id: parts[: len(parts) // 2] for task_id, parts in right.items()}
    for model, answers in (("right", right), ("again", right), ("half", half)):
        given = {
            (task_id, 1): Answer(
                task_id,
                1,
                "0" * 64,
                prompts[task_id].sha256,
                suite.benchmark.notation.plans.join(parts),
                "",
                "stop",
                (),
                AnswerUsage(),
            )
            for task_id, parts in answers.items()
        }
        obtained = ModelAnswers(model, model, prompts, given, {}, epochs=1)
        score_answers(obtained, tmp_path / "runs" / model, suite, ScoringOptions())
    return tmp_path / "runs"


def test_prompts_say_what_each_trainer_asks_for(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    wanted = ("--domain", "virtualhome", *SUITE, "--out", tmp_path / "train.jsonl")
    assert "437 rows written to" in eai("export", "prompts", *wanted).out
    rows = read(tmp_path / "train.jsonl")
    first, last = rows[0], rows[-1]
    assert (first["data_source"], last["data_source"]) == (
        "virtualhome/action_sequencing",
        "behavior/action_sequencing",
    )
    for row in (first, last):
        assert [message["role"] for message in row["prompt"]][-1] == "user"
        assert row["task"] == row["reward_model"]["ground_truth"] == row["reward_spec"]["ground_truth"]
        assert library.reward(row["task"], "") == 0


def test_each_file_of_a_folder_of_tasks_is_a_split(
    eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(ROOT / "examples" / "lamps")
    line = {"base": "lamps:lamps", "instruction": "Light up.", "facts": {}, "goals": ["lit(lamp)"]}
    objects = {"robot": "robot", "lamp": "lamp"}
    tasks = tmp_path / "tasks"
    tasks.mkdir()
    for name in ("train", "fresh-1"):
        whole = {"id": f"{name}-0", **line, "objects": objects, "agent": "robot"}
        (tasks / f"{name}.jsonl").write_text(json.dumps(whole) + "\n")
    asked = ("--domain", tasks, "--ability", "action_sequencing")
    folder = tmp_path / "data"
    assert "2 rows written" in eai("export", "prompts", *asked, "--out", folder, "--format", "hf").out
    assert "- split: fresh_1\n    path: fresh_1.jsonl\n" in (folder / "README.md").read_text()
    benchmark = (folder / "eval.yaml").read_text()
    assert 'name: "data"\n' in benchmark
    tasks = "tasks:\n  - id: lamps-fresh-1_action_sequencing\n    config: default\n    split: fresh_1\n"
    assert benchmark.endswith(tasks)  # without the split that is trained on
    ((train,), (fresh,)) = read(folder / "train.jsonl"), read(folder / "fresh_1.jsonl")
    assert (train["split"], fresh["split"]) == ("train", "fresh_1")
    assert library.reward(fresh["task"], '[{"action": "GO", "object": "lamp"}]') == 0
    eai("export", "prompts", *asked, "--out", tmp_path / "all.jsonl")
    assert read(tmp_path / "all.jsonl") == [fresh, train]


def test_only_answers_that_are_right_are_exported_once(eai: Command, records: Path, tmp_path: Path) -> None:
    assert "5 rows written" in eai("export", "sft", records, "--out", tmp_path / "sft.jsonl").out
    for row in read(tmp_path / "sft.jsonl"):
        (said,) = row["completion"]
        assert (said["role"], row["reward"]) == ("assistant", 1)
        assert library.reward(row["task"], said["content"]) == 1


@pytest.mark.parametrize("name", ["sft", "preference"])
def test_any_number_of_workers_exports_the_same_answers(
    eai: Command, records: Path, tmp_path: Path, name: str
) -> None:
    files = [tmp_path / f"{workers}.jsonl" for workers in (1, 2)]
    for workers, file in enumerate(files, 1):
        assert eai("export", name, records, "--out", file, "--workers", workers).status == 0
    assert files[0].read_bytes() == files[1].read_bytes() != b""


def test_preferences_are_for_the_better_answer(eai: Command, records: Path, tmp_path: Path) -> None:
    done = eai("export", "preference", records, "--out", tmp_path / "data", "--format", "hf")
    assert done.status == 0
    assert "path: train.jsonl" in (tmp_path / "data" / "README.md").read_text()
    assert not (tmp_path / "data" / "eval.yaml").exists()
    rows = read(tmp_path / "data" / "train.jsonl")
    assert rows
    for row in rows:
        better, worse = (
            library.reward(row["task"], row[side][0]["content"], "progress")
            for side in ("chosen", "rejected")
        )
        assert better is not None
        assert worse is not None
        assert better - worse == row["margin"] > 0
    half = ("--margin", 0.5, "--out", tmp_path / "clear.jsonl")
    assert eai("export", "preference", records, *half).status == 0
    clear = [row["margin"] for row in read(tmp_path / "clear.jsonl")]
    assert clear == [row["margin"] for row in rows if row["margin"] > 0.5]


def test_steps_of_plans_are_labelled_with_the_change_of_the_distance(
    eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(ROOT / "examples" / "lamps")
    suite = library.open("lamps:lamps", "action_sequencing")
    book = answer_book("lamps:lamps", suite.ability)
    answers = [{"identifier": i, "llm_output": book[i].text} for i in suite.task_ids]
    answers[-1]["llm_output"] = "no plan"
    (tmp_path / "m_outputs.json").write_text(json.dumps(answers))
    asked = ("--domain", "lamps:lamps", "--ability", "action_sequencing", "--out", tmp_path / "scores")
    assert eai("score", tmp_path / "m_outputs.json", *asked).status == 0
    labelled = ("export", "process", tmp_path / "scores", "--domain", "lamps:lamps", "--out")
    done = eai(*labelled, tmp_path / "process.jsonl")
    rows = read(tmp_path / "process.jsonl")
    steps = [step for row in rows for step in row["steps"]]
    exact = [step["change"] for step in steps if step["change"] is not None]
    assert f"the change is exact for {len(exact)} of {len(steps)} executed steps (--effort 1000)" in done.out
    assert "left out: 1 record without a plan of actions that can be read" in done.out
    assert (len(rows), len(exact), min(exact)) == (len(answers) - 1, len(steps), -1)
    for row in rows:
        assert row["reward"] == 1
        assert sum(step["change"] for step in row["steps"]) == -row["distance"]
    counts = json.loads(eai(*labelled, tmp_path / "again.jsonl", "--json").out)
    assert (tmp_path / "again.jsonl").read_bytes() == (tmp_path / "process.jsonl").read_bytes()
    assert (counts["exact"], counts["executed"], counts["rows"]) == (len(exact), len(steps), len(rows))


def test_what_is_left_out_is_said(eai: Command, records: Path, tmp_path: Path) -> None:
    """Answers to other prompts than are exported, and tasks without an answer."""
    out = ("--out", tmp_path / "sft.jsonl")
    done = eai("export", "sft", records, "--set", "eai", *out)
    assert "left out: 15 records answering another prompt than is exported" in done.out
    file = records / "again" / "records.jsonl"
    file.write_text("".join(json.dumps({**row, "unanswered": "late"}) + "\n" for row in read(file)))
    done = eai("export", "sft", file, *out)
    assert "0 rows written" in done.out
    assert "left out: 5 records without an answer, or with nothing to earn" in done.out


def test_episodes_of_acting_are_left_out_and_the_other_answers_are_not(
    eai: Command, records: Path, tmp_path: Path
) -> None:
    answers = tmp_path / "model_outputs.json"
    task_id = library.open("behavior", "acting").task_ids[0]
    answers.write_text(json.dumps([{"identifier": task_id, "llm_output": "[]"}]))
    acting = ("--domain", "behavior", "--ability", "acting", "--allow-missing", "--out", tmp_path / "acting")
    assert eai("score", answers, *acting).status == 0
    done = eai("export", "sft", records, tmp_path / "acting", "--out", tmp_path / "sft.jsonl")
    assert "5 rows written" in done.out
    assert "left out: 100 records of an ability whose verdicts do not say" in done.out


def test_nothing_is_left_behind_where_it_fails(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    done = eai(
        "export", "prompts", "--domain", "behavior", "--domain", "mars", "--out", tmp_path / "a" / "p.jsonl"
    )
    assert (done.status, "'mars' is not a benchmark" in done.err) == (2, True)
    assert not (tmp_path / "a").exists()


def test_records_of_a_benchmark_that_is_a_modules_object_are_exported(
    eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(ROOT / "examples" / "lamps")
    suite = library.open("lamps:lamps", "action_sequencing")
    task_id = suite.task_ids[0]
    right = answer_book("lamps:lamps", suite.ability)[task_id].text
    (tmp_path / "m_outputs.json").write_text(json.dumps([{"identifier": task_id, "llm_output": right}]))
    asked = ("--domain", "lamps:lamps", "--ability", "action_sequencing")
    assert eai("score", tmp_path / "m_outputs.json", *asked, "--out", tmp_path / "scores").status == 0
    for kind in ("sft", "preference"):
        out = ("--out", tmp_path / f"{kind}.jsonl")
        refused = eai("export", kind, tmp_path / "scores", *out)
        assert (
            refused.status,
            "lamps: no installed benchmark has this name; give the same --domain" in refused.err,
        ) == (
            2,
            True,
        )
        done = eai("export", kind, tmp_path / "scores", "--domain", "lamps:lamps", *out)
        assert done.status == 0, done.err
    (row,) = read(tmp_path / "sft.jsonl")
    assert library.reward(row["task"], row["completion"][0]["content"]) == 1
