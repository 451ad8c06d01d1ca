from __future__ import annotations

import re
from pathlib import Path

from agents.test_rules import CASE, EASY_NAME, written
from command_line import Command
from eai.agents.play import EpisodeFactory
from eai.agents.setting import ACTING
from eai.base.store import DataPackStore
from eai.benchmarks.suite import open_suite


def test_a_board_refuses_other_rules_and_counts_what_does_not_replay(
    eai: Command, tmp_path: Path, data_store: DataPackStore
) -> None:
    suite = open_suite("virtualhome", ACTING)
    setup = EpisodeFactory(suite.benchmark).make_setup(suite.tasks["27_2"])
    right = "\n".join([*(setup.reference.commands or ()), "DONE"])
    board = tmp_path / "board" / "mine"
    place = board / "virtualhome" / "acting"
    place.mkdir(parents=True)
    (board / "submission.toml").write_text('model = "M"\ndate = 2026-11-26\n')
    bad = {task: CASE["11_1"] for task in suite.task_ids if task != "27_2"}
    written(place, "m", {**bad, "27_2": right})
    done = eai("board", tmp_path / "board", "--out", tmp_path / "site")
    assert done.status == 0, done.err
    page = (tmp_path / "site" / "index.html").read_text()
    row = page[page.index('<a href="#mine">M</a>') :].partition("</tr>")[0]
    heading = page[: page.index('<a href="#mine">M</a>')].rpartition("<thead>")[2].partition("</thead>")[0]
    names = re.findall("<th>(.*?)</th>", heading)
    cells = [re.sub("<sup>.*?</sup>|<small>.*?</small>|<[^>]+>", "", each) for each in row.split("</td>")]
    shown = {name.rpartition(": ")[2]: cell.strip() for name, cell in zip(names[1:], cells, strict=False)}
    rates = {name: shown[name] for name in ("Unreplayable", "Answered")}
    assert rates == {"Unreplayable": "99.7", "Answered": "342/342"}  # 336 of 337 do not replay
    assert cells[1].strip() == "0.3"
    written(place, "m", {**bad, "27_2": CASE["813_2"]})
    refused = eai("board", tmp_path / "board", "--out", tmp_path / "site")
    assert refused.status == 2
    assert f"other game rules in the answer to 27_2: {EASY_NAME}" in " ".join(refused.err.split())
    written(place, "m", {**bad, "27_2": CASE["27_2"]})
    assert eai("board", tmp_path / "board", "--out", tmp_path / "site").status == 0
