"""The gold plans of the package equal the output of the program that writes them."""

from __future__ import annotations

import pytest

from by_path import ROOT, module_at
from eai.base.store import DataPackStore
from eai.tasks.source import Source
from sweeps import every


@every(100)
def test_gold_plans_equal_the_output_of_the_planning_program(
    activity_store: DataPackStore, monkeypatch: pytest.MonkeyPatch, every: int
) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "tools" / "behavior_1k"))
    tool = module_at("tools/behavior_1k/plans.py")
    source = Source(activity_store)
    for file, (names, set_up) in (
        (tool.FILE, tool.opened(source)),
        (tool.FILE_2026, tool.opened_2026(source)),
    ):
        lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
        packaged = {line.partition("\t")[0]: line for line in lines}
        assert packaged.keys() <= set(names)
        for name in names[::every]:
            line = tool.line_of(set_up, name)
            assert line == packaged.get(name, ""), "run: python tools/behavior_1k/plans.py"
