"""Translate the subgoals of an answer into a program. A search then explores all executions of the program.

A subgoal is a formula. If a part of the formula is about a single state, actions first make this part true,
and then a test follows. All disjuncts are tried: each operand of an ``or``, each object of an ``exists``. A
``forall`` requires all objects of its class. The name of a class stands for any of the task's objects of that
class. An action in the formula is executed.

A short formula can require millions of literals, because quantifiers and disjuncts multiply. So literals are
counted before a formula is expanded. A subgoal with too many literals is rejected. The limit is the same on
every machine.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from itertools import product
from math import prod
from typing import NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.abilities.notation.subgoals import WrittenSubgoals
from eai.abilities.subgoal_decomposition.program import (
    MAX_ACTIONS_PER_SUBGOAL,
    CheckSubgoalHoldsInstruction,
    CompiledSubgoalAnswer,
    ExecuteSubgoalPlansInstruction,
    Instruction,
    MisusedName,
    RejectedAnswer,
    SubgoalForkInstruction,
    SubgoalPlanner,
    SubgoalPlanningResult,
    SubgoalProgram,
    reject_misused_names,
    reject_unparseable,
)
from eai.abilities.subgoal_decomposition.refinement import SubgoalRefiner
from eai.abilities.subgoal_decomposition.repertoire import Holds
from eai.abilities.verdict import Unreadable
from eai.base.errors import InputError, ParseError
from eai.logic.ltl import read_formula
from eai.logic.ltl_printer import format_ltl
from eai.logic.rewriting import push_negations_inwards, substitute_terms
from eai.logic.traversal import get_subformulas, is_state_formula, walk_subformulas, wrap_in_quantifiers
from eai.planning.subgoal import GroundAtom
from eai.tasks.goal_test import StateTest
from eai.tasks.lexicon import FormulaNameLexicon
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.fault import FaultKind
from eai.world.operator import Check
from eai.world.relation import iterate_bits
from eai.world.state import State

MAX_LITERALS = 100_000
"""Maximum number of literals in a subgoal; the literals in a quantifier count once for each object.

