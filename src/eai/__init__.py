"""Measure, diagnose and train language models for embodied decision making.

    import eai

    suite = eai.open("virtualhome", "action_sequencing")
    verdict = suite.score("27_2", '{"WALK": ["washing_machine", "1001"]}')

The names below are the library's public face; each is loaded when it is first asked for.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from eai.abilities.notation.notation import Notation
    from eai.abilities.protocol import Ability, Protocol
    from eai.base.errors import DataError, DomainError, EaiError, InputError, ParseError
    from eai.benchmarks.benchmark import Benchmark, DataSet
    from eai.benchmarks.registry import find_benchmark, list_benchmarks
    from eai.benchmarks.suite import Suite
    from eai.results.batch import Scoring
    from eai.results.reward import Grade, Reward, Shaping, reward
    from eai.tasks.goal_text import make_task
    from eai.tasks.source import Source, use_tasks
    from eai.tasks.task import Goal, GoalKind, Task, goal

__version__ = "0.1.0"

_PLACES = {
    name: module
    for module, names in {
        "eai.abilities.notation.notation": "Notation",
        "eai.abilities.protocol": "Ability Protocol",
        "eai.tasks.goal_text": "make_task",
        "eai.tasks.task": "Goal GoalKind Task goal",
        "eai.benchmarks.benchmark": "Benchmark DataSet",
        "eai.benchmarks.registry": "find_benchmark list_benchmarks",
        "eai.benchmarks.suite": "Suite",
        "eai.base.errors": "DataError DomainError EaiError InputError ParseError",
        "eai.results.batch": "Scoring",
        "eai.results.reward": "Grade Reward Shaping reward",
        "eai.tasks.source": "Source use_tasks",
    }.items()
    for name in names.split()
}
"""Mapping from each public name of the package to the module that defines it."""

__all__ = [
    "Ability",
    "Benchmark",
    "DataError",
    "DataSet",
    "DomainError",
    "EaiError",
    "Goal",
    "GoalKind",
    "Grade",
    "InputError",
    "Notation",
    "ParseError",
    "Protocol",
    "Reward",
    "Scoring",
    "Shaping",
    "Source",
    "Suite",
    "Task",
    "find_benchmark",
    "goal",
    "list_benchmarks",
    "make_task",
    "open",
    "reward",
    "use_tasks",
]


def open(
    benchmark: Benchmark | str,
    ability: Ability | str,
    protocol: Protocol | str = "strict",
    *,
    source: Source | None = None,
) -> Suite:
    """Return the tasks of a benchmark for an ability, ready to score answers.

    Args:
        benchmark: its name (``virtualhome``), ``module:object``, or a `Benchmark`.
        ability: ``goal_interpretation``, ``subgoal_decomposition``, ``action_sequencing`` or
            ``transition_modeling``.
        protocol: the rules for scoring: ``strict``, or ``eai-1.0.5`` for the verdicts of the paper's package.
        source: where the data comes from; the user's default store if None. Missing data is downloaded.

    Raises:
        InputError: there is no such benchmark, ability or protocol.
        DataError: the data is damaged or cannot be obtained.
    """
    from eai.abilities.protocol import Ability, Protocol
    from eai.benchmarks.suite import open_suite

    return open_suite(benchmark, Ability.from_name(ability), Protocol.from_name(protocol), source=source)


def __getattr__(name: str) -> object:
    if name not in _PLACES:
        raise AttributeError(f"module 'eai' has no attribute {name!r}")
    return getattr(import_module(_PLACES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_PLACES})
