"""``eai run`` with built-in models, and with a server that fails; each test is one process."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from inspect_ai.log import read_eval_log

from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.base.store import DataPackStore
from eai.cli.run import _merge_similar_failures
from processes import Outcome, eai
from run.server import Reply, serve
from suites import answer_book, official_prompts
from sweeps import sweep, swept

DOMAINS = ("virtualhome", "behavior")
SUITE = ("virtualhome", Ability.ACTION_SEQUENCING)
NAMED = ("--domain", "virtualhome", "--ability", "action_sequencing")


def test_results_of_a_run(data_store: DataPackStore, tmp_path: Path) -> None:
    run = eai(
        "run",
        "--model",
        "eai/noisy",
        "-M",
        "rate=0.3",
        *NAMED,
        "--limit",
        4,
        "--epochs",
        3,
        "--out",
        tmp_path,
    )
    assert run.status == 0, run.err
    assert "task success" in run.out
    assert "4 answers" in run.out
    assert "action_sequencing eai/noisy: 12/12" in run.err
    folder = tmp_path / "virtualhome" / "action_sequencing" / "eai_noisy"
    assert str(folder) in run.out
    records = [json.loads(line) for line in (folder / "records.jsonl").read_text().splitlines()]
    prompts = official_prompts(*SUITE, data_store)
    assert [record["task_id"] for record in records] == list(prompts)[:4]
    for record in records:
        assert record["prompt_sha256"] == prompts[record["task_id"]].sha256
        assert record["usage"]["output_tokens"] > 0
        assert (record["stop_reason"], record["truncated"]) == ("stop", False)
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["run"]["answered"] == 4
    assert summary["coverage"]["not_asked"] == 338
    assert "eai/noisy: only 4 of 342 tasks were asked; the run is not ranked." in run.err
    assert summary["run"]["usage"]["input_tokens"] > 12 * 1000
    epochs = [json.loads((folder / f"epoch_{n}" / "summary.json").read_text()) for n in (1, 2, 3)]
    assert {epoch["task_success"]["denominator"] for epoch in epochs} == {4}
    texts = [(folder / f"epoch_{n}" / f"eai_noisy.epoch_{n}_outputs.json").read_text() for n in (1, 2, 3)]
    assert len(set(texts)) == 3


@pytest.mark.parametrize("allow_missing", [False, *swept(True)])
def test_what_is_not_answered_is_told_and_counts_unless_it_is_left_out(
    data_store: DataPackStore, tmp_path: Path, allow_missing: bool
) -> None:
    prompts = dict(list(official_prompts(*SUITE, data_store).items())[:4])
    gold = answer_book(*SUITE, data_store)
    broken, cut_off = list(prompts)[1:3]
    script = {prompt.user: [Reply(gold[task_id].text)] for task_id, prompt in prompts.items()}
    script[prompts[broken].user] = [Reply(status=500)]
    script[prompts[cut_off].user] = [Reply('{"WALK": ["so', finish="length")]
    with serve(script) as served:
        run = eai(
            *("run", "--model", "openai-api/local/scripted", "-M", "api_key=none", "-M", "max_retries=0"),
            *(
                "--model-base-url",
                served.url,
                "--with",
                "requests.max_retries=0",
                "--json",
                "--out",
                tmp_path,
            ),
            *(*NAMED, "--tasks", ",".join(prompts)),
            *(["--with", "scoring.allow_missing=true"] if allow_missing else []),
        )
    assert run.status == 1
    (result,) = json.loads(run.out)
    assert result["model"] == "openai-api/local/scripted"
    assert (result["answered"], result["truncated"]) == (3, 1)
    assert list(result["not_answered"].values()) == [[broken]]
    assert f"1 task not answered ({broken})" in run.err
    assert result["metrics"]["task_success"]["numerator"] == 2
    assert result["metrics"]["task_success"]["denominator"] == (3 if allow_missing else 4)
    assert result["coverage"] == {
        "tasks": 342,
        "answered": 3,
        "unanswered": 1,
        "counted_as_failures": 0 if allow_missing else 1,
        "left_out": 1 if allow_missing else 0,
        "cut_off": 1,
        "not_asked": 338,
        "ranked": False,
    }
    lines = (Path(result["folder"]) / "records.jsonl").read_text().splitlines()
    records = {record["task_id"]: record for record in map(json.loads, lines)}
    assert list(records) == list(prompts)
    assert records[broken]["unanswered"].startswith("InternalServerError")
    assert records[broken]["excluded_reason"] == ("not answered" if allow_missing else None)
    assert records[broken]["error"] is None
    (path,) = (tmp_path / "logs").glob("*.eval")
    log = read_eval_log(path)
    assert log.results is not None
    columns = log.results.scores[-1]
    assert columns.metrics["task_success"].value == 2 / (3 if allow_missing else 4)
    assert (columns.scored_samples, columns.unscored_samples) == ((3, 1) if allow_missing else (4, 0))
    scores = {sample.id: (sample.scores or {})["action_sequencing"] for sample in log.samples or ()}
    told = "Excluded: not answered" if allow_missing else "Not answered: InternalServerError"
    assert told in (scores[broken].explanation or "")
    assert records[cut_off]["truncated"]
    assert records[cut_off]["error"]["kind"] == "parsing"


def test_nothing_is_asked_if_a_task_does_not_fit_into_the_context_unless_such_tasks_are_left_out(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    prompts = dict(list(official_prompts("behavior", Ability.GOAL_INTERPRETATION, data_store).items())[:4])
    script = {prompt.user: [Reply("{}")] for prompt in prompts.values()}
    model = {"id": "scripted", "object": "model", "max_model_len": 2048}
    command = (
        *("run", "--model", "openai-api/local/scripted", "-M", "api_key=none", "--out", tmp_path),
        *("--domain", "behavior", "--ability", "goal_interpretation", "--tasks", ",".join(prompts)),
    )
    with serve(script, {"/v1/models": {"data": [model]}}) as served:
        stopped = eai(*command, "--model-base-url", served.url)
        assert (stopped.status, served.log.requests) == (2, [])
        assert "1 of 4 tasks of behavior goal_interpretation need more than 2,048 tokens (2," in stopped.err
        assert "--set short" in stopped.err
        assert "requests.too_long=skip" in stopped.err
        skipped = eai(*command, "--model-base-url", served.url, "--with", "requests.too_long=skip", "--json")
    assert skipped.status == 0, skipped.err
    assert "1 of 4 tasks of behavior goal_interpretation need more than 2,048 tokens" in skipped.err
    (result,) = json.loads(skipped.out)
    assert (result["answered"], result["coverage"]["not_asked"]) == (3, 97)
    assert len(served.log.requests) == 3
    assert {request["max_tokens"] >= 1024 for request in served.log.requests} == {True}


def test_reasons_that_differ_only_in_numbers_are_reported_once() -> None:
    failures = {
        "request (4,031 tokens) is refused": ["a", "b"],
        "out of order": ["c"],
        "request (5,120 tokens) is refused": ["d", "a"],
    }
    assert list(_merge_similar_failures(failures)) == [
        ("request (4,031 tokens) is refused", ["a", "b", "d"]),
        ("out of order", ["c"]),
    ]


@sweep
def test_replayed_answers_are_scored_as_the_file_they_are_from(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    gold = answer_book(*SUITE, data_store)
    tasks = list(official_prompts(*SUITE, data_store))[:3]
    rows = [{"identifier": task_id, "llm_output": gold[task_id].text} for task_id in tasks]
    file = tmp_path / "m_outputs.json"
    file.write_text(json.dumps(rows))
    replay = ("run", "--model", "eai/replay", "-M", f"path={file}", "--out", tmp_path / "run")
    several = eai(*replay, "--domain", "virtualhome")
    assert several.status == 2
    assert "one file cannot answer 4 suites" in several.err
    run = eai(*replay, *NAMED)
    assert run.status == 1
    assert "3/342 answered" in run.out
    assert "339 tasks not answered" in run.err
    assert "the response file has no row of the task" in run.err
    assert eai("score", file, *NAMED, "--out", tmp_path / "score").status == 0
    summaries = [
        json.loads((folder / "summary.json").read_text())
        for folder in (
            tmp_path / "run" / "virtualhome" / "action_sequencing" / "eai_replay",
            tmp_path / "score",
        )
    ]
    for summary in summaries:
        summary.pop("run", None)
        summary.pop("model")
    assert summaries[0] == summaries[1]


@sweep
def test_batch_reaches_inspect_and_built_in_models_answer_all_the_same(tmp_path: Path) -> None:
    arguments = ("run", "--model", "eai/oracle", *NAMED, "--limit", 2, "--quiet")
    batches = {}
    for name, options in (("batch", ("--with", "requests.batch=true")), ("plain", ())):
        assert eai(*arguments, *options, "--out", tmp_path / name) == Outcome(0, "", "")
        (log,) = (tmp_path / name / "logs").glob("*.eval")
        batches[name] = read_eval_log(str(log), header_only=True).plan.config.batch
    assert batches == {"batch": True, "plain": None}
    results = Path("virtualhome", "action_sequencing", "eai_oracle", "records.jsonl")
    assert (tmp_path / "batch" / results).read_bytes() == (tmp_path / "plain" / results).read_bytes()


def test_quiet_runs_print_nothing_and_colour_can_be_turned_off(tmp_path: Path) -> None:
    arguments = ("run", "--model", "eai/oracle", *NAMED, "--limit", 2, "--out", tmp_path)
    assert eai(*arguments, "--quiet") == Outcome(0, "", "")
    coloured = eai(*arguments, FORCE_COLOR="1", TERM="xterm-256color")
    plain = eai(*arguments, FORCE_COLOR="1", NO_COLOR="1", TERM="xterm-256color")
    colour = re.compile(r"\x1b\[(\d+;)*(3[0-8]|9[0-7])[;m]")
    assert colour.search(coloured.err)
    assert not colour.search(plain.err + plain.out)


def test_all_suites_are_run_without_being_named(data_store: DataPackStore, tmp_path: Path) -> None:
    run = eai("run", "--model", "eai/oracle", "--planner", "built_in", "--limit", 1, "--out", tmp_path)
    assert run.status == 0, run.err
    assert run.out.count(": eai/oracle, 1/") == 8
    summaries = {path.parts[-4:-2] for path in tmp_path.glob("*/*/*/summary.json")}
    assert summaries == {
        (domain, ability.value) for domain in ("virtualhome", "behavior") for ability in PAPER_ABILITIES
    }
    assert run.out.count("1 answer, ") == 8


def test_a_built_in_model_skips_what_it_has_no_answer_to(data_store: DataPackStore, tmp_path: Path) -> None:
    asked = ("--domain", "virtualhome", "--limit", 1, "--quiet", "--out", tmp_path)
    run = eai("run", "--model", "eai/planner", "--planner", "none", *asked)
    assert (run.status, run.err) == (
        0,
        "eai/planner has no answer to goal_interpretation, transition_modeling: skipped\n",
    )
    summaries = {path.parts[-3] for path in tmp_path.glob("*/*/*/summary.json")}
    assert summaries == {"action_sequencing", "subgoal_decomposition"}


NO_PLAN = {
    "domain.pddl": """(define (domain two) (:requirements :strips) (:predicates (p ?x) (r ?x))
    (:action mk :parameters (?x) :precondition () :effect (p ?x)))""",
    "p1.pddl": "(define (problem lost) (:domain two) (:objects a b) (:init) (:goal (r a)))",
    "p2.pddl": "(define (problem open) (:domain two) (:objects a b) (:init) (:goal (p a)))",
}


@pytest.mark.parametrize(
    ("model", "ability"),
    [
        ("eai/planner", "action_sequencing"),
        *swept(
            ("eai/planner", "subgoal_decomposition"),
            ("eai/planner", "acting"),
            ("eai/oracle", "action_sequencing"),
            ("eai/noisy", "action_sequencing"),
        ),
    ],
)
def test_a_planner_without_a_plan_does_not_answer(tmp_path: Path, model: str, ability: str) -> None:
    for name, text in NO_PLAN.items():
        (tmp_path / name).write_text(text)
    domain = f"pddl:{tmp_path / 'domain.pddl'},{tmp_path}"
    run = eai("run", "--model", model, "--domain", domain, "--ability", ability, "--out", tmp_path / "runs")
    assert run.status == 1
    assert "1 task not answered (lost): InputError: no plan exists" in run.err
    (file,) = (tmp_path / "runs").glob(f"two/{ability}/*/records.jsonl")
    records = {each["task_id"]: each for each in map(json.loads, file.read_text().splitlines())}
    assert records["lost"]["unanswered"] == "InputError: no plan exists"
    assert (records["lost"]["response"], records["lost"]["error"]) == ("", None)
    assert records["open"]["unanswered"] is None


def test_named_tasks_are_run_in_the_suites_that_have_them(data_store: DataPackStore, tmp_path: Path) -> None:
    named = ("--tasks", "27_2", "--planner", "none", "--json", "--out", tmp_path)
    run = eai("run", "--model", "eai/oracle", *named)
    assert run.status == 0, run.err
    assert [(each["domain"], each["ability"]) for each in json.loads(run.out)] == [
        ("virtualhome", ability.value) for ability in PAPER_ABILITIES
    ]
    unknown = eai("run", "--model", "eai/oracle", "--tasks", "27_2,0_0", "--out", tmp_path)
    assert unknown.err == "eai: --tasks: '0_0' is not a task of any suite\n"


def test_an_out_that_is_no_folder_is_said_before_anything_is_asked(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    run = eai("run", "--model", "eai/oracle", *NAMED, "--quiet", "--out", tmp_path / "file")
    assert (run.status, run.out) == (2, "")
    assert run.err == f"eai: {tmp_path / 'file' / 'run.toml'}: cannot be written (File exists)\n"


def test_what_cannot_be_run_is_said_in_one_line(tmp_path: Path) -> None:
    for arguments, message in (
        (
            ("--model", "openia/bar"),
            "eai: cannot open the model openia/bar: Inspect has no provider openia; did you mean openai? "
            "For a server with OpenAI's protocol, write openai-api/openia/bar.\n",
        ),
        (
            ("--model", "zzz/bar"),
            "eai: cannot open the model zzz/bar: Inspect has no provider zzz. For a server with "
            "OpenAI's protocol, write ",
        ),
        (
            ("--model", "openai-api/unheard-of/m"),
            "eai: cannot open the model openai-api/unheard-of/m: ERROR: Unable to initialise unheard-of "
            "client No UNHEARD_OF_API_KEY defined in the environment, nor given as -M api_key=KEY",
        ),
        (
            ("--model", "openai-api/local/m", "--model-base-url", "localhost:8000/v1"),
            "eai: model.base_url: expected http:// or https:// before the address, found 'localhost:8000/v1'",
        ),
        (("--model", "eai/orcle"), "eai: eai/orcle: expected one of eai/oracle, "),
        (("--model", "gpt-4o"), "eai: --model gpt-4o: expected PROVIDER/NAME, such as openai/gpt-4o"),
        (("--model", "eai/noisy", "-M", "rate=much"), "eai: eai/noisy.rate: expected a valid number"),
        (("--model", ".."), "eai: --model ..: expected PROVIDER/NAME, such as openai/gpt-4o"),
        (
            ("--model", "openai/a b", "--model", "openai/a_b"),
            "eai: --model openai/a_b: its results would overwrite those of openai/a b",
        ),
        (("--model", "eai/oracle", "--tasks", "0_0"), "eai: --tasks: '0_0' is not a task of"),
        (("--model", "eai/oracle", "-M", "rate"), "eai: -M rate: expected NAME=VALUE"),
    ):
        run = eai("run", *arguments, *NAMED, "--quiet", "--out", tmp_path)
        assert run.status == 2
        assert run.err.startswith(message)
        assert len(run.err.splitlines()) == 1


def records_in(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (folder / "records.jsonl").read_text().splitlines()]


@sweep
def test_a_pipeline_is_two_jobs_in_a_row(data_store: DataPackStore, tmp_path: Path) -> None:
    """A model that always answers right gets equal verdicts with interpreted goals and with true goals."""
    oracle = ("run", "--model", "eai/oracle", "--domain", "behavior", "--limit", 3, "--out", tmp_path)
    abilities = ("--ability", "action_sequencing", "--ability", "subgoal_decomposition")
    assert eai(*oracle, *abilities).status == 0
    run = eai(*oracle, "--with", "pipeline.goals=own", "--json")
    assert run.status == 0, run.err
    done = [(each["ability"], each["answered"]) for each in json.loads(run.out)]
    assert done == [
        ("goal_interpretation", 3),
        ("subgoal_decomposition", 3),
        ("action_sequencing", 3),
    ]
    first = records_in(tmp_path / "behavior" / "goal_interpretation" / "eai_oracle")
    for ability in ("action_sequencing", "subgoal_decomposition"):
        folder = tmp_path / "behavior" / ability / "eai_oracle"
        modular, piped = records_in(folder), records_in(folder / "goals-eai_oracle")
        parts = [record.pop("study")["pipeline"] for record in piped]
        assert [each["summary"]["goals_sha256"] for each in parts] == [
            each["response_sha256"] for each in first
        ]
        assert {each["options"]["goals_from"] for each in parts} == {"eai_oracle"}
        assert [each["prompt_sha256"] for each in piped] != [each["prompt_sha256"] for each in modular]
        for records in (modular, piped):
            for record in records:
                del record["prompt_sha256"], record["usage"]
        assert piped == modular
    before = (tmp_path / "behavior" / "goal_interpretation" / "eai_oracle" / "answers.jsonl").read_bytes()
    assert eai(*oracle, "--with", "pipeline.goals=own", "--json").out == run.out
    after = (tmp_path / "behavior" / "goal_interpretation" / "eai_oracle" / "answers.jsonl").read_bytes()
    assert after == before


def test_a_planner_plans_for_the_goals_that_it_is_told(data_store: DataPackStore, tmp_path: Path) -> None:
    """One task has right goals, one has unreadable goals. A task without goals is not asked, and fails."""
    gold = answer_book("virtualhome", Ability.GOAL_INTERPRETATION, data_store)
    right, unreadable, missing = list(official_prompts(*SUITE, data_store))[:3]
    rows = [
        {"identifier": right, "llm_output": gold[right].text},
        {"identifier": unreadable, "llm_output": "I would wash the clothes."},
    ]
    goals = tmp_path / "some-model_outputs.json"
    goals.write_text(json.dumps(rows), encoding="utf-8")
    run = eai(
        *("run", "--model", "eai/planner", *NAMED, "--limit", 3),
        *("--with", f"pipeline.goals={goals}", "--out", tmp_path / "runs"),
    )
    assert run.status == 1
    assert f"1 task not answered ({missing}): there is no answer to goal interpretation" in run.err
    folder = tmp_path / "virtualhome" / "action_sequencing" / "eai_planner" / "goals-some-model"
    records = records_in(tmp_path / "runs" / folder.relative_to(tmp_path))
    assert [record["task_id"] for record in records] == [right, unreadable, missing]
    assert [record["success"] for record in records] == [True, False, False]
    assert [record["unanswered"] is None for record in records] == [True, True, False]
    parts = [record["study"]["pipeline"] for record in records]
    assert [each.get("summary", {}).get("stage_1_unreadable") for each in parts] == [False, True, None]
    assert {each["label"] for each in parts} == {"goals-some-model"}


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (("--ability", "goal_interpretation"), "questions of goal_interpretation state no goals"),
        (
            ("--with", "tasks.adaptive=0.5"),
            "tasks.adaptive: cannot be combined with pipeline.goals; adaptive runs choose tasks by",
        ),
    ],
)
def test_what_is_no_pipeline(options: tuple[object, ...], why: str, tmp_path: Path) -> None:
    run = eai("run", "--model", "eai/oracle", "--with", "pipeline.goals=own", *options, "--out", tmp_path)
    assert run.status == 2
    assert why in run.err
