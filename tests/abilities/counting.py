"""A seventh ability, as another distribution would provide it: counting the objects of a task."""

from __future__ import annotations

from dataclasses import dataclass

from eai.abilities.declaration import (
    AbilityDeclaration,
    AnswerOutcome,
    DomainAndNotation,
    MetricColumn,
    QuestionAndAnswer,
    SingleQuestionInteraction,
)
from eai.abilities.explanation import VerdictExplanation
from eai.abilities.protocol import Ability
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.verdict import RewardInputs, Verdict, make_rate_contribution_of_answer
from eai.tasks.task import Task


@dataclass(frozen=True, slots=True)
class CountVerdict(Verdict):
    """The verdict on a number: whether it is right, and its distance from the right number."""

    right: bool = False
    off_by: int | None = None

    def compute_reward_inputs(self, goals_at_start: object) -> RewardInputs:
        return RewardInputs(float(self.right), self.right, ended=False, faults={})


class CountScorer(Scorer):
    def __init__(self, task: Task) -> None:
        self._number = len(task.relevant)

    def assess(self, text: str) -> Assessment:
        off_by = abs(int(text) - self._number) if text.strip().isdecimal() else None
        return Assessment(CountVerdict(right=off_by == 0, off_by=off_by), VerdictExplanation)


def pose(parts: DomainAndNotation, task: Task) -> QuestionAndAnswer:
    return f"How many objects does this task name: {task.title}?", str(len(task.relevant))


COUNTING = AbilityDeclaration(
    ability=Ability("counting"),
    interaction=SingleQuestionInteraction(lambda parts: CountScorer, pose),
    title="Counting",
    short_title="count",
    verdict=CountVerdict,
    contributions=lambda verdict: {"right": make_rate_contribution_of_answer(verdict.right)},
    outcome=lambda verdict: AnswerOutcome.SUCCESS if verdict.right else AnswerOutcome.GOAL_MISSED,
    columns=(MetricColumn("right", "Success", "Right"),),
    terminal_metrics=("right",),
    overview_headings={"right": "Right"},
    averaged_metrics=(),
    yes_no_metrics=frozenset({"right"}),
)
