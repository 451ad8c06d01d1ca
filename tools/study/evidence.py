"""Evidence for claims: the records of a protocol as tidy tables, the data set, the planner."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from statistics import fmean
from typing import NamedTuple, TypeVar

from eai.abilities.protocol import Ability
from eai.abilities.transition_modeling.scorer import TransitionModelingScorer
from eai.benchmarks.suite import Suite as ScoredSuite
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.lines import AnswerTableLine, TidyTableLine, make_task_rate_contribution
from eai.results.paper_tables import ScoresOfPublishedAnswers, map_files_to_paper_models
from eai.results.rate import Rate, compute_rate
from eai.results.record import Record
from eai.results.table import Estimate
from eai.results.tidy import TidyTables
from eai.results.totals import RunTotals
from eai.studies.cofactors.effects import compute_rank_correlation
from eai.studies.sensitivity.study import (
    OperatorReplacementTrial,
    group_successes_by_operator_and_category,
    replace_gold_operators_one_by_one,
)
from eai.tasks.share import Share
from eai.tasks.source import ErrataChoice, Source

V, B = "virtualhome", "behavior"
NAMED = {V: "VirtualHome", B: "BEHAVIOR"}
GI, SD = Ability.GOAL_INTERPRETATION.value, Ability.SUBGOAL_DECOMPOSITION.value
AS, TM = Ability.ACTION_SEQUENCING.value, Ability.TRANSITION_MODELING.value
GPT_4O = "gpt-4o-2024-05-13"
"""The model of the paper's analyses of single models."""

L = TypeVar("L", bound=TidyTableLine)


class Suite(NamedTuple):
    domain: str
    ability: str

    def __str__(self) -> str:
        return f"{NAMED[self.domain]}, {self.ability.replace('_', ' ')}"


PLANS = (Suite(V, AS), Suite(V, SD), Suite(B, AS), Suite(B, SD))


class Evidence:
    """The records of one protocol, suite by suite.

    Args:
        source: Location of the data set.
        scores: Scores of the answers, computed earlier with a planner; None to compute rates from records.
    """

    def __init__(self, source: Source, scores: Mapping[str, ScoresOfPublishedAnswers] | None = None) -> None:
        self.source = source
        self._scores = scores
        self._rates: dict[tuple[str, str, str], Mapping[str, Rate]] = {}
        self.suites: dict[Suite, dict[str, list[Record]]] = {}
        self.tables = TidyTables(self.published)
        self._tried: dict[tuple[str, str], list[OperatorReplacementTrial]] = {}
        self._planned: dict[tuple[str, PlannerChoice], ScoredSuite] = {}

    @property
    def published(self) -> Source:
        """The data as published, which the paper's claims are about."""
        return replace(self.source, errata=ErrataChoice.NONE)

    def add(self, records: Sequence[Record]) -> None:
        """Add a run."""
        first = records[0]
        suite = Suite(first.domain, first.ability.value)
        self.suites.setdefault(suite, {})[first.model] = list(records)
        self.tables.add_records(records)

    @cached_property
    def models(self) -> list[str]:
        """Names of all models in the paper."""
        found = {model for models in self.suites.values() for model in models}
        return sorted(found, key=lambda model: map_files_to_paper_models().get(model, model))

    @cached_property
    def names(self) -> list[str]:
        """The paper's names of its 18 models."""
        return sorted(set(map_files_to_paper_models().values()))

    @property
    def is_whole(self) -> bool:
        """Whether all models of the paper answered all suites, and a planner judged their operators."""
        answered = all(len(runs) == len(self.names) for runs in self.suites.values())
        planned = all(self.percent(V, TM, "overall.planner_success", name) is not None for name in self.names)
        return len(self.suites) == 8 and answered and planned

    def percent(self, domain: str, ability: str, metric: str, model: str) -> float | None:
        """Return a rate of a model, by the paper's name of it, or None if it is unknown."""
        rates = self._rates.get((domain, ability, model))
        if rates is None:
            rates = self._rates[domain, ability, model] = self._find_rates(domain, ability, model)
        return rates[metric].percent if metric in rates else None

    def _find_rates(self, domain: str, ability: str, model: str) -> Mapping[str, Rate]:
        if self._scores is not None:
            suite = self._scores[f"{domain}/{ability}"]
            return suite.find_rates(model) if model in suite.models else {}
        for name, records in self.suites.get(Suite(domain, ability), {}).items():
            if map_files_to_paper_models().get(name, name) == model:
                return RunTotals.from_records(records).rates
        return {}

    def answers(self, suite: Suite, model: str | None = None) -> list[AnswerTableLine]:
        """Answers that count."""
        return [each for each in self.of(self.tables.answers, suite, model) if each.outcome != "excluded"]

    def of(self, lines: Iterable[L], suite: Suite, model: str | None = None) -> list[L]:
        """Return the lines of a suite, and of one model if it is given."""
        return [
            each for each in lines if (each.domain, each.ability) == suite and model in (None, each.model)
        ]

    def sensitivity(self, domain: str, models: Sequence[str]) -> Mapping[tuple[str, str], Rate]:
        """Return the share of problems solved with one operator of a model, by operator and category."""
        trials = [trial for model in models for trial in self.trials(domain, model)]
        return {
            key: compute_rate(case.share for case in cases)
            for key, cases in group_successes_by_operator_and_category(trials).items()
        }

    def trials(self, domain: str, model: str) -> list[OperatorReplacementTrial]:
        """Return the trials of a model's operators, each alone among gold ones."""
        if (domain, model) not in self._tried:
            records = self.suites[Suite(domain, TM)][model]
            suite = self.planned_suite(domain)
            self._tried[domain, model] = [trial for record in records for trial in _tried(suite, record)]
        return self._tried[domain, model]

    def planned_suite(self, domain: str, planner: PlannerChoice = PlannerChoice.BUILT_IN) -> ScoredSuite:
        """Return the suite of transition modeling with a planner, opened once."""
        if (domain, planner) not in self._planned:
            records = next(iter(self.suites[Suite(domain, TM)].values()))
            source = Source(self.source.store, planner=planner)
            self._planned[domain, planner] = open_suite(
                domain, Ability.TRANSITION_MODELING, records[0].protocol, source=source
            )
        return self._planned[domain, planner]


