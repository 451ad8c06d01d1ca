"""Table of partial success, from the scores in the package."""

from __future__ import annotations

from collections.abc import Iterator

from eai.abilities.protocol import Ability
from eai.benchmarks.registry import PAPER_BENCHMARKS
from eai.results.paper_tables import ScoresOfPublishedAnswers, read_published_scores

_ABILITIES = (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION)
_TITLES = {"virtualhome": "VirtualHome", "behavior": "BEHAVIOR"}
_METRICS = {"task_success": "success", "total_goal": "goals", "partial_success": "partial"}
_SHORT = {Ability.ACTION_SEQUENCING: "plans", Ability.SUBGOAL_DECOMPOSITION: "subgoals"}


def partial_success_table() -> Iterator[str]:
    """Yield the section of the page: all models, the best plans in BEHAVIOR first."""
    scores = read_published_scores("strict")
    columns = [
        (f"{domain}/{ability.value}", metric)
        for ability in _ABILITIES
        for domain in PAPER_BENCHMARKS
        for metric in _METRICS
    ]
    heads = [
        f"{_TITLES[domain]}, {_SHORT[ability]}: {label}"
        for ability in _ABILITIES
        for domain in PAPER_BENCHMARKS
        for label in _METRICS.values()
    ]
    yield "## Partial success of plans and subgoals"
    yield ""
    yield "The paper defines [partial success](reports.md#partial-success) (section 2, ability 3) and prints"
    yield "no figure of it. The table shows the public answers under `strict`, in percent: answers that"
    yield "succeed, goals that are reached, and the mean share of conditions that are met."
    yield ""
    yield f"| model | {' | '.join(heads)} |"
    yield f"|---|{'--:|' * len(heads)}"
    for model in _ranked(scores.suites[f"behavior/{Ability.ACTION_SEQUENCING.value}"]):
        cells = [scores.suites[suite].find_rates(model)[metric].percent for suite, metric in columns]
        yield f"| {model} | {' | '.join('-' if cell is None else f'{cell:.1f}' for cell in cells)} |"
    yield ""


def _ranked(suite: ScoresOfPublishedAnswers) -> list[str]:
    return sorted(suite.models, key=lambda model: -(suite.find_rates(model)["partial_success"].percent or 0))
