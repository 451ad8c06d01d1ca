"""Goal interpretation in VirtualHome: from an answer's text to counts.

Protocol `strict` mends these defects of eai-eval 1.0.5 (``goal_interpretation/scripts/evaluate_results.py``):

- An answer that cannot be read is skipped there; here it misses all goals of its task.
- A prediction about an object that does not exist counts nothing there, and one that lacks a field neither;
  here both are false positives, and both are reported.
- An action goal of the data set can be met by any number of predictions there, so that recall may exceed
  100 %; here it is met once, and an action that is predicted twice is one prediction.
- JSON is found in prose, behind reasoning and in any code fence.
- Objects of one class: answers have no ids, because the prompt shows none. There a name means one of the
  objects, chosen by the order of a hash table. Here goals are matched up to renaming: a goal said of a class
  matches a gold goal about any object of that class, said twice it matches two. Nothing more can be told
  apart in such an answer, and the data set's own goals, written with class names, score 100 %.
"""

from __future__ import annotations

from functools import partial

from eai.abilities.explanation import Explanation, goal_reports, repairs_told
from eai.abilities.goal_interpretation import virtualhome_answer
from eai.abilities.goal_interpretation.virtualhome_matching import ByLargestId, Matching, UpToRenaming
from eai.abilities.goal_interpretation.written import SECTIONS, Unreadable, WrittenGoals
from eai.abilities.protocol import Protocol
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.task import GoalKind, Task
from eai.abilities.verdict import Confusion, ErrorReport, Json, Verdict
from eai.benchmarks.reference import virtualhome_goals as virtualhome_reference
from eai.world.fault import FaultKind


class GoalInterpretation(Scorer):
    """The scorer of one task under one protocol.

    A verdict's details say how many goals the answer has (``predicted``), how many of them lack a field
    (``ill_formed``) and name what does not exist (``hallucinated``: those names), and whether the reference
    would abort its run (``aborts``).
    """

    def __init__(self, task: Task, protocol: Protocol) -> None:
        self.task = task
        self.protocol = protocol
        self._matching: Matching = UpToRenaming(task) if protocol is Protocol.STRICT else ByLargestId(task)

    def assess(self, text: str) -> Assessment:
        """The verdict on an answer, and which goals of the task it has, and what else it says."""
        goals = self.read(text)
        if isinstance(goals, Unreadable):
            return Assessment(self._unread(goals), partial(Explanation, (f"parsing: {goals.reason}",)))
        return Assessment(self._judge(goals), partial(self._explain, goals))

    def _unread(self, goals: Unreadable) -> Verdict:
        return Verdict(
            error=ErrorReport(FaultKind.PARSING, None, goals.reason),
            counts=_by_name(self._matching.unread()),
            details={"predicted": 0, "ill_formed": 0, "hallucinated": [], "aborts": goals.aborts},
        )

    def _judge(self, goals: WrittenGoals) -> Verdict:
        details: dict[str, Json] = {
            "predicted": goals.number,
            "ill_formed": sum(goals.ill_formed.values()),
            "hallucinated": self._matching.hallucinated(goals),
            "aborts": False,
        }
        return Verdict(counts=_by_name(self._matching.count(goals)), repairs=goals.repairs, details=details)

    def _explain(self, goals: WrittenGoals) -> Explanation:
        hallucinated = dict.fromkeys(self._matching.hallucinated(goals))
        return Explanation(
            notes=(
                *repairs_told(goals.repairs),
                *(f"ill-formed: {n} of the {SECTIONS[kind]}" for kind, n in goals.ill_formed.items() if n),
                *(f"hallucination: there is no {name}" for name in hallucinated),
                *(
                    f"{kind.value} goals: {c.true_positives} right, {c.false_positives} wrong"
                    for kind, c in self._matching.count(goals).items()
                ),
                *(f"wrong: {goal}" for goal in self._matching.wrong(goals)),
            ),
            goals=goal_reports(self.task.goals, self._matching.met(goals)),
        )

    def read(self, text: str) -> WrittenGoals | Unreadable:
        """The goals as written, or why there are none."""
        if self.protocol is Protocol.EAI_1_0_5:
            return virtualhome_reference.read_goals(text)
        return virtualhome_answer.read_goals(text)


def _by_name(counts: dict[GoalKind, Confusion]) -> dict[str, Confusion]:
    return {kind.value: confusion for kind, confusion in counts.items()}
