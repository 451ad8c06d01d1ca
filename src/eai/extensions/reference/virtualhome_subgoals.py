"""Score VirtualHome subgoals as eai-eval 1.0.5 does, with its plans for single subgoals.

Defects of its reader (``subgoal_plan.py``):

* an answer ends at the first closing brace;
* strings without a call such as ``word(...)`` vanish;
* a string is split at `` or ``, even inside brackets, and a random draw chooses one piece (see `subgoals`);
* ids are numbers, so ``soap.01002`` is ``soap.1002``;
* a quantifier is a parsing error;
* a negation or an object without an id is a parsing error too, but only when the search reaches it.

The plans for a subgoal are those of ``state_action_translator.py``.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from random import Random

from eai.abilities.subgoal_decomposition.program import (
    ActionSequence,
    CompiledSubgoalAnswer,
    RejectedAnswer,
    SubgoalPlanner,
    SubgoalPlanningResult,
    reject_unparseable,
)
from eai.abilities.subgoal_decomposition.search import ExplorationLimits, ExplorationResult, GoalProgress
from eai.benchmarks.virtualhome.notation import SUBGOAL_ACTIONS, VirtualHomeSubgoalNotation
from eai.extensions.reference import virtualhome_quirks
from eai.extensions.reference.subgoals import EaiEvalSubgoalScorer, make_planner_that_rejects_answer
from eai.logic.formula import FALSE, Atom, Formula, Occurs
from eai.logic.ltl import read_formula
from eai.logic.ltl_printer import format_ltl
from eai.tasks.goal_test import GoalTest
from eai.tasks.task import Task
from eai.world.action import Action, Fault
from eai.world.state import State

ACTIONS_FOR_STATE = {
    "CLOSED": ("CLOSE",),
    "OPEN": ("OPEN",),
    "ON": ("SWITCHON",),
    "OFF": ("SWITCHOFF",),
    "PLUGGED_IN": ("PLUGIN",),
    "PLUGGED_OUT": ("PLUGOUT",),
    "CLEAN": ("WIPE", "WASH"),
}
"""Actions that bring an object into a state, by the state. No action leads to any other state."""

ACTIONS_ON_HELD_OBJECT = frozenset({"DRINK", "EAT", "READ"})
ACTIONS_AFTER_TURNING = frozenset({"LOOKAT", "WATCH"})


def list_plans_for_atom(predicate: str, arguments: Sequence[int], state: State) -> Sequence[ActionSequence]:
    """Return the plans that make an atom true; none if no action makes it true."""
    if len(arguments) == 1:
        (x,) = arguments
        return [
            (Action("FIND", (x,)), Action(action, (x,))) for action in ACTIONS_FOR_STATE.get(predicate, ())
        ]
    x, y = arguments
    agent = state.scene.agent
    find_y = Action("FIND", (y,))
    match predicate:
        case "ONTOP" if x == agent:
            return [(find_y, Action("SIT", (y,))), (find_y, Action("LIE", (y,)))]
        case "ONTOP" if y == agent:
            return [(Action("PUTON", (x,)),)]
        case "ONTOP":
            return [(*_make_plan_to_hold(x, state), find_y, Action("PUTBACK", (x, y)))]
        case "INSIDE" if x == agent:
            return [(Action("WALK", (y,)),)]
        case "INSIDE":
            fetch = _make_plan_to_hold(x, state)
            return [(*fetch, find_y, Action(action, (x, y))) for action in ("PUTIN", "POUR")]
        case "NEXT_TO" if x == agent:
            return [(find_y,)]
        case "FACING":
            return [(find_y, Action("TURNTO", (y,)))]
        case "HOLDS_RH" | "HOLDS_LH":
            return [(find_y, Action("GRAB", (y,)))]
        case _:
            return []


def make_plans_for_action(action: str, arguments: Sequence[int], state: State) -> Sequence[ActionSequence]:
    """Return the plans for a subgoal that is an action: a list with one plan."""
    act = Action(action, tuple(arguments))
    if not arguments:
        return [(act,)]
    x, *others = arguments
    if action in ACTIONS_AFTER_TURNING:
        return [(Action("FIND", (x,)), Action("TURNTO", (x,)), act)]
    if others:
        return [(*_make_plan_to_hold(x, state), *(Action("FIND", (y,)) for y in others), act)]
    if action in ACTIONS_ON_HELD_OBJECT and not _is_held(x, state):
        return [(*_make_plan_to_hold(x, state), act)]
    return [(Action("FIND", (x,)), act)]


def _make_plan_to_hold(object_index: int, state: State) -> ActionSequence:
    if _is_held(object_index, state):
        return ()
    return Action("FIND", (object_index,)), Action("GRAB", (object_index,))


def _is_held(object_index: int, state: State) -> bool:
    agent = state.scene.agent
    if agent is None:
        return False
    return state.has("HOLDS_RH", agent, object_index) or state.has("HOLDS_LH", agent, object_index)


_PRIMITIVE = re.compile(r"\w+\(.*?\)")
_LEADING_ZEROS = re.compile(r"\.0+(?=[0-9])")
_WITHOUT_ARGUMENTS = frozenset({"SLEEP", "WAKEUP", "STANDUP"})


class VirtualHomeSubgoalDecompositionScorer(EaiEvalSubgoalScorer):
    """Scores VirtualHome subgoals as eai-eval does. A goal counts as reached if it held at any time."""

    def __init__(self, task: Task, *, limits: ExplorationLimits | None = None) -> None:
        domain = virtualhome_quirks.make_domain_with_all_quirks()
        words = VirtualHomeSubgoalNotation(SUBGOAL_ACTIONS)
        super().__init__(task, domain, words, goals=_GoalTestIgnoringActionOrder(task), limits=limits)
        self.excluded = None

    def _draw_disjunct(self, subgoal: str, rng: Random) -> str | None:
        if subgoal in _WITHOUT_ARGUMENTS:
            return f"{subgoal}()"
        if _PRIMITIVE.search(subgoal) is None:
            return None
        return _LEADING_ZEROS.sub(".", rng.choice(subgoal.split(" or ")))

    def raises_exception_in_eai_eval(self, fault: Fault) -> bool:
        """Whether eai-eval raises an exception because of a fault. A fault is a failed check of an action.

        One cause of an exception is that eai-eval cannot determine which step is missing, such as before SIT
        if no seat is free (``checkers.py``, ``check_missing_preconds``). These exceptions occur only for
        answers that are subgoals. Other code of release 1.0.5 checks answers that are plans
        (``simulation/evolving_graph/checker.py``); it reports a missing step.
        """
        return super().raises_exception_in_eai_eval(fault) or fault.check.history_conditions == (FALSE,)

    def _read_temporal_goal(self) -> Formula | None:
        if self.task.temporal_goal is None:
            return None
        goal, misuses = read_formula(self.task.temporal_goal, self.lexicon.signature, "release")
        return None if misuses else goal

    def _make_goal_progress(self) -> GoalProgress:
        return GoalProgress(self.temporal_goal or FALSE, self.task.scene)

    def _explore_executions_of_subgoals(
        self, compiled: CompiledSubgoalAnswer
    ) -> ExplorationResult | RejectedAnswer:
        if self.temporal_goal is None:
            return reject_unparseable("the reference cannot read the goal of this task")
        return super()._explore_executions_of_subgoals(compiled)

    def _make_planners_with_index_of_first_literal(
        self, literals: Sequence[Formula]
    ) -> list[tuple[int, SubgoalPlanner]]:
        """Return a planner for each literal of an answer, paired with the index of the literal.

        A planner returns plans that make its literal true. If eai-eval cannot translate a literal into
        actions, the planner of the literal ends the search, and the answer is rejected.
        """
        return [(number, self._make_planner(literal)) for number, literal in enumerate(literals)]

    def _make_planner(self, literal: Formula) -> SubgoalPlanner:
        if not isinstance(literal, (Atom, Occurs)):
            return make_planner_that_rejects_answer("a negation cannot be translated")
        if any(term.name not in self.lexicon.objects for term in literal.arguments):
            return make_planner_that_rejects_answer(
                f"{format_ltl(literal)}: an object without an id cannot be translated"
            )
        if isinstance(literal, Occurs):
            action = self.lexicon.to_action(literal)
            return lambda state: SubgoalPlanningResult(make_plans_for_action(*action, state))
        atom = self.lexicon.to_literal(literal)
        if atom is None:
            raise AssertionError(f"{format_ltl(literal)}: the domain has no such predicate and objects")
        return lambda state: SubgoalPlanningResult(list_plans_for_atom(atom.predicate, atom.arguments, state))


class _GoalTestIgnoringActionOrder(GoalTest):
    """A test of action goals that ignores the order in which a plan executes actions (``my_scene_evaluate``).

    A goal is met if the plan contains one of its actions anywhere. The task's goals have an order: goals
    after the first unmet goal do not count.
    """

    def _find_indices_of_met_action_goals(
        self, goals: Sequence[tuple[str, ...]], actions: Sequence[str]
    ) -> Sequence[int]:
        met = [not set(wanted).isdisjoint(actions) for wanted in goals]
        return range((*met, False).index(False))
