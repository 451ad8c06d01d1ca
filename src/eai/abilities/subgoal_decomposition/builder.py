"""Subgoals made into programs for the search: the same for every domain.

Each subgoal is a formula with all that the language has. What it says of one moment is brought about as a
whole and tested then, by each of its alternatives: every part of an ``or``, every object for an ``exists``; a
``forall`` asks for all objects of its class; the name of a class stands for any of the task's objects of that
class; an action is carried out.

A few words can ask for millions of literals: quantifiers multiply, and so do alternatives. How much a subgoal
comes down to is counted before anything is unfolded, and too much is refused, the same on every machine.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from itertools import product
from math import prod
from typing import NamedTuple

import eai.logic.formula as f
from eai.abilities.notation.subgoals import WrittenSubgoals
from eai.abilities.subgoal_decomposition.program import (
    MAX_ACTIONS,
    CompiledAnswer,
    Fork,
    Instruction,
    MisusedName,
    Perform,
    Program,
    RejectedAnswer,
    Require,
    SubgoalPlanner,
    SubgoalPlans,
    reject_names,
    reject_unparseable,
)
from eai.abilities.subgoal_decomposition.refinement import Refinement
from eai.abilities.subgoal_decomposition.repertoire import Holds
from eai.abilities.verdict import Unreadable
from eai.base.errors import InputError, ParseError
from eai.logic.ltl import read_formula
from eai.logic.ltl_printer import print_ltl
from eai.logic.rewriting import negation_normal, substitute
from eai.logic.traversal import children, is_state_formula, quantify, walk
from eai.planning.subgoal import GroundAtom
from eai.tasks.goal_test import StateTest
from eai.tasks.lexicon import FormulaLexicon
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.fault import FaultKind
from eai.world.operator import Check
from eai.world.relation import bits
from eai.world.state import State

MAX_LITERALS = 100_000
"""The most literals that a subgoal may come down to, and all its alternatives together."""

TOO_MUCH = f"it comes down to more than {MAX_LITERALS:,} literals"


class _QuantifierRange:
    """The range of the quantifiers of subgoals, and how much that makes.

    Args:
        task: the task.
    """

    def __init__(self, task: Task) -> None:
        self._scene = task.scene
        self._relevant = task.relevant

    def all_objects(self, variable: f.Variable) -> Sequence[int]:
        """The objects of a variable's class: what a ``forall`` asks for."""
        return tuple(bits(self._scene.category(variable.category)))

    def usable_objects(self, variable: f.Variable) -> Sequence[int]:
        """The task's objects of a class, or, if there are none, all in the scene: what ``exists`` tries."""
        mask = self._scene.category(variable.category)
        return [i for i in self._relevant if mask >> i & 1] or tuple(bits(mask))

    def count_literals(self, formula: f.Formula) -> int:
        """How many literals a test of a formula may look at.

        A kind of which there is nothing counts as one thing: what stands within or around is looked at.

        Raises:
            InputError: there are more than `MAX_LITERALS`.
        """
        match formula:
            case f.Exists(variable, body) | f.ForAll(variable, body) | f.Exactly(_, variable, body):
                number = self._size(variable) * self.count_literals(body)
            case f.ForPairs(first, second, body):
                number = self._size(first) * self._size(second) * self.count_literals(body)
            case _:
                number = sum(map(self.count_literals, children(formula))) or 1
        return _check_limit(number)

    def _size(self, variable: f.Variable) -> int:
        return max(1, self._scene.category(variable.category).bit_count())

    def count_alternative_literals(self, formula: f.Formula) -> int:
        """How many literals the alternatives of a formula in negation normal form have, all together.

        An alternative counts as one at least, also if it asks for nothing of a kind of which there is none.

        Raises:
            InputError: there are more than `MAX_LITERALS`, or a test looks at more.
        """
        self.count_literals(formula)
        return _check_limit(
            self._count_alternatives(formula) * max(1, self._max_alternative_literals(formula))
        )

    def _count_alternatives(self, formula: f.Formula) -> int:
        """How many alternatives there are, counted no further than is allowed."""
        match formula:
            case f.And(parts):
                choices = prod(map(self._count_alternatives, parts))
            case f.Or(parts):
                choices = sum(map(self._count_alternatives, parts))
            case f.Exists(variable, body):
                choices = len(self.usable_objects(variable)) * self._count_alternatives(body)
            case f.ForAll(variable, body):
                choices = self._count_alternatives(body) ** len(self.all_objects(variable))
            case _:
                choices = 1
        return min(choices, MAX_LITERALS + 1)

    def _max_alternative_literals(self, formula: f.Formula) -> int:
        """How many literals one alternative has at most."""
        match formula:
            case f.And(parts):
                return sum(map(self._max_alternative_literals, parts))
            case f.Or(parts):
                return max(map(self._max_alternative_literals, parts), default=0)
            case f.Exists(_, body):
                return self._max_alternative_literals(body)
            case f.ForAll(variable, body):
                return len(self.all_objects(variable)) * self._max_alternative_literals(body)
            case _:
                return 1