Two numbers may not exceed it: the literals that one test of the subgoal evaluates, and the literals in all
disjuncts of the subgoal together.
"""

_InstructionNumber: TypeAlias = int
"""Position of an instruction in the program that is compiled from the subgoals of an answer, from 0."""

TOO_MUCH = f"the answer expands to more than {MAX_LITERALS:,} literals"


class _QuantifierRange:
    """Finds the objects over which quantifiers in subgoals range, and refuses formulas with many literals.

    Args:
        task: the task.
    """

    def __init__(self, task: Task) -> None:
        self._scene = task.scene
        self._relevant = task.relevant

    def list_values_of_variable(self, variable: f.Variable) -> Sequence[int]:
        """Return all objects of a variable's class, as values of a ``forall`` variable."""
        return tuple(iterate_bits(self._scene.get_category_mask(variable.category)))

    def list_relevant_objects(self, variable: f.Variable) -> Sequence[int]:
        """Return the task's objects of a variable's class, as values of an ``exists`` variable.

        If no object of the class matters to the task, return all objects of the class in the scene.
        """
        mask = self._scene.get_category_mask(variable.category)
        return [i for i in self._relevant if mask >> i & 1] or tuple(iterate_bits(mask))

    def count_literals(self, formula: f.Formula) -> int:
        """Return the maximum number of literals that a test of a formula evaluates.

        A quantifier counts its formula once for each object of its class. A class without objects counts as
        one object, so that the literals inside the quantifier and around it still count.

        Raises:
            InputError: there are more than `MAX_LITERALS` literals.
        """
        match formula:
            case f.Exists(variable, body) | f.ForAll(variable, body) | f.Exactly(_, variable, body):
                number = self._count_objects(variable) * self.count_literals(body)
            case f.ForPairs(first, second, body):
                number = self._count_objects(first) * self._count_objects(second) * self.count_literals(body)
            case _:
                number = sum(map(self.count_literals, get_subformulas(formula))) or 1
        return _require_count_within_literal_limit(number)

    def _count_objects(self, variable: f.Variable) -> int:
        return max(1, self._scene.get_category_mask(variable.category).bit_count())

    def require_dnf_within_literal_limit(self, formula: f.Formula) -> None:
        """Check that all disjuncts of a formula together have at most `MAX_LITERALS` literals.

        The number is bounded by the number of disjuncts times the number of literals in the longest disjunct.
        Negations stand only before atoms in this formula (negation normal form). A disjunct without literals
        counts as one literal: for example, a ``forall`` over a class without objects.

        Raises:
            InputError: the bound is above `MAX_LITERALS`, or one test of the formula may evaluate more than
                `MAX_LITERALS` literals (`count_literals`).
        """
        self.count_literals(formula)
        _require_count_within_literal_limit(
            self._count_disjuncts(formula) * max(1, self._count_literals_of_longest_disjunct(formula))
        )

    def _count_disjuncts(self, formula: f.Formula) -> int:
        """Return the number of disjuncts of a formula, but at most `MAX_LITERALS` plus one."""
        match formula:
            case f.And(parts):
                choices = prod(map(self._count_disjuncts, parts))
            case f.Or(parts):
                choices = sum(map(self._count_disjuncts, parts))
            case f.Exists(variable, body):
                choices = len(self.list_relevant_objects(variable)) * self._count_disjuncts(body)
            case f.ForAll(variable, body):
                choices = self._count_disjuncts(body) ** len(self.list_values_of_variable(variable))
            case _:
                choices = 1
        return min(choices, MAX_LITERALS + 1)

    def _count_literals_of_longest_disjunct(self, formula: f.Formula) -> int:
        match formula:
            case f.And(parts):
                return sum(map(self._count_literals_of_longest_disjunct, parts))
            case f.Or(parts):
                return max(map(self._count_literals_of_longest_disjunct, parts), default=0)
            case f.Exists(_, body):
                return self._count_literals_of_longest_disjunct(body)
            case f.ForAll(variable, body):
                return len(self.list_values_of_variable(variable)) * self._count_literals_of_longest_disjunct(
                    body
                )
            case _:
                return 1


def _require_count_within_literal_limit(literal_count: int) -> int:
    if literal_count > MAX_LITERALS:
        raise InputError(TOO_MUCH)
    return literal_count


MAX_INSTRUCTIONS = 20_000
"""Maximum number of instructions of a `SubgoalProgram`, compiled from the subgoals of an answer.

A name that may mean several objects adds instructions for each object.
"""

_LITERALS_PER_ACTION = 100
"""Number of literals whose tests count as one applied action in the effort of a search."""

_MAX_EXCLUSION_LITERALS = 100
"""Maximum number of literals in a subgoal that is tested for contradictions between its literals."""

_MAX_CACHED_SUBGOALS = 32
"""Maximum number of subgoals of a task whose conditions and plans are cached."""

_MAX_CACHED_STATES = 16
"""Maximum number of states for which the plans of a subgoal are cached, over all branches of a search."""


class _UnmetSubgoalReason(NamedTuple):
    """The reason why a subgoal does not hold, as the id of a failed check and as a text."""

    id: str
    words: str


_BY_NOTHING = _UnmetSubgoalReason("no_action_brings_it_about", "no action brings it about")
_EXCLUDED = _UnmetSubgoalReason("parts_exclude_each_other", "its parts exclude each other")
_NOT_DONE = _UnmetSubgoalReason("not_brought_about", "nothing that is done for it brings it about")


@dataclass(frozen=True, slots=True, eq=False)
class _StateRequirement:
    """A condition that must hold after a subgoal.

    Requirements are compared by identity, because computing a hash of a requirement with many disjuncts takes
    long.

    Attributes:
        holds: tests the condition in a state.
        check: the check that fails if the condition does not hold.
        effort: cost of the test, as a number of applied actions of equal cost.
        refused: returns a check that says why no state can meet the condition, or None if a state may meet
            it.
    """

    holds: Holds
    check: Check
    effort: int
    refused: Callable[[], Check | None]


