from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from command_line import Command
from eai.abilities.protocol import Ability, Protocol
from eai.base.files import lock_run_folder
from eai.base.store import DataPackStore
from eai.benchmarks.virtualhome.records import open_records
from eai.pddl.fast_downward import FastDownward
from eai.tasks.source import Source
from made_answers import made_answers
from protocols import EACH_PROTOCOL, PROTOCOLS
from suites import answer_book
from sweeps import first_of

HERE = ("--domain", "virtualhome", "--ability", "action_sequencing")
WALK = {"identifier": "11_1", "llm_output": '{"WALK": ["floor_lamp"]}'}
LIMITED = """
import resource
resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
resource.setrlimit(resource.RLIMIT_CPU, (60, 60))
from eai.cli import main
main()
"""
"""The command line with 2 GB of memory and a minute of processor time."""


@pytest.fixture(autouse=True)
def folder(data_store: DataPackStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder to work in, with the data set at hand."""
    monkeypatch.setenv("EAI_DATA_DIR", str(data_store.folder))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(answers: object, name: str = "m_outputs.json") -> Path:
    """A response file in the working folder."""
    content = answers if isinstance(answers, bytes) else json.dumps(answers).encode()
    Path(name).write_bytes(content)
    return Path(name)


def responses(store: DataPackStore) -> list[Mapping[str, str]]:
    """Return an answer to each task."""
    answers = made_answers("virtualhome", Ability.ACTION_SEQUENCING, store)
    return [{"identifier": task_id, "llm_output": text} for task_id, text in answers]


def records(folder: str = "out") -> list[dict[str, Any]]:
    return [json.loads(line) for line in (Path(folder) / "records.jsonl").read_text().splitlines()]


def summary(folder: str = "out") -> dict[str, Any]:
    content: dict[str, Any] = json.loads((Path(folder) / "summary.json").read_text())
    return content


def test_results_never_leave_the_folder_they_are_for(eai: Command) -> None:
    result = eai("score", write([WALK]), write([WALK], ".._outputs.json"), *HERE, "--out", "out/scores")
    assert result.status == 2
    assert result.err == "eai: .._outputs.json: expected a file named after a model, <model>_outputs.json\n"
    assert not Path("out").exists()


@EACH_PROTOCOL
def test_answers_are_scored_into_records_a_summary_and_a_table(eai: Command, protocol: str) -> None:
    answers = [
        {"identifier": "11_1", "llm_output": '{"FLY": []}'},
        {"identifier": "scene_1_27_2", "llm_output": None},
    ]
    outcome = eai("score", write(answers), *HERE, "--protocol", protocol, "--out", "out")
    assert outcome.status == 0
    assert "written to out" in outcome.out
    assert re.search(r"execution success\D+0\.0", outcome.out)
    answered = [record for record in records() if record["unanswered"] is None]
    assert [(r["task_id"], r["model"], r["protocol"]) for r in answered] == [
        ("27_2", "m", protocol),
        ("11_1", "m", protocol),
    ]
    assert summary()["protocol"] == protocol
    assert summary()["execution_success"]["numerator"] == 0


@pytest.fixture
def protocol() -> str:
    """The protocol `strict`; tests of other protocols have fixtures of these names, too."""
    return "strict"


@pytest.fixture
def in_statistics() -> int:
    """Number of plans in VirtualHome that count."""
    return 337


def test_a_task_without_an_answer_counts_as_failed_and_is_told(
    eai: Command, data_store: DataPackStore, protocol: str, in_statistics: int
) -> None:
    gold = answer_book("virtualhome", Ability.ACTION_SEQUENCING, data_store)
    tasks = list(open_records(Source(data_store)))
    answers = [{"identifier": task_id, "llm_output": gold[task_id].text} for task_id in tasks[:50]]
    outcome = eai("score", write(answers), *HERE, "--protocol", protocol, "--out", "out")
    assert outcome.status == 0
    assert "50/342 answered" in outcome.out
    assert "m: 292 of 342 tasks without an answer, counted as failed where they are" in outcome.err
    assert [record["task_id"] for record in records()] == tasks
    assert {record["suite_size"] for record in records()} == {342}
    lacking = [record for record in records() if record["unanswered"] is not None]
    assert [record["task_id"] for record in lacking] == tasks[50:]
    assert {record["unanswered"] for record in lacking} == {"the response file has no row of the task"}
    assert {(record["error"], record["response"]) for record in lacking} == {(None, "")}
    whole = summary()
    assert whole["coverage"]["answered"] == 50
    assert whole["coverage"]["ranked"] is True
    assert whole["task_success"]["denominator"] == in_statistics
    assert 0 < whole["execution_success"]["numerator"] <= 50
    assert whole["parsing"]["numerator"] == 0

    allowed = eai("score", "m_outputs.json", *HERE, "--protocol", protocol, "--allow-missing", "--out", "out")
    assert allowed.status == 0
    assert allowed.err == "m: 292 of 342 tasks without an answer, left out; the run is not ranked.\n"
    part = summary()
    assert part["coverage"]["ranked"] is False
    assert part["execution_success"]["numerator"] == whole["execution_success"]["numerator"]
    assert part["task_success"]["denominator"] <= 50
    left_out = [record for record in records() if record["excluded_reason"] == "not answered"]
    assert len(left_out) == part["coverage"]["left_out"] == whole["coverage"]["counted_as_failures"]


def test_answers_to_all_tasks_are_no_cause_for_remarks(eai: Command, data_store: DataPackStore) -> None:
    outcome = eai("score", write(responses(data_store)), *HERE, "--out", "out")
    assert (outcome.status, outcome.err) == (0, "")
    assert "342/342 answered" in outcome.out
    assert summary()["coverage"] == {
        "tasks": 342,
        "answered": 342,
        "unanswered": 0,
        "counted_as_failures": 0,
        "left_out": 0,
        "not_asked": 0,
        "ranked": True,
    }


def test_records_are_in_the_order_of_the_data_set(eai: Command, data_store: DataPackStore) -> None:
    answers = responses(data_store)
    assert eai("score", write(answers[::-1]), *HERE, "--out", "out").status == 0
    assert [record["task_id"] for record in records()] == [answer["identifier"] for answer in answers]


@EACH_PROTOCOL
@pytest.mark.parametrize("explanations", ["--explanations", "--no-explanations"])
def test_any_number_of_workers_writes_the_same_bytes(
    eai: Command, data_store: DataPackStore, protocol: str, explanations: str
) -> None:
    file = write(responses(data_store))
    for workers in (1, 2):
        outcome = eai(
            *("score", file, *HERE, "--protocol", protocol, explanations),
            *("--workers", workers, "--out", f"out{workers}"),
        )
        assert outcome.status == 0
    for name in ("records.jsonl", "summary.json"):
        assert Path("out1", name).read_bytes() == Path("out2", name).read_bytes()
    assert all(("explanation" in record) == (explanations == "--explanations") for record in records("out1"))


def test_each_model_gets_a_folder_of_its_own(eai: Command) -> None:
    Path("answers").mkdir()
    files = [write([WALK], f"answers/{model}_outputs.json") for model in ("a", "b")]
    assert eai("score", "answers", *HERE, "--out", "out").status == 0
    assert [records(f"out/{model}")[0]["model"] for model in ("a", "b")] == ["a", "b"]
    assert not Path("out", "records.jsonl").exists()
    assert eai("score", files[0], *HERE, "--out", "one").status == 0
    assert records("one")[0]["model"] == "a"


def test_two_files_of_one_model_are_refused(eai: Command) -> None:
    Path("other").mkdir()
    outcome = eai("score", write([WALK]), write([WALK], "other/m_outputs.json"), *HERE, "--out", "out")
    assert outcome.status == 2
    assert outcome.err == "eai: m: two files are of this model; score them one at a time\n"


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"", "m_outputs.json, line 1, column 1: expected JSON (Expecting value)"),
        (b"\0\0", "m_outputs.json, line 1, column 1: expected JSON (Expecting value)"),
        (b"WALK sofa", "m_outputs.json, line 1, column 1: expected JSON (Expecting value)"),
        (b"[" * 100_000, "m_outputs.json: expected JSON in UTF-8 "),
        ([], "m_outputs.json: expected at least one answer, found an empty list"),
        ({"11_1": "x"}, 'm_outputs.json: expected a list of {"identifier", "llm_output"}, not an object'),
        ([{"identifier": "11_1"}], 'm_outputs.json, row 1: the key "llm_output" is missing'),
        ([WALK, WALK], "m_outputs.json, row 2: identifier '11_1' occurs twice"),
        (
            [WALK, {"identifier": "0_0", "llm_output": ""}],
            "m_outputs.json, row 2: identifier '0_0' is not one of the tasks",
        ),
    ],
    ids=lambda content: str(content)[:30],
)
def test_a_bad_response_file_ends_with_one_line(eai: Command, content: object, complaint: str) -> None:
    outcome = eai("score", write(content), *HERE, "--out", "out")
    assert (outcome.status, outcome.out) == (2, "")
    assert outcome.err.startswith(f"eai: {complaint}")
    assert outcome.err.count("\n") == 1
    assert not Path("out").exists()


def test_a_folder_without_response_files_ends_with_one_line(eai: Command) -> None:
    outcome = eai("score", ".", *HERE)
    assert (outcome.status, outcome.err) == (
        2,
        "eai: .: expected a folder with <model>_outputs.json files, found none\n",
    )
    assert eai("score", "nowhere", *HERE).err == "eai: nowhere: no such file or folder\n"


@pytest.mark.parametrize("out", ["taken", "taken/below"])
def test_results_that_cannot_be_written_end_with_one_line(eai: Command, out: str) -> None:
    Path("taken").write_text("a file, not a folder")
    outcome = eai("score", write([WALK]), *HERE, "--out", out)
    assert outcome.status == 2
    assert re.fullmatch(rf"eai: {out}: cannot be written \([\w ]+\)\n", outcome.err)


def test_wrong_options_end_with_usage(eai: Command) -> None:
    outcome = eai("score", write([WALK]), *HERE, "--workers", "0")
    assert outcome.status == 2
    assert "Usage" in outcome.err


@pytest.fixture
def tree() -> Path:
    """Answers of two models to two suites, as a run has them and as the challenge has them."""
    for place in (
        "answers/virtualhome/action_sequencing/a_outputs.json",
        "answers/virtualhome/action_sequencing/b_outputs.json",
        "answers/virtualhome/goal_interpretation/a_outputs.json",
        "answers/c/behavior_goal_interpretation_outputs.json",
    ):
        Path(place).parent.mkdir(parents=True, exist_ok=True)
        task = "assembling_gift_baskets_0_Beechwood_0_int_0_2021-10-26_12-46-37"
        write([{**WALK, "identifier": task}] if "behavior" in place else [WALK], place)
    return Path("answers")


SUITES = {
    ("virtualhome", "goal_interpretation", "a"),
    ("virtualhome", "action_sequencing", "a"),
    ("virtualhome", "action_sequencing", "b"),
    ("behavior", "goal_interpretation", "c"),
}


def test_a_folder_is_scored_suite_by_suite(eai: Command, tree: Path) -> None:
    outcome = eai("score", tree, "--out", "out")
    assert outcome.status == 0
    assert {
        (r["domain"], r["ability"], r["model"]) for s in SUITES for r in records("/".join(("out", *s)))
    } == SUITES
    plans = eai("score", tree, "--ability", "action_sequencing", "--out", "plans")
    assert plans.status == 0
    assert {path.name for path in Path("plans").rglob("*") if path.is_dir()} == {
        *("virtualhome", "action_sequencing", "a", "b")
    }


def test_a_zip_is_scored_like_its_folder(eai: Command, tree: Path) -> None:
    with zipfile.ZipFile("mine.zip", "w") as archive:
        archive.write(
            tree / "c" / "behavior_goal_interpretation_outputs.json",
            "behavior_goal_interpretation_outputs.json",
        )
    printed = eai("score", "mine.zip", "--json")
    assert (printed.status, printed.err) == (0, "")
    (found,) = json.loads(printed.out)
    assert (found["domain"], found["ability"], found["model"]) == ("behavior", "goal_interpretation", "mine")
    assert found["coverage"]["answered"] == 1
    with zipfile.ZipFile("mine.zip", "a") as archive:  # what systems and people add is no answer
        for odd in ("__MACOSX/._behavior_goal_interpretation_outputs.json", "notes/\x01.txt", "/x", "../y"):
            archive.writestr(odd, b"\0" * 100)
    assert json.loads(eai("score", "mine.zip", "--json").out) == json.loads(printed.out)
    Path("bad.zip").write_text("no zip")
    assert eai("score", "bad.zip").err.startswith("eai: bad.zip: expected a readable zip")


def test_a_zip_that_holds_far_more_than_it_weighs_is_refused(eai: Command) -> None:
    with zipfile.ZipFile("bomb.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for number in range(4):
            archive.writestr(f"{number}_outputs.json", b" " * 10_000_000)
    printed = eai("score", "bomb.zip", *HERE)
    assert printed.status == 2
    assert re.fullmatch(
        r"eai: bomb\.zip: expected at most 3\d,\d{3},\d{3} bytes of answers in it; split the zip\n",
        printed.err,
    )
    with zipfile.ZipFile("twice.zip", "w") as archive:
        archive.writestr("m_outputs.json", json.dumps([WALK]))
        with pytest.warns(UserWarning, match="Duplicate name"):
            archive.writestr("m_outputs.json", json.dumps([WALK]))
    expected = "eai: twice.zip: m_outputs.json: the zip has two members of this name; keep one\n"
    assert eai("score", "twice.zip", *HERE).err == expected


def test_a_zip_that_windows_wrote_is_scored(eai: Command) -> None:
    with zipfile.ZipFile("submission.zip", "w") as archive:
        archive.writestr("sub\\virtualhome_action_sequencing_outputs.json", json.dumps([WALK]))
        archive.writestr("sub\\notes\\", b"")
    printed = eai("score", "submission.zip", "--json")
    assert (printed.status, printed.err) == (0, "")
    (found,) = json.loads(printed.out)
    names = (found["domain"], found["ability"], found["model"])
    assert names == ("virtualhome", "action_sequencing", "sub")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("m_outputs.json", "[", "submission.zip: a/m_outputs.json, line 1, column 2: expected JSON"),
        ("m_outputs.json", "[]", "submission.zip: a/m_outputs.json: expected at least one answer"),
        (
            "m_outputs.jsonl",
            '{"identifier": "x"}',
            'submission.zip: a/m_outputs.jsonl, row 1: the key "llm_output"',
        ),
        ("x.txt", "", "submission.zip: expected a folder with <model>_outputs.json files, found none"),
    ],
)
def test_a_member_of_a_zip_is_named_with_its_zip(eai: Command, name: str, content: str, message: str) -> None:
    with zipfile.ZipFile("submission.zip", "w") as archive:
        archive.writestr(f"a/{name}", content)
    printed = eai("score", "submission.zip", *HERE)
    assert printed.status == 2
    assert printed.err.startswith(f"eai: {message}")
    assert "eai-answers" not in printed.err


def test_a_zip_may_have_several_answers_to_a_task(eai: Command) -> None:
    rows = [{**WALK, "sample": number} for number in range(3)]
    with zipfile.ZipFile("samples.zip", "w") as archive:
        archive.writestr("m_outputs.jsonl", "".join(f"{json.dumps(row)}\n" for row in rows))
    outcome = eai("score", "samples.zip", *HERE, "--allow-missing", "--out", "out")
    assert outcome.status == 0
    assert [row["sample"] for row in records() if row["status"] == "scored"] == [0, 1, 2]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.parametrize(
    "name", ["m_outputs.json", "m_outputs.jsonl", "m_outputs.parquet", "l.eval", "m.zip"]
)
def test_a_named_pipe_is_refused_at_once(eai: Command, name: str) -> None:
    os.mkfifo(name)
    printed = eai("score", name, *HERE)
    assert printed.status == 2
    assert printed.err.startswith(f"eai: {name}: is a named pipe")


def test_what_another_run_left_is_not_replaced_without_a_word(eai: Command) -> None:
    first = eai("score", write([WALK], "a_outputs.json"), *HERE, "--out", "out")
    again = eai("score", "a_outputs.json", *HERE, "--out", "out")
    other = eai("score", write([WALK], "b_outputs.json"), *HERE, "--out", "out")
    told = "out/records.jsonl: the records of a, virtualhome action_sequencing are replaced\n"
    assert (first.status, told in first.err + again.err, told in other.err) == (0, False, True)


def test_two_do_not_score_into_one_folder_at_a_time(eai: Command) -> None:
    with lock_run_folder(Path("out")):
        printed = eai("score", write([WALK]), *HERE, "--out", "out")
    assert (printed.status, printed.out) == (2, "")
    assert printed.err.startswith("eai: out: another process is writing to this folder")
    assert not (Path("out") / "records.jsonl").exists()


def test_a_file_that_names_no_suite_has_to_be_told_its_own(eai: Command) -> None:
    outcome = eai("score", write([WALK]), "--ability", "action_sequencing")
    assert outcome.status == 2
    assert outcome.err.startswith("eai: m_outputs.json: give --domain and --ability; its path does not name")


def test_answers_of_a_final_phase_are_scored_where_their_tasks_are_published(eai: Command) -> None:
    rows = [
        {"identifier": each, "llm_output": "[]"} for each in ("scene_2_22_1", "scene_1_27_2", "scene_7_1_1")
    ]
    Path("m_outputs.json").write_text(json.dumps(rows))
    done = eai("score", "m_outputs.json", "--domain", "virtualhome", "--ability", "action_sequencing")
    assert done.status == 0
    assert "m: 2 answers left out, to tasks that are not in the data set" in done.err


def test_answers_may_stand_on_lines(eai: Command) -> None:
    Path("m_outputs.jsonl").write_text(json.dumps(WALK) + "\n\n" + json.dumps({**WALK, "identifier": "27_2"}))
    assert eai("score", "m_outputs.jsonl", *HERE, "--out", "out").status == 0
    assert summary()["coverage"]["answered"] == 2
    Path("m_outputs.jsonl").write_text(json.dumps(WALK) + "\n{]\n")
    assert eai("score", "m_outputs.jsonl", *HERE).err.startswith(
        "eai: m_outputs.jsonl, line 2, column 2: expected"
    )


def test_answers_in_parquet_give_the_same_bytes(eai: Command) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    rows = [WALK, {**WALK, "identifier": "27_2", "llm_output": None}]
    Path("m_outputs.json").write_text(json.dumps(rows))
    parquet.write_table(pyarrow.Table.from_pylist(rows), "m_outputs.parquet")
    for form in ("json", "parquet"):
        assert eai("score", f"m_outputs.{form}", *HERE, "--out", form).status == 0
    for name in ("records.jsonl", "summary.json"):
        assert Path("json", name).read_bytes() == Path("parquet", name).read_bytes()


@pytest.mark.parametrize(
    ("option", "name", "complaint"),
    [
        ("--ability", "action_sequence", "no ability: .*; did you mean action_sequencing?"),
        ("--ability", "cooking", "no ability: expected one of .*, scene_graph, acting; did you mean acting?"),
        (
            "--protocol",
            "strickt",
            f"no protocol: expected one of {', '.join(Protocol.list_names())}; did you mean strict?",
        ),
        ("--planner", "fast", "no planner: expected one of auto, full, built_in, fast_downward, none"),
    ],
)
def test_an_unknown_name_ends_with_one_line_that_names_the_near_one(
    eai: Command, option: str, name: str, complaint: str
) -> None:
    outcome = eai("score", write([WALK]), *HERE, option, name)
    assert outcome.status == 2
    expected = re.escape(complaint).replace(re.escape(".*"), ".*")
    assert re.fullmatch(f"eai: '{name}' is {expected}\n", outcome.err)


def test_operators_are_judged_without_fast_downward_where_it_is_not_installed(
    eai: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FastDownward, "is_installed", lambda: False)
    file = write([{"identifier": "27_2", "llm_output": "(:action walk_towards)"}])
    operators = (*HERE[:3], "transition_modeling")
    outcome = eai("score", file, *operators, "--out", "out")
    assert outcome.status == 0
    assert outcome.err.count("Fast Downward is not installed") == 1
    assert summary()["planner"] == "built-in search"
    assert {record["planner_name"] for record in records()} == {"built-in search"}
    assert "Fast Downward" not in eai("score", file, *operators, "--planner", "built_in").err


def test_an_unknown_benchmark_ends_with_one_line_that_names_the_near_one(eai: Command) -> None:
    outcome = eai("score", write([WALK]), *HERE, "--domain", "virtualhom")
    assert outcome.status == 2
    assert outcome.err.startswith("eai: 'virtualhom' is not a benchmark: expected virtualhome, behavior")
    assert outcome.err.endswith("did you mean virtualhome?\n")


def test_help_shows_an_example(eai: Command) -> None:
    outcome = eai("score", "--help")
    assert outcome.status == 0
    assert "Example: eai score" in outcome.out


@EACH_PROTOCOL
@pytest.mark.parametrize("workers", [1, 2])
def test_extreme_answers_are_counted_and_none_is_lost(
    eai: Command, data_store: DataPackStore, protocol: str, workers: int
) -> None:
    texts = ["\0" * 1000, "\udfff\ud800", "[" * 100_000 + "]" * 100_000, "[" * 900 + "]" * 900, ""]
    others = (task for task in open_records(Source(data_store)) if task != "11_1")
    unreadable = dict(zip(others, texts, strict=False))
    long_plan = "{" + ", ".join(['"WALK": ["floor_lamp"], "TOUCH": ["floor_lamp"]'] * 5_000) + "}"
    chosen = {**unreadable, "11_1": long_plan}
    answers = [{"identifier": task, "llm_output": text} for task, text in chosen.items()]
    outcome = eai(
        *("score", write(answers), *HERE, "--protocol", protocol, "--workers", workers),
        *("--no-explanations", "--out", "out"),
    )
    assert outcome.status == 0
    scored = {record["task_id"]: record for record in records() if record["unanswered"] is None}
    assert {task: record["response"] for task, record in scored.items()} == chosen
    assert scored["11_1"]["executable"] is True
    for task in unreadable:
        assert scored[task]["status"] == "excluded" or scored[task]["error"]["kind"] == "parsing"


@pytest.mark.parametrize("protocol", first_of(PROTOCOLS))
@pytest.mark.skipif(sys.platform != "linux", reason="limits of a process are not kept elsewhere")
def test_an_answer_of_100_megabytes_is_counted(protocol: str) -> None:
    text = '"A": [' * 16_700_000
    file = write([{"identifier": "11_1", "llm_output": text}, {"identifier": "27_2", "llm_output": "{}"}])
    assert file.stat().st_size > 100_000_000
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, "score", file, *HERE, "--protocol", protocol, "--out", "out"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    by_task = {record["task_id"]: record for record in records()}
    assert by_task["11_1"]["error"] == {
        "kind": "parsing",
        "step": None,
        "detail": "the answer is longer than 1,000,000 characters",
        "check": None,
        "objects": [],
    }
    assert by_task["11_1"]["response"] == text


def test_the_command_as_installed_ends_with_status_2() -> None:
    command = [sys.executable, "-c", "from eai.cli import main; main()", "score", "nowhere", *HERE]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", "eai: nowhere: no such file or folder\n")


def test_errata_are_told_and_can_be_switched_off(eai: Command) -> None:
    drink = {"identifier": "688_1", "llm_output": '{"WALK": ["cupboard"]}'}
    outcome = eai("score", write([drink, WALK]), *HERE, "--out", "out")
    assert re.search(
        r"^Of 342 tasks, 1 left out, because the published data is wrong there \(docs/errata.md\); --errata",
        outcome.out,
        re.MULTILINE,
    )
    assert summary()["errata"]["left_out"] == ["688_1"]
    by_task = {record["task_id"]: record for record in records()}
    assert by_task["688_1"]["excluded_reason"].startswith("no plan reaches the goal")
    assert by_task["688_1"]["errata"]["entries"] == ["glass-in-both-hands"]
    assert by_task["11_1"]["errata"] == {**by_task["688_1"]["errata"], "entries": []}
    off = eai("score", "m_outputs.json", *HERE, "--errata", "none", "--out", "off")
    assert "Errata" not in off.out
    assert summary("off")["errata"] is None
    assert summary("off")["task_success"]["denominator"] == 338
    assert not any("errata" in record for record in records("off"))
    for protocol in PROTOCOLS[1:]:
        other = eai("score", "m_outputs.json", *HERE, "--protocol", protocol, "--out", protocol)
        assert "Errata" not in other.out
    wrong = eai("score", "m_outputs.json", *HERE, "--errata", "nome")
    assert (wrong.status, "did you mean" in wrong.err) == (2, True)
