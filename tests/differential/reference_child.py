"""Run one evaluation of the reference package and print its cost, for `reference.py`.

`python reference_child.py ABILITY RESPONSES OUTPUT`. The folder RESPONSES has
`virtualhome/ABILITY/<model>_outputs.json`. The last printed line is one JSON object. The syntax is that of
Python 3.8, the oldest version on which the reference package runs.

The evaluation is called like from the package's own command line: one worker, logging to a file. The imports
of the command line are left out, because they need the planner's package, which only transition modeling
uses.
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
    """Return user and system time of this process and of its finished children so far."""
    both = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in both)


def peak_bytes() -> int:
    """Return the maximum resident size so far, in bytes."""
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