class SubgoalProgramCompiler:
    """Makes the programs that execute the subgoals in answers to one task.

    The conditions and plans of the last `_MAX_CACHED_SUBGOALS` subgoals are cached, because answers to one
    task often begin with the same subgoals. The plans of a subgoal do not depend on the rest of the answer.
    For each subgoal, they are cached for the last `_MAX_CACHED_STATES` states.

    Args:
        task: the task.
        lexicon: the vocabulary of subgoals.
        refinement: finds the actions that achieve subgoals.
        distinguished: operators whose use matters to the goal.
    """

    def __init__(
        self,
        task: Task,
        lexicon: FormulaNameLexicon,
        refinement: SubgoalRefiner,
        distinguished: Collection[str],
    ) -> None:
        self.task = task
        self.lexicon = lexicon
        self._refinement = refinement
        self._distinguished = distinguished
        self.extent = _QuantifierRange(task)
        self.brings_about = refinement.can_bring_about
        self._exclusion = cache(
            lambda: refinement.exclusion_rules().make_mutual_exclusion_prover(task.initial)
        )
        self.required = lru_cache(_MAX_CACHED_SUBGOALS)(self._make_state_requirement)
        self.needless = lru_cache(_MAX_CACHED_SUBGOALS)(self._make_needless_step_planner_for_true_subgoal)
        self.plans = lru_cache(_MAX_CACHED_SUBGOALS)(self._make_planner)
        self.make_planner_for_action_subgoal = lru_cache(_MAX_CACHED_SUBGOALS)(
            self._make_planner_for_action_subgoal
        )

    def compile_subgoals(
        self, written: WrittenSubgoals | Unreadable
    ) -> CompiledSubgoalAnswer | RejectedAnswer:
        """Return an answer's subgoals as instructions for the search for actions, or the answer's rejection.

        Each subgoal is parsed separately.
        """
        if isinstance(written, Unreadable):
            return replace(reject_unparseable(written.reason), spans=written.spans)
        return replace(self._compile_written_subgoals(written), spans=written.spans)

    def _compile_written_subgoals(self, written: WrittenSubgoals) -> CompiledSubgoalAnswer | RejectedAnswer:
        formulas: list[f.Formula] = []
        offences: list[MisusedName] = []
        for number, subgoal in enumerate(written.subgoals):
            try:
                formula, misuses = read_formula(subgoal, self.lexicon.signature)
            except ParseError as error:
                return reject_unparseable(str(error), written.repairs, number)
            formulas.append(formula)
            offences += [(number, misuse) for misuse in misuses]
        if offences:
            return reject_misused_names(offences, written.repairs)
        try:
            return CompiledSubgoalAnswer(
                tuple(formulas), self.make_subgoal_program(formulas), written.repairs
            )
        except InputError as error:
            return reject_unparseable(str(error), written.repairs)

    def make_subgoal_program(self, subgoals: Sequence[f.Formula]) -> SubgoalProgram:
        """Return the program that executes subgoals one after the other.

        Raises:
            InputError: a subgoal has too many literals, or does not combine states and actions in a way that
                can be executed.
        """
        builder = _SubgoalProgramBuilder(self)
        start = 0
        for number in reversed(range(len(subgoals))):
            start = builder.add_instructions_for_formula(
                push_negations_inwards(builder.replace_class_names_by_variables(subgoals[number])),
                number,
                start,
            )
        return builder.program[: start + 1]

    def _make_planner_for_action_subgoal(self, action: Action) -> SubgoalPlanner:
        plans = self._refinement.make_planner_for_action_subgoal(action, self.task.scene, self.task.relevant)
        return lru_cache(_MAX_CACHED_STATES)(plans)

    def _make_state_requirement(
        self,
        formula: f.Formula,
        failure_reason: _UnmetSubgoalReason,
        disjuncts: tuple[tuple[GroundAtom, ...], ...] = (),
    ) -> _StateRequirement:
        if self.lexicon.has_unknown_names(formula):
            raise _make_not_executable_error(formula)
        meaning = self.lexicon.replace_lexicon_names_by_domain_names(formula)

        def make_check_for_unmet_subgoal(reason: _UnmetSubgoalReason) -> Check:
            words = f"{format_ltl(formula)} does not hold, and {reason.words}"
            return Check(meaning, FaultKind.MISSING_STEP, words, id=reason.id)

        def make_check_if_subgoal_is_contradictory() -> Check | None:
            sizes = [*map(len, disjuncts)]
            if min(sizes, default=0) < 2 or sum(sizes) > _MAX_EXCLUSION_LITERALS:
                return None
            if all(map(self._exclusion().are_exclusive, disjuncts)):
                return make_check_for_unmet_subgoal(_EXCLUDED)
            return None

        effort = self.extent.count_literals(formula) // _LITERALS_PER_ACTION
        return _StateRequirement(
            StateTest(meaning, self.task.scene),
            make_check_for_unmet_subgoal(failure_reason),
            effort,
            cache(make_check_if_subgoal_is_contradictory),
        )

    def _make_needless_step_planner_for_true_subgoal(
        self, disjuncts: tuple[tuple[GroundAtom, ...], ...]
    ) -> SubgoalPlanner:
        """Return a planner for a subgoal that holds already and so is needless.

        The planner returns actions whose effects are literals of the subgoal. These effects hold already, so
        each action fails as an additional (needless) step, which is reported. If several disjuncts of the
        subgoal hold, the planner takes the disjunct with the fewest actions.
        """
        effort = sum(map(len, disjuncts)) // _LITERALS_PER_ACTION

        def find_plans(state: State) -> SubgoalPlanningResult:
            held = [
                self._refinement.find_needless_actions_for_true_literals(alternative, state)
                for alternative in disjuncts
            ]
            fewest = min([plan for plan in held if plan is not None], key=len, default=())
            return SubgoalPlanningResult((fewest,) if fewest else (), effort)

        return lru_cache(_MAX_CACHED_STATES)(find_plans)

    def _make_planner(self, literals: tuple[GroundAtom, ...], required: _StateRequirement) -> SubgoalPlanner:
        """Return a planner whose plans make literals true and end in a state that meets a requirement.

        If no state can meet the requirement, the planner returns no plan.
        """
        made = cache(
            lambda: self._refinement.make_planner_for_literals(
                literals,
                required.holds,
                self.task.scene,
                self.task.relevant,
                self._distinguished,
                test_effort=required.effort,
            )
        )

        def find_plans(state: State) -> SubgoalPlanningResult:
            result = made()(state)
            refused = required.refused() if result.has_failed else None
            return result if refused is None else SubgoalPlanningResult((), result.effort, refused)

        return lru_cache(_MAX_CACHED_STATES)(find_plans)