def _tried(suite: ScoredSuite, record: Record) -> Iterator[OperatorReplacementTrial]:
    scorer = suite.scorer(record.task_id)
    if isinstance(scorer, TransitionModelingScorer):
        return replace_gold_operators_one_by_one(scorer, record)
    return iter(())


def rate(lines: Iterable[L], hit: Callable[[L], bool]) -> Estimate:
    """Return the share of lines with a hit, in percent. Its interval counts near copies together."""
    return Estimate.from_task_rate_contributions(
        [make_task_rate_contribution(line, Share(int(hit(line)), 1)) for line in lines]
    )


def rho(
    lines: Sequence[AnswerTableLine], feature: str, value: Callable[[AnswerTableLine], float | None]
) -> Estimate:
    """Return Spearman's correlation of a feature of tasks with a value of answers."""
    known = [(line, number) for line in lines if (number := value(line)) is not None]
    return compute_rank_correlation(
        [getattr(line, feature) for line, _ in known],
        [number for _, number in known],
        [line.name for line, _ in known],
    )


def rho_of_means(
    lines: Sequence[AnswerTableLine], feature: str, value: Callable[[AnswerTableLine], float | None]
) -> Estimate:
    """Return Spearman's correlation of a feature of tasks with each task's mean value over models."""
    values: dict[str, list[float]] = {}
    first: dict[str, AnswerTableLine] = {}
    for line in lines:
        number = value(line)
        if number is not None:
            values.setdefault(line.task, []).append(number)
            first.setdefault(line.task, line)
    means = {task: fmean(numbers) for task, numbers in values.items()}
    return rho(list(first.values()), feature, lambda line: means[line.task])


def told(estimate: Estimate) -> str:
    """Return an estimate as text: numerator and denominator, value, interval."""
    if estimate.value is None:
        return "–"
    if estimate.denominator is None:
        return f"{estimate.value:+.2f}{_bounds(estimate, '{:+.2f}')}"
    made_of = f"{estimate.numerator:g}/{estimate.denominator:g}"
    return f"{made_of} = {estimate.value:.1f} %{_bounds(estimate, '{:.1f}')}"


def _bounds(estimate: Estimate, form: str) -> str:
    if estimate.low is None or estimate.high is None:
        return ""
    return f" [{form.format(estimate.low)}, {form.format(estimate.high)}]"


def below_zero(estimate: Estimate) -> bool:
    """Return whether the whole interval is below zero."""
    return estimate.high is not None and estimate.high < 0
