"""Transition modeling as a registered ability: how it is asked and counted, and its verdicts.

A verdict says operator by operator how an answer compares with the gold ones.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, NamedTuple

from eai.abilities.answer_schema import closed, text
from eai.abilities.declaration import (
    OVERALL,
    PLANNER,
    AbilityDeclaration,
    AnswerOutcome,
    AskedWorld,
    Form,
    MetricColumn,
    SingleTurn,
    counts_outcome,
    error_outcome,
    label_of,
    score_columns,
)
from eai.abilities.protocol import Ability
from eai.abilities.task import CATEGORIES, Category
from eai.abilities.verdict import (
    ALL,
    NOTHING,
    Confusion,
    Json,
    Merit,
    Share,
    Verdict,
    add,
    confusion_shares,
    merit_of_parts,
    of_all,
)
from eai.pddl.check import Offence, PddlFinding
from eai.pddl.matching import NO_MATCH, SideMatch, predicates_in
from eai.pddl.planning import PlannerOutcome
from eai.world.fault import FaultKind

if TYPE_CHECKING:
    from eai.abilities.operator_task import TransitionTask
    from eai.abilities.scorer import Scorer
    from eai.abilities.task import Task


class OperatorStatus(str, Enum):
    """The fate of one operator."""

    COMPARED = "compared"
    MISSING = "missing"
    """Asked for, and not in the answer."""
    UNREADABLE = "unreadable"
    """In the answer, but its text is not PDDL."""
    HALLUCINATED = "hallucinated"
    """In the answer, and not asked for."""


@dataclass(frozen=True, slots=True)
class OperatorReport:
    """One operator that is asked for or written.

    Attributes:
        precondition: clauses matched, additional and missing in the precondition; or predicates, if the
            rules count those.
        effect: the same for the effect.
        offences: what is wrong with it, whatever the gold operator.
    """

    name: str
    status: OperatorStatus
    precondition: SideMatch = NO_MATCH
    effect: SideMatch = NO_MATCH
    offences: tuple[PddlFinding, ...] = ()


OTHER = "other"
"""The category of predicates that the domain does not have."""


class ClauseContent(NamedTuple):
    """The subject of a clause.

    Attributes:
        predicates: those in it, by name.
        categories: those of its predicates, each once; `OTHER` of predicates that have none.
    """

    predicates: tuple[str, ...]
    categories: tuple[str, ...]


def clause_content(clause: str, categories: Mapping[str, Category]) -> ClauseContent:
    """The subject of a clause, which is written as PDDL or is a predicate's name."""
    names = sorted(predicates_in(clause))
    kinds = [categories[name].value if name in categories else OTHER for name in names]
    return ClauseContent(tuple(names), tuple(dict.fromkeys(kinds)))


@dataclass(frozen=True, slots=True)
class OperatorVerdict(Verdict):
    """The verdict on operators.

    Attributes:
        success: whether the plan that a planner finds with them works with the gold operators or, under rules
            that do not ask for that, whether it finds one; None if no planner was asked.
        counts: clauses matched, additional and missing, by side (precondition, effect) and category; or
            predicates, if the rules count those.
        literals: the same in literals, by side: partial credit for clauses of which a part is right; None if
            the rules do not give it.
        planner: what the planner made of them.
        plan_works: whether the planner found a plan that works with the gold operators; None if none was
            asked, or under rules that do not ask for that.
        task_categories: the task's own categories, the first the more telling one.
        operators: what comparing each operator with the gold one found out.
        plan: the steps of the plan that was found.
        planner_detail: what else the planner says.
        planner_name: which planner was asked, with its version; None if none was.
        clauses: what each clause of the operators' sides speaks of, by its text.
    """

    success: bool | None = None
    counts: Mapping[str, Mapping[str, Confusion]] | None = None
    literals: Mapping[str, Confusion] | None = None
    planner: PlannerOutcome | None = None
    plan_works: bool | None = None
    task_categories: tuple[str, ...] = ()
    operators: tuple[OperatorReport, ...] = ()
    plan: tuple[str, ...] = ()
    planner_detail: str = ""
    planner_name: str | None = None
    clauses: Mapping[str, ClauseContent] = field(default_factory=dict, compare=False)

    @property
    def columns(self) -> Mapping[str, Json]:
        """The outcome of planning with the operators, and the categories of the task."""
        planner = None if self.planner is None else self.planner.value
        return {"planner": planner, "task_categories": " ".join(self.task_categories)}

    @property
    def judge(self) -> str | None:
        """The planner."""
        return self.planner_name

    @property
    def left_to(self) -> str | None:
        """The outcome of the authority, where the built-in search did not decide."""
        _, then, authority = (self.planner_name or "").partition(", then ")
        decided = not then or not self.planner_detail.startswith(authority)
        return None if decided or self.planner is None else self.planner.value

    def merit(self, at_start: Sequence[bool]) -> Merit | None:
        """By F1 of all clauses of both sides."""
        return merit_of_parts(_overall(_by_category(self)), self.error, self._faults())

    def _faults(self) -> Counter[FaultKind]:
        """Operators that cannot be read or were not asked for, and what is wrong with the others."""
        faults = Counter([_STATUS_FAULTS[r.status] for r in self.operators if r.status in _STATUS_FAULTS])
        for report in self.operators:
            if report.status is OperatorStatus.COMPARED:
                faults.update([_OFFENCE_FAULTS.get(f.offence, FaultKind.PARSING) for f in report.offences])
        return faults