class _SubgoalProgramBuilder:
    """Builds the instructions of a program from its end to its beginning."""

    def __init__(self, programs: SubgoalProgramCompiler) -> None:
        self.program: list[Instruction] = [None]
        self._programs = programs
        self._lexicon = programs.lexicon
        self._extent = programs.extent

    def replace_class_names_by_variables(self, subgoal: f.Formula) -> f.Formula:
        """Return a subgoal in which variables for objects of a class replace the names of classes."""
        names = dict.fromkeys(
            term
            for part in walk_subformulas(subgoal)
            if isinstance(part, (f.Atom, f.Occurs))
            for term in part.arguments
            if isinstance(term, f.Constant) and self._lexicon.is_class_name(term.name)
        )
        if not names:
            return subgoal
        subgoal = substitute_terms(subgoal, {name: f.Variable(name.name) for name in names})
        return wrap_in_quantifiers(
            f.Exists, [f.Variable(class_name.name, class_name.name) for class_name in names], subgoal
        )

    def add_instructions_for_formula(
        self, formula: f.Formula, subgoal: int, next_instruction: _InstructionNumber
    ) -> _InstructionNumber:
        """Add the instructions that execute a part of a subgoal. Return the first instruction's number.

        Negations may stand only before atoms in the formula.

        Args:
            formula: the part.
            subgoal: number of the subgoal, from 0.
            next_instruction: number of the instruction that runs after these instructions.
        """
        if _is_about_single_state(formula):
            return self._add_instructions_for_condition(formula, subgoal, next_instruction)
        match formula:
            case f.Occurs():
                action = self._lexicon.to_action(formula)
                return self._add_instruction(
                    ExecuteSubgoalPlansInstruction(
                        self._programs.make_planner_for_action_subgoal(action),
                        subgoal,
                        next_instruction,
                        MAX_ACTIONS_PER_SUBGOAL,
                    )
                )
            case f.Then(parts):
                for part in reversed(parts):
                    next_instruction = self.add_instructions_for_formula(part, subgoal, next_instruction)
                return next_instruction
            case f.And(parts):
                return self._add_instructions_for_conjunction(parts, subgoal, next_instruction)
            case f.Or(parts):
                return self._add_instructions_for_alternatives(parts, subgoal, next_instruction)
            case f.Exists(variable, body):
                instances = self._replace_variable_by_each_object(
                    variable, body, self._extent.list_relevant_objects(variable)
                )
                return self._add_instructions_for_alternatives(list(instances), subgoal, next_instruction)
            case _:
                raise _make_not_executable_error(formula)

    def _add_instructions_for_conjunction(
        self, parts: Sequence[f.Formula], subgoal: int, next_instruction: _InstructionNumber
    ) -> _InstructionNumber:
        """Add instructions that execute the actions of a conjunction, and meet its conditions at the end.

        The search may add actions that make the conditions true. The program tries two orders: the added
        actions come before the actions of the conjunction, or after them.
        """
        states = [part for part in parts if _is_about_single_state(part)]
        actions = f.Then(tuple(dict.fromkeys(part for part in parts if part not in states)))
        if not states:
            return self.add_instructions_for_formula(actions, subgoal, next_instruction)
        held = f.And(tuple(states))
        tested = self._add_instruction(
            _make_instruction_that_checks_condition(
                self._programs.required(held, _NOT_DONE), subgoal, next_instruction
            )
        )
        before = self._add_instructions_for_condition(
            held, subgoal, self.add_instructions_for_formula(actions, subgoal, tested), is_whole_subgoal=False
        )
        after = self.add_instructions_for_formula(
            actions,
            subgoal,
            self._add_instructions_for_condition(held, subgoal, next_instruction, is_whole_subgoal=False),
        )
        return self._add_fork_instruction([before, after], subgoal)

    def _add_instructions_for_alternatives(
        self, alternatives: Sequence[f.Formula], subgoal: int, next_instruction: _InstructionNumber
    ) -> _InstructionNumber:
        return self._add_fork_instruction(
            [
                self.add_instructions_for_formula(part, subgoal, next_instruction)
                for part in reversed(alternatives)
            ],
            subgoal,
        )

    def _add_instructions_for_condition(
        self,
        formula: f.Formula,
        subgoal: int,
        next_instruction: _InstructionNumber,
        *,
        is_whole_subgoal: bool = True,
    ) -> _InstructionNumber:
        """Add instructions that make one disjunct of a condition true, and then test the condition.

        The condition is about one state. If it holds already, no actions are needed; if it is also the
        complete subgoal (``is_whole_subgoal``), the subgoal is reported as an additional (needless) step.
        """
        observed = self._drop_literals_unknown_to_domain(formula)
        self._extent.require_dnf_within_literal_limit(observed)
        alternatives = tuple(dict.fromkeys(self._list_disjuncts(observed)))
        literals = {literal for alternative in alternatives for literal in alternative}
        why = _NOT_DONE if any(map(self._programs.brings_about, literals)) else _BY_NOTHING
        required = self._programs.required(observed, why, alternatives)
        tested = self._add_instruction(
            _make_instruction_that_checks_condition(required, subgoal, next_instruction)
        )
        entries = [
            self._add_instruction(
                ExecuteSubgoalPlansInstruction(
                    self._programs.plans(literals_of_one, required), subgoal, tested, MAX_ACTIONS_PER_SUBGOAL
                )
            )
            if literals_of_one
            else tested
            for literals_of_one in reversed(alternatives)
        ]
        to_do = self._add_fork_instruction(entries, subgoal)
        if to_do == tested:
            return tested
        needless = self._programs.needless(alternatives)
        held = (
            self._add_instruction(ExecuteSubgoalPlansInstruction(needless, subgoal, next_instruction))
            if is_whole_subgoal
            else next_instruction
        )
        targets = (to_do,), (held,)
        return self._add_instruction(
            SubgoalForkInstruction(lambda state: targets[required.holds(state)], subgoal, 1 + required.effort)
        )

    def _list_disjuncts(self, formula: f.Formula) -> Iterator[tuple[GroundAtom, ...]]:
        """Yield the literals of each disjunct of a formula.

        A part that is not a literal of the domain, such as an equality, adds no literals: the search tests
        whether it holds, but takes no action to make it true.
        """
        match formula:
            case f.And(parts):
                for chosen in product(*map(self._list_disjuncts, parts)):
                    yield tuple(dict.fromkeys([literal for instance in chosen for literal in instance]))
            case f.Or(parts):
                for part in parts:
                    yield from self._list_disjuncts(part)
            case f.Exists(variable, body):
                for instance in self._replace_variable_by_each_object(
                    variable, body, self._extent.list_relevant_objects(variable)
                ):
                    yield from self._list_disjuncts(instance)
            case f.ForAll(variable, body):
                instances = self._replace_variable_by_each_object(
                    variable, body, self._extent.list_values_of_variable(variable)
                )
                yield from self._list_disjuncts(f.And(tuple(instances)))
            case _:
                literal = self._lexicon.to_literal(formula)
                yield () if literal is None else (literal,)

    def _drop_literals_unknown_to_domain(self, formula: f.Formula) -> f.Formula:
        """Return a formula with true in place of literals with names that the domain does not know."""
        match formula:
            case f.And(parts) | f.Or(parts):
                return type(formula)(tuple([self._drop_literals_unknown_to_domain(part) for part in parts]))
            case f.Exists(variable, body) | f.ForAll(variable, body):
                return type(formula)(variable, self._drop_literals_unknown_to_domain(body))
            case f.Atom() | f.Not(f.Atom()) if self._lexicon.has_unknown_names(formula):
                return f.TRUE
            case _:
                return formula

    def _replace_variable_by_each_object(
        self, variable: f.Variable, body: f.Formula, indices: Iterable[int]
    ) -> Iterator[f.Formula]:
        for index in indices:
            yield substitute_terms(
                body, {f.Variable(variable.name): f.Constant(self._lexicon.get_object_name(index))}
            )

    def _add_fork_instruction(
        self, first_instruction_of_each_branch: Sequence[_InstructionNumber], subgoal: int
    ) -> _InstructionNumber:
        if len(first_instruction_of_each_branch) == 1:
            return first_instruction_of_each_branch[0]
        return self._add_instruction(
            SubgoalForkInstruction(lambda state: first_instruction_of_each_branch, subgoal)
        )

    def _add_instruction(self, instruction: Instruction) -> _InstructionNumber:
        if len(self.program) >= MAX_INSTRUCTIONS:
            raise InputError(
                f"the subgoals need more than {MAX_INSTRUCTIONS:,} instructions: use fewer `or` and `exists`"
            )
        self.program.append(instruction)
        return len(self.program) - 1


def _make_instruction_that_checks_condition(
    required: _StateRequirement, subgoal: int, next_instruction: _InstructionNumber
) -> CheckSubgoalHoldsInstruction:
    return CheckSubgoalHoldsInstruction(
        required.holds, required.check, subgoal, next_instruction, 1 + required.effort
    )


def _is_about_single_state(formula: f.Formula) -> bool:
    """Whether a formula is about a single state and contains no action."""
    return is_state_formula(formula) and not any(
        isinstance(part, f.Occurs) for part in walk_subformulas(formula)
    )


def _make_not_executable_error(formula: f.Formula) -> InputError:
    return InputError(f"{format_ltl(formula)}: there is no way to carry this out")
