"""Episodes with rules that their player chose are kept apart, and no episode can exclude a task."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from agents.switches import SWITCHES
from command_line import Command
from eai.abilities.experiment import Experiment
from eai.agents.episode_server import open_episode_server
from eai.agents.play import (
    RULE_NAMES,
    EpisodeFactory,
    RecordedGame,
    StoredEpisode,
    make_game_rules,
    make_label_of_nonstandard_rules,
    read_episode,
)
from eai.agents.reference import make_setup
from eai.agents.rules import GameRules
from eai.agents.setting import ACTING, STANDARD, AgentSetting
from eai.base.store import DataPackStore
from eai.benchmarks.suite import open_suite
from eai.results.batch import OTHER_RULES, score_run, split_answers_by_game_rules
from eai.results.options import ScoringOptions
from eai.results.records import read_records
from eai.results.responses import Response, ResponseFile, read_responses
from eai.run.spec import read_spec
from eai.tasks.prompts.prompt import PromptSet

SUITE = open_suite(SWITCHES, ACTING)
DOMAIN = "agents.switches:SWITCHES"
EASY = GameRules(view="task", observe="full", until="goal", budget=None, max_steps=None)
EASY_NAME = "view-task_observe-full_feedback-facts_budget-none_until-goal"
WIN = {"both": ("PRESS(lamp)", "GO(shed)", "OPEN(box)", "PRESS(torch)"), "half": ("PRESS(lamp)",)}
EMPTY = json.dumps({"turns": [], "rules": EASY.model_dump(mode="json")})


def played(task: str, rules: GameRules, *commands: str) -> str:
    play = RecordedGame(make_setup(SUITE.tasks[task], SWITCHES, rules), seed=0, epoch=1)
    for command in commands:
        play.play_command(command)
    return play.write_as_json_text("stopped")


def won(task: str, rules: GameRules = make_game_rules(STANDARD)) -> str:  # noqa: B008 - a frozen value
    return played(task, rules, *WIN[task], *(["DONE"] if rules.until == "done" else []))


def unreplayable(task: str) -> str:
    return json.dumps({**json.loads(won(task)), "opening": "0" * 64})


def written(folder: Path, model: str, texts: Mapping[str, str]) -> Path:
    file = folder / f"{model}_outputs.json"
    file.write_text(json.dumps([{"identifier": task, "llm_output": text} for task, text in texts.items()]))
    return file


@pytest.mark.parametrize(
    "chosen",
    [
        {},
        {"view": "task"},
        {"observe": "full", "feedback": "outcome"},
        {"feedback": "facts", "budget": 4.0, "steps": 20},
        {"slip": 0.25, "slip_seed": 3},
        {"slip_seed": 5},
        {"verifier": True},
        {"budget": 0.1},
        {"prompts": "short"},
        {"feedback": "outcome", "observe": "full", "prompts": "facts", "slip": 0.1},
    ],
    ids=str,
)
def test_an_episode_has_the_label_of_the_setting_in_which_it_was_played(chosen: dict[str, Any]) -> None:
    setting = AgentSetting(**chosen)
    play = EpisodeFactory(SWITCHES, setting).begin_episode(SUITE.tasks["both"])
    play.play_command("PRESS(lamp)")
    episode = read_episode(play.write_as_json_text("stopped"))
    assert isinstance(episode, StoredEpisode)
    assert make_label_of_nonstandard_rules(episode) == (setting.label or None)


def test_a_run_in_a_prompt_set_names_it_in_the_rules_of_its_episodes() -> None:
    for name in ("short", "facts"):
        spec = read_spec({"prompts": {"set": name}, "agent": {"slip": 0.5}})
        assert spec.setting.label == f"prompts-{name}_slip-0.5"
    assert read_spec({"prompts": {"set": "official"}}).setting == STANDARD


@pytest.mark.parametrize("name", ["short", "facts"])
def test_an_episode_in_a_prompt_set_replays_alike(name: PromptSet) -> None:
    """Only texts differ, so the verdict is that of the episode with plain texts."""
    plain = make_game_rules(STANDARD)
    episodes = [won("both", rules) for rules in (plain, plain.model_copy(update={"prompts": name}))]
    assert len({json.loads(episode)["opening"] for episode in episodes}) == 2
    verdicts = [SUITE.score("both", episode) for episode in episodes]
    assert verdicts[0] == verdicts[1]
    assert verdicts[0].reached


def test_every_rule_has_a_place_in_the_label() -> None:
    assert RULE_NAMES.keys() == {*GameRules.model_fields, "slip_seed"}
    others: dict[str, Any] = {
        "slip": 0.5,
        "view": "task",
        "observe": "full",
        "reward": "progress",
        "gamma": 0.5,
    }
    others |= {"until": "goal", "max_steps": 3, "budget": None, "admissible": True, "feedback": "facts"}
    others |= {"prompts": "short", "verifier": True}
    assert others.keys() == {*GameRules.model_fields}
    standard = make_game_rules(STANDARD).model_dump(mode="json")
    for name, value in others.items():
        text = json.dumps({"turns": [{"said": "DONE"}], "rules": {**standard, name: value}})
        episode = read_episode(text)
        assert isinstance(episode, StoredEpisode)
        assert make_label_of_nonstandard_rules(episode) == f"{RULE_NAMES[name]}-{str(value).lower()}"
    for text in (
        "DONE",
        '{"turns": []}',
        json.dumps({"turns": [], "rules": standard, "seed": 7, "epoch": 3}),
    ):
        episode = read_episode(text)
        assert isinstance(episode, StoredEpisode)
        assert make_label_of_nonstandard_rules(episode) is None


def test_answers_are_split_by_their_rules_with_all_epochs() -> None:
    texts = {"both": won("both"), "half": won("half", EASY), "greet": "{}", "done": EMPTY}
    further = ResponseFile("m", (Response("both", won("both", EASY)), Response("half", won("half"))))
    answers = ResponseFile("m", tuple([Response(*each) for each in texts.items()]), further_epochs=(further,))
    parts = split_answers_by_game_rules(ACTING, answers)
    tasks = {
        rules: [[r.task_id for r in epoch.responses] for epoch in (part, *part.further_epochs)]
        for rules, part in parts.items()
    }
    assert tasks == {None: [["both", "greet", "done"], ["half"]], EASY_NAME: [["half"], ["both"]]}
    void = ResponseFile("m", (Response("both", ""), Response("half", won("half", EASY))))
    assert split_answers_by_game_rules(ACTING, void) == {EASY_NAME: void}
    assert split_answers_by_game_rules(ACTING, ResponseFile("m", (Response("both", "{"),))).keys() == {None}


def test_a_file_with_several_samples_is_split_too(tmp_path: Path) -> None:
    texts = [("both", 0, won("both")), ("both", 1, won("both", EASY)), ("half", 0, ""), ("half", 1, "DONE")]
    rows = [{"identifier": task, "sample": number, "llm_output": text} for task, number, text in texts]
    file = tmp_path / "m_outputs.jsonl"
    file.write_text("".join([json.dumps(row) + "\n" for row in rows]))
    parts = split_answers_by_game_rules(ACTING, read_responses(file, SUITE.task_ids, samples=True))
    found = {rules: [(each.task_id, each.sample) for each in part.responses] for rules, part in parts.items()}
    assert found == {None: [("both", 0), ("half", 0), ("half", 1)], EASY_NAME: [("both", 1)]}
    assert [(len(part.responses), {*part.answered_task_ids}) for part in parts.values()] == [
        (3, {"both", "half"}),
        (1, {"both"}),
    ]


@pytest.mark.parametrize("workers", [1, 2])
def test_score_keeps_episodes_by_other_rules_apart(eai: Command, tmp_path: Path, workers: int) -> None:
    texts = {"both": won("both", EASY), "half": won("half"), "greet": unreplayable("both"), "done": "DONE"}
    file = written(tmp_path, "m", texts)
    asked = ("score", file, "--domain", DOMAIN, "--ability", "acting", "--out", tmp_path / "out")
    done = eai(*asked, "--allow-missing", "--workers", workers)
    assert done.status == 0
    assert f"m, rules {EASY_NAME.replace('_', ' ')}" in done.out
    assert "m: 1 answer by other rules than the standard setting, scored apart" in done.err
    apart = tmp_path / "out" / f"rules-{EASY_NAME}"
    standard, easy = (
        {record.task_id: record for record in read_records(folder / "records.jsonl")}
        for folder in (tmp_path / "out", apart)
    )
    assert {getattr(record.experiment, "rules", None) for record in standard.values()} == {None}
    assert {getattr(record.experiment, "rules", None) for record in easy.values()} == {EASY_NAME}
    came_to = {task: (r.verdict.excluded, r.unanswered) for task, r in standard.items()}
    assert came_to["both"] == (None, OTHER_RULES)  # it is lost, whether or not missing answers count
    assert came_to["greet"] == came_to["half"] == (None, None)
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["success"] == {"value": 50.0, "numerator": 2, "denominator": 4}
    assert summary["unreplayable"] == {"value": 25.0, "numerator": 1, "denominator": 4}
    assert json.loads((apart / "summary.json").read_text())["agent"]["rules"] == EASY_NAME
    printed = json.loads(eai(*asked, "--json").out)
    assert [each.get("rules") for each in printed] == [None, EASY_NAME]

    assert eai("report", tmp_path / "out", "--out", tmp_path / "report", "--no-plots").status == 0
    report = (tmp_path / "report" / "report.md").read_text()
    before, _, after = report.partition("### Experiments: acting")
    assert "until-goal" not in before.replace("\\", "")
    assert f"m, rules-{EASY_NAME}" in after.replace("\\", "")
    assert "Unreplayable" in before


def test_episodes_by_other_rules_in_any_epoch_are_lost_even_if_answers_may_be_missing(
    eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first task is played by other rules twice, the second once. The third is lost or not answered."""
    easy = {"both": won("both", EASY)}
    epochs = ({**easy, "half": won("half")}, {**easy, "half": won("half", EASY), "greet": "DONE"})
    first, second = [
        ResponseFile("m", tuple([Response(*each) for each in texts.items()])) for texts in epochs
    ]
    answers = replace(first, further_epochs=(second,))
    monkeypatch.setattr("eai.cli.score.read_responses", lambda *_, **__: answers)
    asked = ("score", written(tmp_path, "m", easy), "--domain", DOMAIN, "--ability", "acting")
    assert eai(*asked, "--allow-missing", "--out", tmp_path / "out").status == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["success"] == {"value": pytest.approx(16.67, abs=0.01), "numerator": 0.5, "denominator": 3}