_STATUS_FAULTS = {
    OperatorStatus.UNREADABLE: FaultKind.PARSING,
    OperatorStatus.HALLUCINATED: FaultKind.HALLUCINATION,
}
_OFFENCE_FAULTS = {
    Offence.UNKNOWN_PREDICATE: FaultKind.HALLUCINATION,
    Offence.UNKNOWN_TYPE: FaultKind.HALLUCINATION,
    Offence.UNBOUND_VARIABLE: FaultKind.HALLUCINATION,
    Offence.UNDECLARED_CONSTANT: FaultKind.HALLUCINATION,
    Offence.WRONG_ARITY: FaultKind.ARGUMENT_NUMBER,
    Offence.WRONG_ARGUMENT_TYPE: FaultKind.AFFORDANCE,
}
"""The kind of an operator's offence in the taxonomy of plans; any other is one of writing."""


LITERALS = "literals"
"""The prefix of the rates over all literals: partial credit for clauses of which a part is right."""

WORKS = "Plan works"
"""The heading of the rate of plans that work with the data set's operators."""

_PARTS = (*CATEGORIES, OVERALL)
_PLANNER_SUCCESS = f"{OVERALL}.planner_success"
_PLAN_WORKS = f"{OVERALL}.plan_works"
_NONE = Confusion(0, 0, 0)


def contributions(verdict: OperatorVerdict) -> dict[str, Share]:
    """The contributions of one answer to each rate.

    Counts are of preconditions and effects together, and overall and in literals of all categories. A task's
    planner outcome counts in each of the task's categories and once overall; one that no planner ran on
    counts in neither. Whether the plan works counts where that is known.
    """
    counts = _by_category(verdict)
    planned = verdict.planner not in (None, PlannerOutcome.NOT_RUN)
    solved = of_all(verdict.planner is PlannerOutcome.SOLVED)
    shares: dict[str, Share] = {}
    for name in CATEGORIES:
        shares |= confusion_shares(name, counts.get(name, _NONE))
        counts_here = planned and name in verdict.task_categories
        shares[f"{name}.planner_success"] = solved if counts_here else NOTHING
    shares |= confusion_shares(OVERALL, _overall(counts))
    shares |= confusion_shares(LITERALS, add((verdict.literals or {}).values()))
    shares[_PLANNER_SUCCESS] = solved if planned else NOTHING
    shares[_PLAN_WORKS] = NOTHING if verdict.plan_works is None else of_all(verdict.plan_works)
    return shares


def outcome(verdict: OperatorVerdict) -> AnswerOutcome:
    """The outcome of an answer: where a planner was asked, right operators alone are no success."""
    if verdict.success:
        return AnswerOutcome.SUCCESS
    unplanned = verdict.planner in (None, PlannerOutcome.NOT_RUN)
    return error_outcome(verdict) or counts_outcome(_overall(_by_category(verdict)), enough=unplanned)


_PLANNED = (*(f"{name}.planner_success" for name in CATEGORIES), _PLANNER_SUCCESS, _PLAN_WORKS)


def void(verdict: OperatorVerdict) -> Sequence[str]:
    """A run in which the planner was left out has no planner success.

    Some of its answers are known to be unsolvable without planning; they do not count either.
    """
    return _PLANNED if verdict.planner is PlannerOutcome.NOT_RUN else ()


def _by_category(verdict: OperatorVerdict) -> dict[str, Confusion]:
    """The counts of both sides by category, all that are there."""
    found: dict[str, Confusion] = {}
    for side in (verdict.counts or {}).values():
        for name, confusion in side.items():
            found[name] = add((found.get(name, _NONE), confusion))
    return found


def _overall(counts: Mapping[str, Confusion]) -> Confusion:
    """The counts of both sides over all categories; a clause that is of several counts once."""
    return counts.get(ALL) or add(counts.values())


def _scorers(world: AskedWorld) -> Callable[[TransitionTask], Scorer]:
    """The maker of scorers, imported where needed, so that scoring plans loads no planner of operators."""
    from eai.abilities.transition_modeling.rules import PaperRules
    from eai.abilities.transition_modeling.scorer import TransitionModeling

    rules = PaperRules(world.make_planner())
    return lambda task: TransitionModeling(task, rules)


def _form(world: AskedWorld, task: Task | None) -> tuple[Sequence[str], Form]:
    return (), lambda words: closed({"output": text()})


TRANSITION_MODELING = AbilityDeclaration(
    ability=Ability.TRANSITION_MODELING,
    asked=SingleTurn(_scorers, form=_form, of_operators=True, bare="(:action"),
    title="Transition modeling",
    short="operators",
    verdict=OperatorVerdict,
    contributions=contributions,
    outcome=outcome,
    columns=(
        *score_columns((*_PARTS, LITERALS)),
        *(MetricColumn(f"{part}.planner_success", PLANNER, label_of(part)) for part in _PARTS),
        MetricColumn(_PLAN_WORKS, PLANNER, WORKS),
    ),
    terminal=(
        *(f"{part}.{measure}" for part in _PARTS for measure in ("f1", "planner_success")),
        _PLAN_WORKS,
        f"{LITERALS}.f1",
    ),
    main={f"{OVERALL}.f1": "F1", _PLAN_WORKS: WORKS, _PLANNER_SUCCESS: PLANNER},
    averaged=(f"{OVERALL}.f1", _PLANNER_SUCCESS),
    instead={_PLANNER_SUCCESS: _PLAN_WORKS},
    yes_no=frozenset({_PLANNER_SUCCESS, _PLAN_WORKS}),
    void=void,
)
