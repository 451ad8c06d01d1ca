"""Print the effect of each difference between the protocols on VirtualHome's action sequencing.

Scores response files under both protocols, then under ``strict`` with one rule of ``eai-1.0.5`` at a time,
and prints the tables of rates (bench/README.md) and of effects (docs/extensions/reference). Run with
``python -m bench protocol_effects FILE_OR_FOLDER...`` on files that ``eai score`` reads.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from statistics import mean

from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.verdict import ErrorReport, PlanVerdict, SummaryCounts, Unreadable
from eai.benchmarks.errata import load_errata
from eai.benchmarks.reference_wheel import get_task_id_of_published_id
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome.operators import make_operators
from eai.benchmarks.virtualhome.plan_notation import VirtualHomePlanNotation
from eai.benchmarks.virtualhome.predicates import VOCABULARY
from eai.benchmarks.virtualhome.tasks import VirtualHomeTask, open_tasks
from eai.extensions.reference import virtualhome_quirks
from eai.extensions.reference.virtualhome_plans import (
    LIST_IS_NOT_JSON,
    VirtualHomeActionSequencingScorer,
    _VirtualHomeGoalTest,
    do_most_answers_use_object_ids,
)
from eai.extensions.reference.virtualhome_quirks import QUIRKS
from eai.results.rate import Rate
from eai.results.responses import ResponseFile, find_response_files, read_responses
from eai.results.summary import compute_metric_rates
from eai.tasks.goal_test import GoalTest
from eai.tasks.share import TalliesByGoalKind
from eai.tasks.source import TaskSet
from eai.world.domain import Domain as Simulator
from eai.world.execution import Trajectory, execute_plan
from eai.world.fault import FaultKind

STRICT, REFERENCE = Protocol.STRICT, Protocol("eai-1.0.5")
RATES = ("task_success", "execution_success")
ERRORS = (
    "parsing",
    "hallucination",
    "argument_number",
    "wrong_order",
    "missing_step",
    "affordance",
    "additional_step",
)


@dataclass(frozen=True, slots=True)
class Rules:
    """Protocol of each part of scoring."""

    tasks: Protocol
    reading: Protocol
    naming: Protocol
    script: Protocol
    success: Protocol
    relations: Protocol
    actions: Protocol
    counting: Protocol
    simulator: Simulator


def make_rules(protocol: Protocol) -> Rules:
    """Return rules in which all parts follow one protocol."""
    simulator = (
        virtualhome.make_domain_with_checks_in_paper_order()
        if protocol is STRICT
        else virtualhome_quirks.make_domain_with_all_quirks()
    )
    return Rules(*(protocol,) * 8, simulator)


def list_variants() -> dict[str, Rules]:
    """Return the variants of `strict` with one rule of `eai-1.0.5` each, by name."""
    strict = make_rules(STRICT)
    in_reference_order = Simulator("virtualhome", VOCABULARY, make_operators())
    return {
        "relation_goals_end_at_first": replace(strict, tasks=REFERENCE, relations=REFERENCE),
        "script_counts_as_failure": replace(strict, script=REFERENCE),
        "success_without_execution": replace(strict, success=REFERENCE),
        "lossy_reading": replace(strict, reading=REFERENCE),
        "advertised_actions_rejected": replace(strict, naming=REFERENCE),
        "action_goals_in_text": replace(strict, actions=REFERENCE),
        "counts": replace(strict, counting=REFERENCE),
        "order_of_checks": replace(strict, simulator=in_reference_order),
        **{quirk.__name__: replace(strict, simulator=quirk(strict.simulator)) for quirk in QUIRKS},
    }


@dataclass(frozen=True)
class Judge:
    """Scores the answers to one task under any rules."""

    task: VirtualHomeTask
    with_ids: bool

    @cached_property
    def scorers(self) -> Mapping[Protocol, ActionSequencingScorer]:
        return {
            STRICT: ActionSequencingScorer(
                self.task, virtualhome.make_domain_with_checks_in_paper_order(), VirtualHomePlanNotation()
            ),
            REFERENCE: VirtualHomeActionSequencingScorer(self.task, with_ids=self.with_ids),
        }

    @cached_property
    def goals(self) -> Mapping[Protocol, GoalTest]:
        """Return the test of the goals, with action goals in data set order."""
        return {
            STRICT: GoalTest(self.task),
            REFERENCE: _VirtualHomeGoalTest(self.task, in_data_set_order=True),
        }

    def score(self, text: str, rules: Rules) -> PlanVerdict:
        """Return the verdict on an answer under some rules."""
        excluded = self.scorers[rules.tasks].excluded
        if excluded is not None:
            return PlanVerdict(excluded=excluded)
        plan = self.scorers[rules.reading].notation.read(text)
        if isinstance(plan, Unreadable):
            return _count_like_reference(
                self._make_verdict_without_execution(ErrorReport(FaultKind.PARSING, None, plan.reason)), rules
            )
        actions = self.scorers[rules.naming].resolve_names(plan)
        if isinstance(actions, ErrorReport):
            return _count_like_reference(self._make_verdict_without_execution(actions), rules)
        if rules.script is REFERENCE and actions == self.task.script:
            return replace(self._make_verdict_without_execution(None), executable=True)
        return _count_like_reference(
            self._judge(execute_plan(rules.simulator, self.task.initial, actions), rules), rules
        )

    def _make_verdict_without_execution(self, error: ErrorReport | None) -> PlanVerdict:
        goals = self.goals[STRICT].tally_by_kind(self.goals[STRICT].none_reached)
        return PlanVerdict(executable=False, success=False, error=error, additional_steps=0, goals=goals)

    def _judge(self, trajectory: Trajectory, rules: Rules) -> PlanVerdict:
        tallies = {protocol: self._tally_goals(trajectory, protocol) for protocol in Protocol.list_names()}
        goals = TalliesByGoalKind(
            tallies[STRICT].state, tallies[rules.relations].relation, tallies[rules.actions].action
        )
        failure = trajectory.failure
        executable = failure is None
        return PlanVerdict(
            executable=executable,
            success=all(share.numerator == share.denominator for share in goals)
            and (executable or rules.success is REFERENCE),
            error=None if failure is None else ErrorReport(failure.kind, None, ""),
            additional_steps=trajectory.needless_step_count,
            goals=goals,
        )

    def _tally_goals(self, trajectory: Trajectory, protocol: Protocol) -> TalliesByGoalKind:
        test = self.goals[protocol]
        return test.tally_by_kind(
            test.evaluate_each_goal(
                trajectory.final_state, [action.operator for action in trajectory.executed_actions]
            )
        )


def _count_like_reference(verdict: PlanVerdict, rules: Rules) -> PlanVerdict:
    """Return the verdict with the reference package's counts if the rules ask for them."""
    if rules.counting is STRICT or verdict.goals is None:
        return verdict
    errors = {FaultKind.ADDITIONAL_STEP: verdict.additional_steps or 0}
    if verdict.error is not None:
        errors[verdict.error.kind] = 2 if verdict.error.detail == LIST_IS_NOT_JSON.reason else 1
    return replace(verdict, counted=SummaryCounts(bool(verdict.success), verdict.goals, errors))


