"""Score a response file once and print the cost as JSON: `scoring_child.py FILE`, in a fresh process.

The start of the interpreter counts as importing. The data set must have been fetched.
"""

from __future__ import annotations

import json
import sys
import time
from itertools import pairwise
from pathlib import Path

from differential.reference_child import peak_bytes


def main(path: Path) -> None:
    """Measure in turn: importing, loading all tasks, and scoring all answers."""
    rows = [(row["identifier"], row["llm_output"]) for row in json.loads(path.read_text(encoding="utf-8"))]
    clock = [0.0]
    from eai.abilities.verdict import PlanVerdict
    from eai.benchmarks.virtualhome.tasks import open_tasks
    from eai.extensions.reference.virtualhome_plans import VirtualHomeActionSequencingScorer

    clock.append(time.process_time())
    tasks = dict(open_tasks())
    clock.append(time.process_time())
    verdicts = {
        task_id: VirtualHomeActionSequencingScorer(tasks[task_id]).score(text) for task_id, text in rows
    }
    clock.append(time.process_time())
    importing, loading, scoring = (after - before for before, after in pairwise(clock))
    report = {
        "import_cpu_seconds": importing,
        "load_cpu_seconds": loading,
        "score_cpu_seconds": scoring,
        "peak_bytes": peak_bytes(),
        "executable": {
            task_id: isinstance(verdict, PlanVerdict) and verdict.executable
            for task_id, verdict in verdicts.items()
        },
    }
    print(json.dumps(report))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