def test_shards_of_a_file_with_several_rules_are_merged(eai: Command, tmp_path: Path) -> None:
    file = written(tmp_path, "m", {"both": won("both", EASY), "half": won("half")})
    asked = ("score", file, "--domain", DOMAIN, "--ability", "acting", "--out")
    assert eai(*asked, tmp_path / "whole").status == 0
    for number in (1, 2):
        assert eai(*asked, tmp_path / "parts", "--shard", f"{number}/2").status == 0
    assert eai("score", tmp_path / "parts", "--merge").status == 0
    for name in ("records.jsonl", f"rules-{EASY_NAME}/records.jsonl", f"rules-{EASY_NAME}/summary.json"):
        assert (tmp_path / "parts" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


def test_compare_takes_only_episodes_by_the_same_rules(eai: Command, tmp_path: Path) -> None:
    asked = ("--domain", DOMAIN, "--ability", "acting", "--out")
    texts = {"mixed": won("both", EASY), "fair": won("both"), "easy": won("both", EASY)}
    for model, text in texts.items():
        half = won("half", EASY) if model == "easy" else won("half")
        file = written(tmp_path, model, {"both": text, "half": half})
        assert eai("score", file, *asked, tmp_path / model).status == 0
    fair = eai("compare", tmp_path / "mixed", tmp_path / "fair")
    assert fair.status == 0
    assert "success only in fair (1): both" in " ".join(fair.out.split())
    assert f"only one side has switches acting, protocol strict, rules {EASY_NAME}" in " ".join(
        fair.err.split()
    )
    refused = eai("compare", tmp_path / "fair", tmp_path / "easy")
    assert refused.status == 2
    assert "under the same game rules" in refused.err
    same = eai("compare", tmp_path / "mixed" / f"rules-{EASY_NAME}", tmp_path / "easy")
    assert same.status == 0
    assert f"rules {EASY_NAME}" in " ".join(same.out.split())


def test_served_episodes_have_the_rules_of_their_server(tmp_path: Path) -> None:
    setting = AgentSetting(observe="full", feedback="facts")
    with open_episode_server(tmp_path, SUITE, [("half", 1)], setting) as worlds:
        for command in (*WIN["half"], "DONE"):
            worlds.play_command(("half", 1), command)
    answers = read_responses(tmp_path / "agent_outputs.jsonl", SUITE.task_ids)
    assert split_answers_by_game_rules(ACTING, answers).keys() == {setting.label}
    (record,) = score_run(SUITE, answers, {}, ScoringOptions())
    assert record.experiment == Experiment(harness="mcp", rules="observe-full_feedback-facts")
    assert record.verdict.success  # type: ignore[attr-defined]


CASE = {
    "27_2": '{"turns":[{"said":"WALK(soap.1002)"}],"rules":{"budget":1e308,"until":"done"}}',
    "11_1": '{"turns":[{"said":"DONE"}],"opening":"' + "0" * 64 + '"}',
    "813_2": '{"turns":[{"said":"DONE"}],"rules":{"view":"task","observe":"full","until":"goal",'
    '"budget":null,"max_steps":null}}',
}


def test_exploits_fail_and_are_counted_in_virtualhome(
    eai: Command, tmp_path: Path, data_store: DataPackStore
) -> None:
    file = written(tmp_path, "m", CASE)
    asked = ("score", file, "--domain", "virtualhome", "--ability", "acting", "--out", tmp_path / "out")
    assert eai(*asked, "--allow-missing").status == 0
    records = {r.task_id: r for r in read_records(tmp_path / "out" / "records.jsonl")}
    errors = {task: records[task].verdict.error for task in ("27_2", "11_1")}
    assert {task: error and (error.kind.value, error.check) for task, error in errors.items()} == {
        "27_2": ("parsing", None),
        "11_1": ("uncategorised", "unreplayable"),
    }
    assert {records[task].verdict.excluded for task in CASE} == {None}
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (summary["success"]["numerator"], summary["success"]["denominator"]) == (0, 3)
    assert summary["unreplayable"]["numerator"] == 1
    shown = eai("explain", tmp_path / "out", "11_1").out
    assert "unreplayable: the first observation: the observation is another one" in " ".join(shown.split())
