"""A job done in a process of its own, which imports this module by its name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from eai.benchmarks.registry import find_benchmark
from eai.run.evaluation import Answers, obtain_answers
from eai.run.job import Job


def obtain_in_child(make_job: Callable[..., Job], journal: Path, logs: Path) -> Answers:
    """Do a job of VirtualHome, which is found where it is asked: a declaration does not travel."""
    return obtain_answers(make_job(benchmark=find_benchmark("virtualhome")), journal, logs)
