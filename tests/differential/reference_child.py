"""Run one evaluation of the reference and print its cost: `reference.py`'s half in the other environment.

`python reference_child.py ABILITY RESPONSES OUTPUT`, where the folder RESPONSES holds
`virtualhome/ABILITY/<model>_outputs.json`. The last line printed is one JSON object. It runs on every Python
that the reference runs on, so its syntax stays with Python 3.8.

The evaluation is called as the reference's own command line calls it, one worker, logging to a file, but
without the command line's imports: those want the planner's package, which only transition modeling needs.
"""

import importlib
import json
import platform
import random
import resource
import sys
import types
from pathlib import Path


def cpu_seconds() -> float:
    """User and system time of this process and of its finished children so far."""
    both = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in both)


def peak_bytes() -> int:
    """The largest resident size so far (kilobytes on Linux, bytes on macOS)."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


def main(ability: str, responses: str, output: str) -> None:
    """Evaluate every response file of an ability and print cost and results."""
    evaluation = importlib.import_module(f"virtualhome_eval.evaluation.{ability}.scripts.evaluate_results")
    log_config = importlib.import_module("virtualhome_eval.log_config")
    package = Path(str(evaluation.__file__)).parents[3]
    arguments = types.SimpleNamespace(
        mode="evaluate_results",
        eval_type=ability,
        dataset="virtualhome",
        llm_response_path=responses,
        output_dir=output,
        scene_id=1,
        num_workers=1,
        resource_dir=str(package / "resources"),
        dataset_dir=str(package / "dataset"),
        evaluation_dir=str(package / "evaluation"),
    )
    log_config.setup_logging(log_dir=output, function_name=ability)
    random.seed(0)
    started = cpu_seconds()
    results = evaluation.evaluate_results(arguments)
    report = {
        "python": platform.python_version(),
        "startup_cpu_seconds": started,
        "cpu_seconds": cpu_seconds() - started,
        "peak_bytes": peak_bytes(),
        "results": results,
    }
    print(json.dumps(report))


if __name__ == "__main__":
    main(*sys.argv[1:])
