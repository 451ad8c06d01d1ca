"""The rules of eai-eval 1.0.5 for operators, and how it cuts them out of an answer.

Besides the quirks of `operator_matching`: operators that are asked for and not written are neither counted
nor missed by the planner, which gets the gold ones in their place and all other operators of the domain
besides (``complete_pddl_domain``); hallucinated operators take part in planning; predicates without a
category are not counted; the planner is that of `planner_of_2024`. Where the reference would raise a KeyError
and lose the run (a matched predicate without a category), the predicate is ignored.

Extraction reproduces the first lines of ``worker_process`` in
``transition_modeling/scripts/evaluate_results.py`` and ``extract_action_details`` in
``simulation/evolving_graph/eval_utils.py``, both of ``virtualhome_eval``. The quirks, in the order in which
they act: a code fence counts only at the very start; line ends are deleted before JSON is read, so that a
comment outside JSON swallows the rest; single quotes become double ones; JSON that does not load is searched
as it is; the three parts of an operator are looked for independently and may belong to a later one; an
operator without one of them ends the search; the name ends at the first character that is not a word
character; an unbalanced condition or effect becomes the unreadable text ``(()``; of two operators of one name
the last wins.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, field, replace
from functools import partial
from typing import ClassVar

from eai.abilities.transition_modeling.declaration import OperatorReport, OperatorStatus
from eai.abilities.transition_modeling.extraction import Memory
from eai.abilities.transition_modeling.rules import NOT_RUN, UNREADABLE, Judgement, Replaced, Rules
from eai.abilities.transition_modeling.task import TransitionTask
from eai.pddl.check import PddlFinding
from eai.pddl.matching import SideMatch
from eai.pddl.model import OperatorText, PddlAction
from eai.pddl.planning import PlannerResult, PlanningTask, refusal
from eai.reference.operator_matching import compare_as_reference
from eai.reference.planner_of_2024 import Dropped, normalise, read_operator

_COMMENT = re.compile(r";.*$", re.MULTILINE)
_HEAD = re.compile(r"\(:action\s+(\w+)")
_FENCE = "```json"
_UNBALANCED = "(()"
_UNBALANCED_CLOSE = 1  # Where the first closing parenthesis of an unbalanced effect is taken to be.


def extract_as_reference(answer: str) -> tuple[OperatorText, ...] | None:
    """The operators of an answer in order of first mention, or None for the reference's format error.

    An answer without any operator is no format error but an empty result.
    """
    content = _payload(answer)
    if content is None:
        return None
    if ";" in content:
        content = _COMMENT.sub("", content)
    content = " ".join(content.split())
    found: dict[str, OperatorText] = {}
    position = 0
    while head := _HEAD.search(content, position):
        places = [content.find(key, head.end()) for key in (":parameters", ":precondition", ":effect")]
        if -1 in places:
            break
        parameters, precondition, effect = (_block(content, place) for place in places)
        if parameters is None:
            return None
        name = head.group(1)
        found[name] = OperatorText(name, parameters, precondition or _UNBALANCED, effect or _UNBALANCED)
        closing = _UNBALANCED_CLOSE if effect is None else effect.index(")") - 1
        position = places[2] + closing + 1
    return tuple(found.values())


def _payload(answer: str) -> str | None:
    """The text to search, or None if the answer is JSON that holds no text."""
    if answer.startswith(_FENCE):
        answer = answer[len(_FENCE) :].strip("`")
    text = answer.strip().replace("\n", "").replace("'", '"')
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        return text
    if isinstance(value, dict) and "output" in value:
        value = value["output"]
    return value if isinstance(value, str) else None


def _block(content: str, place: int) -> str | None:
    """The balanced list that opens behind a place, or None if it does not close.

    Without any opening parenthesis the reference starts at the first character of the whole text; the
    character behind the opening parenthesis is not counted as a parenthesis unless it closes at once.
    """
    start = content.find("(", place) + 1
    if content.startswith(")", start):
        return "()"
    depth, position = 1, start + 1
    while (closing := content.find(")", position)) >= 0:
        depth += content.count("(", position, closing) - 1
        position = closing + 1
        if not depth:
            return "(" + content[start:position]
    return None


FORMAT_ERROR = "the reference leaves out answers that it cannot search for operators"


@dataclass(frozen=True, slots=True)
class ReferenceRules(Rules):
    """The rules with what they remember about one domain: equal texts are compared and read once."""

    counts_clauses: ClassVar[bool] = False
    reports: Memory[OperatorText, OperatorReport] = field(default_factory=Memory)
    read: Memory[OperatorText, PddlAction | Dropped | PddlFinding] = field(default_factory=Memory)

    def judge(self, task: TransitionTask, text: str) -> Judgement:
        """The judgement on an answer; the reference leaves out those with its format error."""
        written = extract_as_reference(text)
        if written is None:
            return Judgement((), NOT_RUN, error=UNREADABLE, excluded=FORMAT_ERROR)
        return Judgement(
            operators=tuple(self._report(task, operator) for operator in written),
            planning=self._plan(task, written),
        )

    def unanswered(self, task: TransitionTask) -> Judgement:
        """All that is asked for is missing: gold operators fill the gaps of an answer, they are none."""
        return Judgement(tuple(self._missing(task, name) for name in task.operators), self.without_operators)

    def _missing(self, task: TransitionTask, name: str) -> OperatorReport:
        gold = task.domain.operators[name]
        precondition, effect = _compare("()", gold.precondition), _compare("()", gold.effect)
        return OperatorReport(name, OperatorStatus.MISSING, precondition, effect)

    def plan_one_at_a_time(
        self, task: TransitionTask, text: str, replaced: Replaced
    ) -> dict[str, PlannerResult | None]:
        """What comes of each operator that is asked for, among all gold operators.

        The reference counts one that is not written as a failure, and passes over answers with its format
        error (``evaluate_results_sequential``); it counts, but never fills, ``task_variate_control_precond``.
        """
        written = extract_as_reference(text)
        if written is None:
            return {}
        gold = task.domain.operators
        tried = {each.name: _mixed(each, gold[each.name], replaced) for each in written if each.name in gold}
        return {name: self._plan(task, (tried[name],)) if name in tried else None for name in task.operators}

    def _report(self, task: TransitionTask, operator: OperatorText) -> OperatorReport:
        if operator.name not in task.operators:
            return OperatorReport(operator.name, OperatorStatus.HALLUCINATED)
        gold = task.domain.operators[operator.name]
        return self.reports.recall(operator, operator.size, lambda: _compared(operator, gold))

    def _plan(self, task: TransitionTask, written: tuple[OperatorText, ...]) -> PlannerResult:
        if self.planner is None:
            return NOT_RUN
        names = {operator.name for operator in written}
        gold = (operator for name, operator in task.domain.operators.items() if name not in names)
        operators = tuple(sorted((*written, *gold), key=lambda operator: operator.name))
        key, size = (task.problem_text, operators), sum(operator.size for operator in written)
        return self.solve(key, size, lambda: self._planning(task, operators))

    def _planning(
        self, task: TransitionTask, operators: tuple[OperatorText, ...]
    ) -> PlanningTask | PlannerResult:
        actions = []
        for operator in operators:
            reading = self.read.recall(
                operator, operator.size, partial(read_operator, operator, task.domain.header)
            )
            if isinstance(reading, PddlFinding):
                return refusal(reading)
            if isinstance(reading, PddlAction):
                actions.append(reading)
        return normalise(task.domain.header, actions, task.problem)


def _compared(operator: OperatorText, gold: OperatorText) -> OperatorReport:
    return OperatorReport(
        operator.name,
        OperatorStatus.COMPARED,
        _compare(operator.precondition, gold.precondition),
        _compare(operator.effect, gold.effect),
    )


def _mixed(written: OperatorText, gold: OperatorText, replaced: Replaced) -> OperatorText:
    match replaced:
        case Replaced.PRECONDITION:
            return replace(gold, precondition=written.precondition)
        case Replaced.EFFECT:
            return replace(gold, effect=written.effect)
        case _:
            return written


def _compare(predicted: str, gold: str) -> SideMatch:
    sets = compare_as_reference(predicted, gold)
    return SideMatch(*(tuple(sorted(names)) for names in (sets.matched, sets.additional, sets.missing)))
