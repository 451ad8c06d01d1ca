"""Extract and compare operators as eai-eval 1.0.5 (the paper's package) does.

Planning: the planner gets the gold operator for each required operator that the answer lacks, and all other
operators of the domain (``complete_pddl_domain``). Hallucinated operators take part in planning. The planner
is that of `planner_of_2024`.

Counting: operators that an answer lacks are not counted, and neither are predicates without a category. If a
predicate without a category matches, eai-eval raises a KeyError, and all results of the run are lost. Here
such a predicate is ignored.

Extraction of operators from answers: the code follows the first lines of ``worker_process`` in
``transition_modeling/scripts/evaluate_results.py`` and ``extract_action_details`` in
``simulation/evolving_graph/eval_utils.py``, both of ``virtualhome_eval``. Defects of the
extraction, in order of application:

* only a code fence at the very start counts;
* line ends are deleted before JSON is read, so a comment outside JSON swallows the rest;
* single quotes become double quotes;
* text that is not JSON is searched as it is;
* parameters, precondition and effect are looked for independently, so each may belong to a later operator;
* an operator that lacks one of these three ends the search;
* a name ends at the first character that is not a word character;
* an unbalanced condition or effect becomes the unreadable text ``(()``;
* if two operators have one name, the last counts.

Comparison reproduces ``virtualhome_eval/simulation/evolving_graph/logic_score.py``. It
differs from the paper's "maximum bipartite matching over clauses" (`eai.pddl.matching`) as follows:

* text_literals (``tokenize``): an atom is the text between parentheses, so variables need the gold names;
* joined_lists (``parse_pddl_expr``): an unknown head with literals inside becomes one literal, named by its
  first word;
* unreadable_is_free (``calculate_logic_score``): if the answer's text or the gold text does not parse,
  nothing of the pair counts, not even as a false negative;
* padding (``align_expressions``): the shorter of two and/or lists is padded with the literal ``()``;
* positional_renaming (``replace_in_tuple``): bound variables are renamed only at equal positions, and as
  substrings;
* shorter_list (``match_expressions``): a nested and/or matches in full if the shorter list is covered;
* fractions_are_zero (``match_expressions``): scores enter an integer matrix, so a list gives no partial
  credit;
* row_as_column (``match_expressions``): a predicted child also counts as additional if its row number
  is not the number of a matched column;
* sets (``identify_predicates``): a predicate counts once per list, and may be in all three lists.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from typing import ClassVar, TypeAlias

from eai.abilities.transition_modeling.extraction import ResultCache
from eai.abilities.transition_modeling.rules import (
    NOT_RUN,
    OperatorJudgement,
    OperatorScoringRules,
    ReplacedPart,
)
from eai.abilities.transition_modeling.verdict import OperatorComparisonStatus, OperatorReport
from eai.abilities.verdict import ErrorReport
from eai.extensions.reference.planner_of_2024 import make_task_imitating_planner_of_2024, read_operator
from eai.logic.matching import find_maximum_matching
from eai.pddl.check import PddlFinding
from eai.pddl.matching import ClauseComparison
from eai.pddl.model import OperatorText, PddlAction
from eai.pddl.planning import PlannerResult, PlanningTask, make_input_error_result
from eai.tasks.operator_task import TransitionTask
from eai.tasks.task import TaskExclusion
from eai.world.fault import FaultKind

_COMMENT = re.compile(r";.*$", re.MULTILINE)
_HEAD = re.compile(r"\(:action\s+(\w+)")
_FENCE = "```json"
_UNREADABLE = ErrorReport(
    FaultKind.PARSING, None, 'expected JSON with a text under "output", or operators (:action ...)'
)
_UNBALANCED = "(()"
_UNBALANCED_CLOSE = 1  # the offset that eai-eval assumes if no parenthesis closes the list


def extract_operators_like_published_code(answer: str) -> tuple[OperatorText, ...] | None:
    """Return the operators of an answer in order of first mention, or None for eai-eval's format error.

    An answer without any operator gives an empty result, not None.
    """
    content = _extract_text_with_operators(answer)
    if content is None:
        return None
    if ";" in content:
        content = _COMMENT.sub("", content)
    content = " ".join(content.split())
    operators: dict[str, OperatorText] = {}
    position = 0
    while head := _HEAD.search(content, position):
        positions = [content.find(key, head.end()) for key in (":parameters", ":precondition", ":effect")]
        if -1 in positions:
            break
        parameters, precondition, effect = (_extract_list(content, place) for place in positions)
        if parameters is None:
            return None
        name = head.group(1)
        operators[name] = OperatorText(name, parameters, precondition or _UNBALANCED, effect or _UNBALANCED)
        closing = _UNBALANCED_CLOSE if effect is None else effect.index(")") - 1
        position = positions[2] + closing + 1
    return tuple(operators.values())


def _extract_text_with_operators(answer: str) -> str | None:
    """Return the text of an answer in which eai-eval looks for operators.

    Return None if the answer is JSON that contains no such text.
    """
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


def _extract_list(content: str, position_of_key: int) -> str | None:
    """Return the first balanced list (text in parentheses) after a position, or None if it does not close.

    Without an opening parenthesis, eai-eval starts at the beginning of the whole text. If the list begins
    with ``((``, eai-eval does not count the second parenthesis, so the list ends one parenthesis too early.
    """
    start = content.find("(", position_of_key) + 1
    if content.startswith(")", start):
        return "()"
    depth, position = 1, start + 1
    while (closing := content.find(")", position)) >= 0:
        depth += content.count("(", position, closing) - 1
        position = closing + 1
        if not depth:
            return "(" + content[start:position]
    return None


FORMAT_ERROR = TaskExclusion("the reference leaves out answers that it cannot search for operators")
"""Reason for excluding a task from all statistics: eai-eval cannot look for operators in the task's answer.

No other reason for an exclusion depends on an answer.
"""


@dataclass(frozen=True, slots=True)
class EaiEvalOperatorScoringRules(OperatorScoringRules):
    """Scores operators as eai-eval (the paper's package) does. Comparisons of equal texts are cached."""

    counts_clauses: ClassVar[bool] = False
    reports: ResultCache[OperatorText, OperatorReport] = field(default_factory=ResultCache)
    read: ResultCache[OperatorText, PddlAction | PddlFinding | None] = field(default_factory=ResultCache)

    def judge_answer(self, task: TransitionTask, text: str) -> OperatorJudgement:
        """Return the judgement on an answer.

        If eai-eval cannot look for operators in the answer (its format error), the judgement excludes the
        task from all statistics.
        """
        written = extract_operators_like_published_code(text)
        if written is None:
            return OperatorJudgement((), NOT_RUN, error=_UNREADABLE, excluded=FORMAT_ERROR)
        return OperatorJudgement(
            operators=tuple(self._make_operator_report(task, operator) for operator in written),
            planning=self._plan_with_written_operators(task, written),
        )

    def judge_missing_answer(self, task: TransitionTask) -> OperatorJudgement:
        """Return the judgement on a missing answer: all required operators count as missing.

        No planner is run. If an answer lacks only some operators, the planner uses gold operators in
        their place.
        """
        gold = [task.domain.operators[name] for name in task.operators]
        missing = [
            _compare_operators(
                replace(operator, precondition="()", effect="()"), operator, OperatorComparisonStatus.MISSING
            )
            for operator in gold
        ]
        return OperatorJudgement(tuple(missing), self.result_for_answer_without_operators)

    def plan_with_each_operator_of_answer(
        self, task: TransitionTask, answer: str, replaced_part: ReplacedPart
    ) -> dict[str, PlannerResult | None]:
        """Return the planner's result for each operator that the task requires, by the operator's name.

        The planner gets this operator from the answer, and all other operators are gold operators. The result
        is None for a required operator that the answer lacks, which eai-eval counts as a failure. The mapping
        is empty for an answer with eai-eval's format error, because eai-eval skips such answers
        (``evaluate_results_sequential``). The count ``task_variate_control_precond`` of eai-eval is never
        filled.
        """
        written = extract_operators_like_published_code(answer)
        if written is None:
            return {}
        gold = task.domain.operators
        tried = {
            operator.name: _insert_written_part_into_gold_operator(
                operator, gold[operator.name], replaced_part
            )
            for operator in written
            if operator.name in gold
        }
        return {
            name: self._plan_with_written_operators(task, (tried[name],)) if name in tried else None
            for name in task.operators
        }

    def _make_operator_report(self, task: TransitionTask, operator: OperatorText) -> OperatorReport:
        if operator.name not in task.operators:
            return OperatorReport(operator.name, OperatorComparisonStatus.HALLUCINATED)
        gold = task.domain.operators[operator.name]
        return self.reports.get_or_compute(
            operator, operator.text_length, lambda: _compare_operators(operator, gold)
        )

    def _plan_with_written_operators(
        self, task: TransitionTask, written: tuple[OperatorText, ...]
    ) -> PlannerResult:
        if self.planner is None:
            return NOT_RUN
        names = {operator.name for operator in written}
        gold = (operator for name, operator in task.domain.operators.items() if name not in names)
        operators = tuple(sorted((*written, *gold), key=lambda operator: operator.name))
        key, size = (task.problem_text, operators), sum(operator.text_length for operator in written)
        return self.plan_with_cache(
            key, size, lambda: self._make_planning_task_or_input_error(task, operators)
        )

    def _make_planning_task_or_input_error(
        self, task: TransitionTask, operators: tuple[OperatorText, ...]
    ) -> PlanningTask | PlannerResult:
        actions = []
        for operator in operators:
            reading = self.read.get_or_compute(
                operator, operator.text_length, partial(read_operator, operator, task.domain.header)
            )
            if isinstance(reading, PddlFinding):
                return make_input_error_result(reading)
            if isinstance(reading, PddlAction):
                actions.append(reading)
        return make_task_imitating_planner_of_2024(task.domain.header, actions, task.problem)


def _compare_operators(
    written: OperatorText,
    gold: OperatorText,
    status: OperatorComparisonStatus = OperatorComparisonStatus.COMPARED,
) -> OperatorReport:
    precondition = compare_clauses_like_published_code(written.precondition, gold.precondition)
    return OperatorReport(
        gold.name, status, precondition, compare_clauses_like_published_code(written.effect, gold.effect)
    )


def _insert_written_part_into_gold_operator(
    written: OperatorText, gold: OperatorText, replaced_part: ReplacedPart
) -> OperatorText:
    match replaced_part:
        case "precondition":
            return replace(gold, precondition=written.precondition)
        case "effect":
            return replace(gold, effect=written.effect)
        case _:
            return written


_PADDING = "()"
_QUANTIFIERS = frozenset({"exists", "forall"})
_LISTS = frozenset({"and", "or"})
_ARITY = {"not": 1, "exists": 2, "forall": 2, "when": 2}
_TOKEN = re.compile(r"[()]|[^()\s][^()]*")


@dataclass(frozen=True, slots=True)
class _Connective:
    """A connective with its arguments. The first argument of a quantifier is the text of its variable."""

    head: str
    arguments: tuple[_ConditionTree, ...]


_ConditionTree: TypeAlias = "str | _Connective"


class _UnreadableError(Exception):
    """Raised for a text that eai-eval's parser cannot read."""


@dataclass(frozen=True, slots=True)
class _ConditionTreeComparison:
    """The score of two compared trees of conditions, and their matched, additional and missing subtrees."""

    score: float
    matched: tuple[_ConditionTree, ...] = ()
    additional: tuple[_ConditionTree, ...] = ()
    missing: tuple[_ConditionTree, ...] = ()


def compare_clauses_like_published_code(answer_text: str, gold_text: str) -> ClauseComparison:
    """Return the names of matched, additional and missing predicates of one condition or effect.

    Args:
        answer_text: the condition or effect of the answer, in parentheses.
        gold_text: the gold condition or effect.
    """
    try:
        result = _compare_trees(*_align_trees(_parse_tree(answer_text), _parse_tree(gold_text)))
    except _UnreadableError:
        return ClauseComparison()
    return ClauseComparison(
        _list_predicate_names(result.matched),
        _list_predicate_names(result.additional),
        _list_predicate_names(result.missing),
    )


def _parse_tree(text: str) -> _ConditionTree:
    stack: list[_ConditionTree] = []
    openings: list[int] = []
    for match in _TOKEN.finditer(text):
        word = match.group().strip()
        if word == "(":
            openings.append(len(stack))
        elif word != ")":
            stack.append(word)
        elif openings:
            start = openings.pop()
            stack[start:] = [_make_tree_of_parenthesized_list(stack[start:])]
        else:
            raise _UnreadableError
    if openings or len(stack) != 1:
        raise _UnreadableError
    return stack[0]


def _make_tree_of_parenthesized_list(parts: list[_ConditionTree]) -> _ConditionTree:
    """Return the syntax tree of the words and trees in a pair of parentheses.

    A list that begins with a connective, such as ``and``, becomes a node with this connective and its
    operands. Any other list of words becomes a text.
    """
    if not parts:
        return _PADDING
    head, *arguments = parts
    if isinstance(head, str) and (head in _LISTS or head in _ARITY):
        if head in _ARITY and len(arguments) != _ARITY[head]:
            raise _UnreadableError
        return _Connective(head, tuple(arguments))
    words = [part for part in parts if isinstance(part, str)]
    if len(words) != len(parts):
        raise _UnreadableError
    return " ".join(words)


def _align_trees(predicted: _ConditionTree, gold: _ConditionTree) -> tuple[_ConditionTree, _ConditionTree]:
    """Return both trees in a form in which eai-eval (the paper's package) can compare them node by node.

    If both trees begin with ``and`` or ``or``, the shorter list of operands is filled up with ``()``, and the
    operands are aligned pair by pair. If both trees begin with the same quantifier, the gold variable gets
    the name of the answer's variable. All other trees stay as they are.
    """
    if isinstance(predicted, str) or isinstance(gold, str):
        return predicted, gold
    if predicted.head == gold.head and predicted.head in _QUANTIFIERS:
        return predicted, _replace_text_in_tree(gold, _find_bound_name(gold), _find_bound_name(predicted))
    if predicted.head not in _LISTS or gold.head not in _LISTS:
        return predicted, gold
    size = max(len(predicted.arguments), len(gold.arguments))
    pairs = [
        _align_trees(*pair)
        for pair in zip(_pad_arguments(predicted, size), _pad_arguments(gold, size), strict=True)
    ]
    ours, theirs = tuple(pair[0] for pair in pairs), tuple(pair[1] for pair in pairs)
    return _Connective(predicted.head, ours), _Connective(gold.head, theirs)


def _pad_arguments(node: _Connective, size: int) -> tuple[_ConditionTree, ...]:
    return node.arguments + (_PADDING,) * (size - len(node.arguments))


def _find_bound_name(quantifier: _Connective) -> str:
    variable = quantifier.arguments[0]
    if not isinstance(variable, str):
        raise _UnreadableError
    return variable.split("-")[0].strip()


def _replace_text_in_tree(tree: _ConditionTree, old: str, new: str) -> _ConditionTree:
    if isinstance(tree, str):
        return tree.replace(old, new)
    arguments = tuple(_replace_text_in_tree(argument, old, new) for argument in tree.arguments)
    return _Connective(tree.head, arguments)


def _compare_trees(predicted: _ConditionTree, gold: _ConditionTree) -> _ConditionTreeComparison:
    if isinstance(predicted, str) or isinstance(gold, str):
        score = float(predicted == gold)
    elif predicted.head != gold.head:
        score = 0.0
    elif predicted.head in _LISTS:
        return _compare_operand_lists(predicted, gold)
    else:
        score = _score_connective(predicted, gold)
    if score > 0:
        return _ConditionTreeComparison(score, matched=(predicted,))
    return _ConditionTreeComparison(score, additional=(predicted,), missing=(gold,))


def _score_connective(predicted: _Connective, gold: _Connective) -> float:
    """Return the similarity (0 to 1) of two nodes that are both ``not``, ``when`` or the same quantifier."""
    match predicted.head:
        case "not":
            return _compare_trees(predicted.arguments[0], gold.arguments[0]).score
        case "when":
            parts = zip(predicted.arguments, gold.arguments, strict=True)
            return float(all(_compare_trees(*pair).score == 1 for pair in parts))
        case _:
            same_variable = predicted.arguments[0] == gold.arguments[0]
            return _compare_trees(predicted.arguments[1], gold.arguments[1]).score if same_variable else 0.0


def _compare_operand_lists(predicted: _Connective, gold: _Connective) -> _ConditionTreeComparison:
    grid = [[_compare_trees(ours, theirs) for theirs in gold.arguments] for ours in predicted.arguments]
    edges = [[column for column, cell in enumerate(row) if int(cell.score) == 1] for row in grid]
    partner = find_maximum_matching(edges)
    columns = {column for column in partner if column is not None}
    shorter = min(len(predicted.arguments), len(gold.arguments))
    additional = (
        child
        for row, child in enumerate(predicted.arguments)
        if partner[row] is None or row not in columns  # row_as_column
    )
    return _ConditionTreeComparison(
        score=len(columns) / shorter if shorter else 0.0,
        matched=tuple(
            part for row, cells in enumerate(grid) for column in edges[row] for part in cells[column].matched
        ),
        additional=tuple(additional),
        missing=tuple(child for column, child in enumerate(gold.arguments) if column not in columns),
    )


def _list_predicate_names(trees: Iterable[_ConditionTree]) -> tuple[str, ...]:
    return tuple(sorted({name for tree in trees for name in _find_predicates(tree)} - {_PADDING}))


def _find_predicates(tree: _ConditionTree) -> Iterator[str]:
    if isinstance(tree, str):
        yield tree.split(" ")[0]
        return
    for argument in tree.arguments[1:] if tree.head in _QUANTIFIERS else tree.arguments:
        yield from _find_predicates(argument)