def _check_limit(number: int) -> int:
    if number > MAX_LITERALS:
        raise InputError(TOO_MUCH)
    return number


MAX_INSTRUCTIONS = 20_000
"""The longest program; alternatives multiply where names or variables stand for several objects."""

_LITERALS_PER_ACTION = 100
"""How many literals of a formula are tested in the time in which an action is applied."""

_MAX_EXCLUSION_LITERALS = 100
"""How many literals a subgoal may have, over all alternatives, to be known to exclude each other."""

_MAX_CACHED_SUBGOALS = 32
"""How many subgoals of a task are remembered."""

_MAX_CACHED_STATES = 16
"""For how many states it is remembered what was done for one of them: those of all branches of a search."""


class _FailureReason(NamedTuple):
    """Why a subgoal does not hold: the id of the check, and in words."""

    id: str
    words: str


_BY_NOTHING = _FailureReason("no_action_brings_it_about", "no action brings it about")
_EXCLUDED = _FailureReason("parts_exclude_each_other", "its parts exclude each other")
_NOT_DONE = _FailureReason("not_brought_about", "nothing that is done for it brings it about")


@dataclass(frozen=True, slots=True, eq=False)
class _Requirement:
    """A condition that must hold, as a test; the check that says what is wrong if not; what the test costs.

    It is equal to itself alone: what all alternatives have in common is not hashed for each of them.
    ``refused`` is the check where no state can meet it, by any alternative; it is found out when it is asked.
    """

    holds: Holds
    check: Check
    effort: int
    refused: Callable[[], Check | None]


class Programs:
    """Makes the programs of answers to one task.

    The conditions and plans of the last `_MAX_CACHED_SUBGOALS` subgoals are cached. Answers to one task begin
    alike, and a subgoal does not depend on the rest of the answer.

    Args:
        task: the task.
        lexicon: what subgoals may say.
        refinement: finds what carries them out.
        distinguished: the operators of which it matters to the goal that they are taken.
    """

    def __init__(
        self, task: Task, lexicon: FormulaLexicon, refinement: Refinement, distinguished: Collection[str]
    ) -> None:
        self.task = task
        self.lexicon = lexicon
        self._refinement = refinement
        self._distinguished = distinguished
        self.extent = _QuantifierRange(task)
        self.brings_about = refinement.brings_about
        self._exclusion = cache(lambda: refinement.exclusion_rules().exclusion_from(task.initial))
        self.required = lru_cache(_MAX_CACHED_SUBGOALS)(self._make_requirement)
        self.needless = lru_cache(_MAX_CACHED_SUBGOALS)(self._make_needless_planner)
        self.plans = lru_cache(_MAX_CACHED_SUBGOALS)(self._make_planner)
        self.make_action_planner = lru_cache(_MAX_CACHED_SUBGOALS)(self._make_action_planner)

    def compile(self, written: WrittenSubgoals | Unreadable) -> CompiledAnswer | RejectedAnswer:
        """An answer whose subgoals are each a text of its own, each read by itself."""
        if isinstance(written, Unreadable):
            return replace(reject_unparseable(written.reason), spans=written.spans)
        return replace(self._compile(written), spans=written.spans)

    def _compile(self, written: WrittenSubgoals) -> CompiledAnswer | RejectedAnswer:
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
            return reject_names(offences, written.repairs)
        try:
            return CompiledAnswer(tuple(formulas), self.program(formulas), written.repairs)
        except InputError as error:
            return reject_unparseable(str(error), written.repairs)

    def program(self, subgoals: Sequence[f.Formula]) -> Program:
        """The program that carries out subgoals one after the other.

        Raises:
            InputError: a subgoal is not a combination of states and actions that can be carried out one after
                the other, or comes down to too much.
        """
        builder = _ProgramBuilder(self)
        start = 0
        for number in reversed(range(len(subgoals))):
            start = builder.subgoal(
                negation_normal(builder.quantify_classes(subgoals[number])), number, start
            )
        return builder.program[: start + 1]

    def _make_action_planner(self, action: Action) -> SubgoalPlanner:
        """The instruction to take an action."""
        plans = self._refinement.make_action_planner(action, self.task.scene, self.task.relevant)
        return lru_cache(_MAX_CACHED_STATES)(plans)

    def _make_requirement(
        self, formula: f.Formula, why: _FailureReason, alternatives: tuple[tuple[GroundAtom, ...], ...] = ()
    ) -> _Requirement:
        if self.lexicon.is_unobserved(formula):
            raise _not_executable(formula)
        meaning = self.lexicon.meaning(formula)

        def check(why: _FailureReason) -> Check:
            reason = f"{print_ltl(formula)} does not hold, and {why.words}"
            return Check(meaning, FaultKind.MISSING_STEP, reason, id=why.id)

        def refused() -> Check | None:
            sizes = [*map(len, alternatives)]
            if min(sizes, default=0) < 2 or sum(sizes) > _MAX_EXCLUSION_LITERALS:
                return None
            return check(_EXCLUDED) if all(map(self._exclusion().excludes, alternatives)) else None

        effort = self.extent.count_literals(formula) // _LITERALS_PER_ACTION
        return _Requirement(StateTest(meaning, self.task.scene), check(why), effort, cache(refused))

    def _make_needless_planner(self, alternatives: tuple[tuple[GroundAtom, ...], ...]) -> SubgoalPlanner:
        """The actions that say of themselves that they are not needed, where one of the alternatives holds.

        Of several that hold, those of the one with the fewest.
        """
        effort = sum(map(len, alternatives)) // _LITERALS_PER_ACTION

        def plans(state: State) -> SubgoalPlans:
            held = [self._refinement.find_needless(each, state) for each in alternatives]
            fewest = min([plan for plan in held if plan is not None], key=len, default=())
            return SubgoalPlans((fewest,) if fewest else (), effort)

        return lru_cache(_MAX_CACHED_STATES)(plans)

    def _make_planner(self, literals: tuple[GroundAtom, ...], required: _Requirement) -> SubgoalPlanner:
        """The ways to bring literals about that fulfil what is required; none where no state does."""
        made = cache(
            lambda: self._refinement.make_planner(
                literals,
                required.holds,
                self.task.scene,
                self.task.relevant,
                self._distinguished,
                test_effort=required.effort,
            )
        )

        def plans(state: State) -> SubgoalPlans:
            found = made()(state)
            refused = required.refused() if found.has_failed else None
            return found if refused is None else SubgoalPlans((), found.effort, refused)

        return lru_cache(_MAX_CACHED_STATES)(plans)