@dataclass(frozen=True, slots=True)
class Answers:
    """The answers of one model, each with the judge of its task."""

    model: str
    judged: Sequence[tuple[Judge, str]]

    def compute_rates(self, rules: Rules) -> dict[str, Rate]:
        """Return the summary under some rules."""
        verdicts = [judge.score(text, rules) for judge, text in self.judged]
        return compute_metric_rates(verdicts, Ability.ACTION_SEQUENCING)

    def check(self) -> None:
        """Check that the combined parts give the verdicts of the whole protocols.

        Raises:
            AssertionError: A verdict differs.
        """
        for protocol in Protocol.list_names():
            verdicts = [judge.scorers[protocol].score(text) for judge, text in self.judged]
            rates = compute_metric_rates(verdicts, Ability.ACTION_SEQUENCING)
            if rates != self.compute_rates(make_rules(protocol)):
                raise AssertionError(
                    f"{self.model}: the combined parts of {protocol.value} give other rates than the protocol"
                )


def make_answers(file: ResponseFile, tasks: TaskSet[VirtualHomeTask]) -> Answers:
    """Return the answers of a file, each with the judge of its task."""
    with_ids = do_most_answers_use_object_ids([response.text for response in file.responses])
    return Answers(file.model, [(Judge(tasks[r.task_id], with_ids), r.text) for r in file.responses])


def get_percent(rate: Rate) -> float:
    """Return a rate in percent, or 0 for a rate of nothing."""
    return rate.percent or 0.0


def format_rates(models: Sequence[Answers]) -> Iterator[str]:
    """Return the rates of each model under both protocols as a Markdown table."""
    yield "| model | task success | | execution success | |"
    yield "|---|---:|---:|---:|---:|"
    yield "| | eai-1.0.5 | strict | eai-1.0.5 | strict |"
    for model in models:
        reference = model.compute_rates(make_rules(REFERENCE))
        strict = model.compute_rates(make_rules(STRICT))
        cells = [f"{get_percent(rates[name]):.1f}" for name in RATES for rates in (reference, strict)]
        yield f"| {model.model} | {' | '.join(cells)} |"


def format_effects(models: Sequence[Answers]) -> Iterator[str]:
    """Return a Markdown table: how each rule of `eai-1.0.5` changes the rates of `strict`, in points."""
    yield "| rule | task success | execution success | kinds of error that change most (mean) |"
    yield "|---|---:|---:|---|"
    base = [model.compute_rates(make_rules(STRICT)) for model in models]
    for name, rules in list_variants().items():
        changed = [model.compute_rates(rules) for model in models]
        moved = {
            rate: [
                get_percent(new[rate]) - get_percent(old[rate])
                for new, old in zip(changed, base, strict=True)
            ]
            for rate in (*RATES, *ERRORS)
        }
        cells = [*(format_differences(moved[rate]) for rate in RATES), name_largest_changes(moved)]
        yield f"| {name} | {' | '.join(cells)} |"


def format_differences(points: Sequence[float]) -> str:
    """Return the mean and range of differences in points."""
    if not any(round(point, 1) for point in points):
        return "0"
    return f"{mean(points):+.1f} ({min(points):+.1f} to {max(points):+.1f})"


def name_largest_changes(moved: Mapping[str, Sequence[float]]) -> str:
    """Return the kinds of error whose mean changes by at least a tenth of a point, largest change first."""
    means = {name: mean(moved[name]) for name in ERRORS}
    shown = sorted((n for n in ERRORS if abs(means[n]) >= 0.05), key=lambda n: -abs(means[n]))
    return ", ".join(f"{name.replace('_', ' ')} {means[name]:+.1f}" for name in shown[:3]) or "none"


def main() -> None:
    """Print the tables for some response files."""
    tasks = load_errata("virtualhome").correct_tasks(open_tasks())
    files = [file for path in sys.argv[1:] for file in find_response_files(Path(path))]
    models = [make_answers(read_responses(file, tasks, get_task_id_of_published_id), tasks) for file in files]
    for model in models:
        model.check()
    print("\n".join((*format_rates(models), "", *format_effects(models))))
