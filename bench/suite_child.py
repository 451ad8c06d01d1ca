"""Score response files and print what it cost, as JSON: `suite_child.py ABILITY FILE...`, in a fresh process.

The data set must have been fetched. Making the scorer of a task is counted as scoring its first answer. What
is made once, whatever the answers, is made before: the parser (the reference makes its own when it is
imported), the domain, the tasks, and the search for garbage that loading them leaves behind.
"""

from __future__ import annotations

import gc
import json
import sys
import time
from contextlib import suppress
from functools import cache
from pathlib import Path

from reference_child import peak_bytes


def main(ability: str, paths: list[Path]) -> None:
    """Measure scoring every answer of every file, one after the other, tasks being loaded."""
    rows = [
        (row["identifier"].removeprefix("scene_1_"), row["llm_output"])
        for path in paths
        for row in json.loads(path.read_text(encoding="utf-8"))
    ]
    from eai.abilities.protocol import Ability
    from eai.errors import ParseError
    from eai.households.virtualhome import domain as virtualhome
    from eai.households.virtualhome.tasks import open_tasks
    from eai.logic.ltl import parse
    from eai.reference import virtualhome_quirks
    from eai.reference.virtualhome_goals import ByLargestId
    from eai.reference.virtualhome_subgoals import VirtualHomeSubgoalDecomposition

    tasks = dict(open_tasks())
    goals = Ability(ability) is Ability.GOAL_INTERPRETATION
    subgoals = VirtualHomeSubgoalDecomposition
    make = cache(
        lambda task_id: (
            ByLargestId(tasks[task_id], virtualhome.as_meant()) if goals else subgoals(tasks[task_id])
        )
    )
    with suppress(ParseError):
        parse("?", dialect="release")  # makes the parser, and what it finds errors with
    _ = virtualhome_quirks.as_in_reference().compiled
    gc.collect()
    loaded = time.process_time()
    for task_id, text in rows:
        make(task_id).score(text)
    seconds = time.process_time() - loaded
    print(json.dumps({"answers": len(rows), "score_cpu_seconds": seconds, "peak_bytes": peak_bytes()}))


if __name__ == "__main__":
    main(sys.argv[1], [Path(path) for path in sys.argv[2:]])