class _ProgramBuilder:
    """Makes instructions from the end of a plan to its beginning."""

    def __init__(self, programs: Programs) -> None:
        self.program: list[Instruction] = [None]
        self._programs = programs
        self._lexicon = programs.lexicon
        self._extent = programs.extent

    def quantify_classes(self, subgoal: f.Formula) -> f.Formula:
        """A subgoal where the name of a class has become a variable for an object of it."""
        names = dict.fromkeys(
            term
            for part in walk(subgoal)
            if isinstance(part, (f.Atom, f.Occurs))
            for term in part.arguments
            if isinstance(term, f.Constant) and self._lexicon.is_class(term.name)
        )
        if not names:
            return subgoal
        subgoal = substitute(subgoal, {name: f.Variable(name.name) for name in names})
        return quantify(f.Exists, [f.Variable(each.name, each.name) for each in names], subgoal)

    def subgoal(self, formula: f.Formula, number: int, then: int) -> int:
        """Put a part of the subgoal of this number in front of instruction ``then``; returns the first one.

        Negations stand at its leaves only.
        """
        if _speaks_of_states(formula):
            return self._add_condition(formula, number, then)
        match formula:
            case f.Occurs():
                action = self._lexicon.action(formula)
                return self._add(
                    Perform(self._programs.make_action_planner(action), number, then, MAX_ACTIONS)
                )
            case f.Then(parts):
                for part in reversed(parts):
                    then = self.subgoal(part, number, then)
                return then
            case f.And(parts):
                return self._add_together(parts, number, then)
            case f.Or(parts):
                return self._add_alternatives(parts, number, then)
            case f.Exists(variable, body):
                instances = self._instances(variable, body, self._extent.usable_objects(variable))
                return self._add_alternatives(list(instances), number, then)
            case _:
                raise _not_executable(formula)

    def _add_together(self, parts: Sequence[f.Formula], number: int, then: int) -> int:
        """Actions in their order, before or after what shall hold when all is done."""
        states = [part for part in parts if _speaks_of_states(part)]
        actions = f.Then(tuple([part for part in parts if part not in states]))
        if not states:
            return self.subgoal(actions, number, then)
        held = f.And(tuple(states))
        tested = self._add(_require(self._programs.required(held, _NOT_DONE), number, then))
        before = self._add_condition(held, number, self.subgoal(actions, number, tested), is_all=False)
        after = self.subgoal(actions, number, self._add_condition(held, number, then, is_all=False))
        return self._fork([before, after], number)

    def _add_alternatives(self, parts: Sequence[f.Formula], number: int, then: int) -> int:
        """Several ways to continue, the first of them first."""
        return self._fork([self.subgoal(each, number, then) for each in reversed(parts)], number)

    def _add_condition(self, formula: f.Formula, number: int, then: int, *, is_all: bool = True) -> int:
        """A condition that shall hold at one moment: brought about by one of its alternatives, and tested.

        Where it holds already, by whichever alternative, nothing is done; if it is all that the subgoal says,
        the subgoal may be an additional step.
        """
        observed = self._drop_unobserved(formula)
        self._extent.count_alternative_literals(observed)
        alternatives = tuple(dict.fromkeys(self._alternatives(observed)))
        literals = {literal for alternative in alternatives for literal in alternative}
        why = _NOT_DONE if any(map(self._programs.brings_about, literals)) else _BY_NOTHING
        required = self._programs.required(observed, why, alternatives)
        tested = self._add(_require(required, number, then))
        entries = [
            self._add(Perform(self._programs.plans(each, required), number, tested, MAX_ACTIONS))
            if each
            else tested
            for each in reversed(alternatives)
        ]
        to_do = self._fork(entries, number)
        if to_do == tested:
            return tested
        needless = self._programs.needless(alternatives)
        held = self._add(Perform(needless, number, then)) if is_all else then
        ways = (to_do,), (held,)
        return self._add(Fork(lambda state: ways[required.holds(state)], number, 1 + required.effort))

    def _alternatives(self, formula: f.Formula) -> Iterator[tuple[GroundAtom, ...]]:
        """The literals to bring about, all of one alternative; nothing for what is only tested."""
        match formula:
            case f.And(parts):
                for chosen in product(*map(self._alternatives, parts)):
                    yield tuple(dict.fromkeys([literal for each in chosen for literal in each]))
            case f.Or(parts):
                for part in parts:
                    yield from self._alternatives(part)
            case f.Exists(variable, body):
                for each in self._instances(variable, body, self._extent.usable_objects(variable)):
                    yield from self._alternatives(each)
            case f.ForAll(variable, body):
                instances = self._instances(variable, body, self._extent.all_objects(variable))
                yield from self._alternatives(f.And(tuple(instances)))
            case _:
                literal = self._lexicon.literal(formula)
                yield () if literal is None else (literal,)

    def _drop_unobserved(self, formula: f.Formula) -> f.Formula:
        """A formula where that of which the domain knows nothing is taken to be so."""
        match formula:
            case f.And(parts) | f.Or(parts):
                return type(formula)(tuple([self._drop_unobserved(part) for part in parts]))
            case f.Exists(variable, body) | f.ForAll(variable, body):
                return type(formula)(variable, self._drop_unobserved(body))
            case f.Atom() | f.Not(f.Atom()) if self._lexicon.is_unobserved(formula):
                return f.TRUE
            case _:
                return formula

    def _instances(
        self, variable: f.Variable, body: f.Formula, indices: Iterable[int]
    ) -> Iterator[f.Formula]:
        """The body for each of some objects, by the names that they have in the answer."""
        for index in indices:
            yield substitute(body, {f.Variable(variable.name): f.Constant(self._lexicon.name(index))})

    def _fork(self, entries: Sequence[int], number: int) -> int:
        return entries[0] if len(entries) == 1 else self._add(Fork(lambda state: entries, number))

    def _add(self, instruction: Instruction) -> int:
        if len(self.program) >= MAX_INSTRUCTIONS:
            raise InputError(f"it has more than {MAX_INSTRUCTIONS:,} steps and alternatives")
        self.program.append(instruction)
        return len(self.program) - 1


def _require(required: _Requirement, number: int, then: int) -> Require:
    return Require(required.holds, required.check, number, then, 1 + required.effort)


def _speaks_of_states(formula: f.Formula) -> bool:
    """Whether a formula is about one moment, and about no action."""
    return is_state_formula(formula) and not any(isinstance(part, f.Occurs) for part in walk(formula))


def _not_executable(formula: f.Formula) -> InputError:
    return InputError(f"{print_ltl(formula)}: there is no way to carry this out")
