"""Compare each reader with twenty logs. An author who did not know the readers wrote and labeled the logs.

A line of a file in `by_another_hand` is a log:

- `content`: a text, JSON, or lines (each line is a text or JSON). For Inspect, `content` lists samples.
- `log`: further fields of a log of Inspect. `keep`: share of the file that remains
- `games`: true for a replay
- `label`: `refused` lists words of the message. `episodes` has labels of the episodes, in order

A label of an episode has the `outcome` and the `error`, the first rejected action with its kind and its
number from 0 (null without an error; `unproven` if the log does not show it). Some have `end` and `best`.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark
from eai.extensions.logs.episode import CANNOT_TELL, EpisodeEndReason, EpisodeOutcome, LoggedEpisode
from eai.extensions.logs.readers import read_log

games = pytest.importorskip("extensions.alfworld.test_alfworld", reason="needs the extension alfworld")

FOLDER = Path(__file__).parent / "by_another_hand"
LOGS = [
    pytest.param(log, id=f"{path.stem}: {log['name']}")
    for path in sorted(FOLDER.glob("*.jsonl"))
    for log in map(json.loads, path.read_text(encoding="utf-8").splitlines())
]
HEADER = {"created": "2026-10-02T09:00:00+00:00", "task": "tidy", "dataset": {}, "model": "m", "config": {}}
ENDINGS = {"time": EpisodeEndReason.OUT_OF_TIME, "steps": EpisodeEndReason.OUT_OF_STEPS}


def write(folder: Path, log: dict[str, Any]) -> Path:
    path, content = folder / log["file"], log["content"]
    if path.name in ("a.json", "a.eval"):
        inspect_log = pytest.importorskip("inspect_ai.log")
        value = {"version": 2, "status": "success", "eval": HEADER, "samples": content, **log.get("log", {})}
        text = json.dumps(value)
        if path.suffix == ".eval":
            inspect_log.write_eval_log(inspect_log.EvalLog.model_validate(value), str(path))
        else:
            path.write_text(text, encoding="utf-8")
        whole = path.read_bytes()
        path.write_bytes(whole[: int(len(whole) * log.get("keep", 1))])
        return path
    if isinstance(content, list):
        lines = [line if isinstance(line, str) else json.dumps(line, ensure_ascii=False) for line in content]
        content = "\n".join(lines) + "\n" * (not isinstance(content[-1], str))
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return path


def open_games(folder: Path) -> Benchmark:
    place = folder / "valid_unseen" / "pick_cool_then_place_in_recep-Apple-None-SideTable-7" / "trial_T1"
    place.mkdir(parents=True)
    (place / "game.tw-pddl").write_text(json.dumps(games.GAME))
    return games.opened(folder)


def compare(episode: LoggedEpisode, label: dict[str, Any]) -> None:
    assert episode.outcome is EpisodeOutcome(label["outcome"])
    first, error = episode.index_of_first_error, label["error"]
    if error == "unproven":
        assert first is None or episode.steps[first].kind is None
    elif error is None:
        assert first is None
    else:
        assert first is not None
        step = episode.steps[first]
        assert (step.kind.value if step.kind else CANNOT_TELL) == error["kind"]
        assert step.action == error["action"]
        assert first == error.get("number", first)
    if "end" in label:
        assert episode.ending is ENDINGS[label["end"]]
    if "best" in label:
        assert episode.best_goal_progress == label["best"]


@pytest.mark.parametrize("log", LOGS)
def test_a_reader_says_what_a_log_proves_and_no_more(tmp_path: Path, log: dict[str, Any]) -> None:
    path = write(tmp_path, log)
    benchmark = open_games(tmp_path / "games") if log.get("games") else None
    label = log["label"]
    if "refused" in label:
        with pytest.raises(InputError) as caught:
            read_log(path, benchmark)
        for words in (path.name, *label["refused"]):
            assert words in str(caught.value)
        return
    episodes = read_log(path, benchmark)
    assert len(episodes) == len(label["episodes"])
    for episode, of_episode in zip(episodes, label["episodes"], strict=True):
        compare(episode, of_episode)
