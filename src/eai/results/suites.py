"""The lines of tidy tables by what they are lines of: a suite, and in it the models.

Shares of lines are by their kind: of answers by leaf, of errors by check, of wrong goals by reason.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from enum import Enum
from typing import NamedTuple, TypeVar

from eai.abilities.protocol import Ability
from eai.abilities.verdict import NONE, NOTHING, ONE, Share
from eai.results.certainty import Case
from eai.results.lines import AnswerLine, Line
from eai.results.table import Estimate

L = TypeVar("L", bound=Line)

SUITE = ("protocol", "domain", "ability")
"""The columns that say what suite a row is of."""

MODEL = "model"
"""The column of models."""

TOGETHER = "all models"
"""The name in the place of a model where the answers of all are taken together."""


class Measure(str, Enum):
    """The measures that a feature of tasks can be set against."""

    SCORE = "score"
    EXECUTABLE = "executable"
    GOALS = "goals"


class SuiteKey(NamedTuple):
    """A suite: the tasks of a benchmark and an ability under a protocol."""

    protocol: str
    domain: str
    ability: str

    def __str__(self) -> str:
        return f"{self.domain} {Ability(self.ability).value.replace('_', ' ')}, {self.protocol}"

    @property
    def file_name(self) -> str:
        """The suite as a part of the name of a file."""
        return f"{self.domain}-{self.ability}-{self.protocol}"


def by_suite(lines: Iterable[L]) -> dict[SuiteKey, list[L]]:
    """The lines of each suite, in the order of first mention."""
    suites: dict[SuiteKey, list[L]] = {}
    for line in lines:
        suites.setdefault(SuiteKey(line.protocol, line.domain, line.ability), []).append(line)
    return suites


def by_model(lines: Sequence[L]) -> dict[str, list[L]]:
    """The lines of each model; before them those of all together, where there are several."""
    models: dict[str, list[L]] = {}
    for line in lines:
        models.setdefault(line.model, []).append(line)
    return models if len(models) < 2 else {TOGETHER: list(lines), **models}


def score_of(answer: AnswerLine) -> Share:
    """The share that an answer adds to the score that its ability is first judged by: success, else F1."""
    if answer.success is not None:
        return Share(int(answer.success), 1)
    if answer.hits is None or answer.extras is None or answer.misses is None:
        return NOTHING
    return Share(2 * answer.hits, 2 * answer.hits + answer.extras + answer.misses)


def executed_of(answer: AnswerLine) -> Share:
    """The share that an answer with a plan or subgoals adds to the share of those that are carried out."""
    return NOTHING if answer.success is None or answer.executable is None else Share(answer.executable, 1)


def goals_of(answer: AnswerLine) -> Share:
    """The share that an answer with a plan or subgoals adds to the share of goals that are reached."""
    if answer.success is None:
        return NOTHING
    met = (answer.state_met, answer.relation_met, answer.action_met)
    total = (answer.state_total, answer.relation_total, answer.action_total)
    return Share(sum(each or 0 for each in met), sum(each or 0 for each in total))


def case_of(line: Line, share: Share) -> Case:
    """The case that a line adds to a rate, with near copies known."""
    return Case(line.task, line.name, share)


MEASURES: Mapping[Measure, Callable[[AnswerLine], Share]] = {
    Measure.SCORE: score_of,
    Measure.EXECUTABLE: executed_of,
    Measure.GOALS: goals_of,
}
"""The share that an answer adds to each measure."""


K = TypeVar("K")


def shares_by_kind(
    lines: Sequence[Line], kinds: Sequence[K], asked: Iterable[K]
) -> Iterator[tuple[K, Estimate]]:
    """Each kind that is asked for, with the share of lines that are of it.

    Args:
        lines: all lines.
        kinds: the kind of each.
        asked: those to tell, in this order.
    """
    of_it, of_others = ([case_of(line, share) for line in lines] for share in (ONE, NONE))
    for kind in asked:
        chosen = zip(kinds, of_it, of_others, strict=True)
        yield kind, Estimate.of([case if found == kind else other for found, case, other in chosen])
