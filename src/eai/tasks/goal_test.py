"""Test which goals of a task a plan reaches, and count the reached goals of each `GoalKind`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property
from itertools import compress

from eai.base.errors import InputError
from eai.logic.choice import AndOrTree, build_and_or_tree
from eai.logic.formula import FALSE, Atom, Formula, Occurs, Or, Variable, get_operands
from eai.logic.semantics import holds
from eai.logic.traversal import is_state_formula, walk_subformulas
from eai.tasks.best_option import make_finder_of_most_satisfied_goal_option
from eai.tasks.share import Share, TalliesByGoalKind
from eai.tasks.task import Goal, GoalKind, Task
from eai.world.action import Action
from eai.world.condition import ConditionCompiler
from eai.world.domain import Domain
from eai.world.execution import Trajectory, execute_plan, to_trace
from eai.world.frame import UNBOUND, ConditionTest, SlotAllocator
from eai.world.state import Scene, State


def make_variables_of_action_arguments(count: int) -> tuple[Variable, ...]:
    """Return variables for the objects of an action. No formula has their names, which contain spaces."""
    return tuple([Variable(f"argument {number}") for number in range(1, count + 1)])


_MAX_CACHED_SHARES = 1_000
"""Maximum number of final states whose partial success (share of met conditions) is cached for a task.

Plans often end in equal states.
"""


class StateTest:
    """A test of a formula about one state, compiled for a scene.

    The formula names objects by their names in the scene. It has no free variables except those of
    `make_variables_of_action_arguments`.

    Args:
        formula: the formula.
        scene: the scene.
        argument_count: number of objects of the action that is executed in the state; 0 without an action.

    Attributes:
        truth: evaluates the formula, given a state and a copy of `binding`. Quantifiers write their objects
            into the copy.
        binding: the values of variables at the start of a test. The variables for the objects of an action
            have no value yet.

    Raises:
        DomainError: the formula is not about one state, or uses an unknown predicate or object.
    """

    __slots__ = ("binding", "truth")

    def __init__(self, formula: Formula, scene: Scene, argument_count: int = 0) -> None:
        frame = SlotAllocator(make_variables_of_action_arguments(argument_count))
        self.truth: ConditionTest = ConditionCompiler(scene.vocabulary, frame).compile_test(formula)
        self.binding = frame.bind_arguments(scene, (UNBOUND,) * argument_count)

    def __call__(self, state: State, arguments: tuple[int, ...] = ()) -> bool:
        """Whether the formula holds in a state.

        Args:
            state: the state.
            arguments: the objects of the action that is executed in the state; empty without an action.
        """
        binding = self.binding.copy()  # quantifiers write into the binding, so each call needs a copy
        if arguments:
            binding[1 : 1 + len(arguments)] = arguments
        return self.truth(state, binding)


class GoalTest:
    """The goals of a task, compiled for tests of plans. Several threads may use one test.

    A goal about states is reached if it holds in the final state. A goal over time is reached if it holds on
    the whole execution (`eai.logic.semantics`). Action goals must be met in their order. If the plan's
    actions do not meet all of them in this order, only some count as reached: the longest series of action
    goals that the actions meet in order. Among equally long series, the series counts that is complete after
    the fewest actions. An answer that was not executed reaches no goal.

    Args:
        task: the task.
        formulas: formulas that replace those of the goals, in order; the goals' own formulas if None.
    """

    def __init__(self, task: Task, formulas: Sequence[Formula] | None = None) -> None:
        self._task = task
        formulas_of_goals = [goal.formula for goal in task.goals] if formulas is None else formulas
        self._action_indices = tuple([i for i, goal in enumerate(task.goals) if goal.kind is GoalKind.ACTION])
        self._over_time = {
            i: formula for i, formula in enumerate(formulas_of_goals) if not is_state_formula(formula)
        }
        passed_over = {*self._action_indices, *self._over_time}
        self._tests = tuple(
            [
                StateTest(FALSE if i in passed_over else formula, task.scene)
                for i, formula in enumerate(formulas_of_goals)
            ]
        )
        self._state_tests = tuple([test for i, test in enumerate(self._tests) if i not in passed_over])
        self._actions = tuple(
            [list_actions_that_meet_goal(goal) for goal in task.get_goals_of_kind(GoalKind.ACTION)]
        )
        credits = [_divide_credit_among_goal_kinds(goal) for goal in task.goals_not_about_hazards]
        self._credits_by_kind = tuple([tuple([credit[kind] for credit in credits]) for kind in range(3)])
        self.none_reached: tuple[bool, ...] = (False,) * len(task.goals)
        self._tally_cache: dict[tuple[bool, ...], TalliesByGoalKind] = {}

    def evaluate_each_goal(
        self, final: State, actions: Sequence[str], trajectory: Trajectory | None = None
    ) -> tuple[bool, ...]:
        """Return for each goal, in order, whether a plan reaches it.

        Args:
            final: the state after the plan.
            actions: the names of the executed actions, in order.
            trajectory: the whole execution; None if nothing was executed.
        """
        reached = [test.truth(final, test.binding.copy()) for test in self._tests]
        if self._actions:
            for number in self._find_indices_of_met_action_goals(self._actions, actions):
                reached[self._action_indices[number]] = True
        if self._over_time:
            trace = to_trace(trajectory or Trajectory((final,), ()))
            for place, formula in self._over_time.items():
                reached[place] = holds(formula, trace)
        return tuple(reached)

    @property
    def has_goals_over_time(self) -> bool:
        """Whether the task has goals about the whole execution."""
        return bool(self._over_time)

    def meets_goals_over_time(self, trajectory: Trajectory) -> bool:
        """Whether an execution meets those goals of the task that are about the whole execution."""
        trace = to_trace(trajectory)
        return all(holds(formula, trace) for formula in self._over_time.values())

    def meets_goals_about_states(self, final: State) -> bool:
        """Whether a final state meets the task's goals about states."""
        return all(test(final) for test in self._state_tests)

    def find_partial_success(self, final: State, actions: Sequence[str], reached: Sequence[bool]) -> Share:
        """Return the partial success of a plan: the share of met conditions in the option with most success.

        An option is a list of conditions on given objects that together satisfy all goals. A goal about some
        lamp, for example, has an option for each lamp. The option with the largest share of met conditions
        counts (paper, section 2, ability 3). All action goals together are one condition, which is met if the
        actions occur in their order. A goal over time is one condition, too. So is any other goal whose
        options cannot be listed.

        Args:
            final: the final state of the plan.
            actions: the names of the executed actions, in order.
            reached: for each goal, in order, whether the plan reaches it.
        """
        return self._met_condition_share_finder.find_share_of_met_conditions_in_best_option(
            final, reached, _are_action_goals_met_in_order(self._actions, actions)
        )

    @cached_property
    def partial_success_of_unexecuted_answer(self) -> Share:
        """The partial success of an answer that was not executed: 0 of N met conditions.

        An option is a list of conditions that together satisfy all goals. N is the length of the option with
        the largest share of met conditions in a state without true atoms, and at least 1.
        """
        return self._met_condition_share_finder.share_if_none_met

    @cached_property
    def _met_condition_share_finder(self) -> _MetConditionShareFinder:
        return _MetConditionShareFinder(self._task)

    def tally_by_kind(self, reached: tuple[bool, ...]) -> TalliesByGoalKind:
        """Return the numbers of reached goals and of all goals, for each kind of goal.

        `reached` says for each goal, in order, whether it is reached.
        """
        tallies = self._tally_cache.get(reached)
        if tallies is None:
            shares = [
                Share(_add_credit(compress(credits, reached)), _add_credit(credits))
                for credits in self._credits_by_kind
            ]
            tallies = self._tally_cache[reached] = TalliesByGoalKind(*shares)
        return tallies

    def _find_indices_of_met_action_goals(
        self, goals: Sequence[tuple[str, ...]], actions: Sequence[str]
    ) -> Sequence[int]:
        """Return the indices of the action goals that the actions meet, in order.

        `goals` has for each action goal the names of alternative actions that meet the goal.
        """
        return find_longest_series_of_met_action_goals(goals, actions)


class _MetConditionShareFinder:
    """Finds the partial success of answers: the share of met conditions in the best option of a task's goals.

    An option is a list of conditions that together satisfy the goals.

    Attributes:
        share_if_none_met: partial success of an answer that was not executed: 0 of ``n`` conditions. ``n`` is
            the length of the best option for a state in which all atoms are false; it is at least 1.
    """

    def __init__(self, task: Task) -> None:
        choices: list[AndOrTree] = []
        self._whole: list[int] = []
        self._has_actions = False
        for number, goal in enumerate(task.goals):
            if goal.kind is GoalKind.ACTION:
                self._has_actions = True
            elif (choice := _build_option_tree_of_goal(goal, task.scene)) is not None:
                choices.append(choice)
            else:
                self._whole.append(number)
        self._best = make_finder_of_most_satisfied_goal_option(choices, len(self._whole) + self._has_actions)
        frame = SlotAllocator(())
        conditions = ConditionCompiler(task.scene.vocabulary, frame)
        self._truths = [conditions.compile_test(atom) for atom in self._best.atoms]
        self._binding = frame.bind_arguments(task.scene, ())
        self._known: dict[tuple[int, int], Share] = {}
        self.share_if_none_met = Share(0, max(1, self._best(0).total))

    def find_share_of_met_conditions_in_best_option(
        self, final: State, reached: Sequence[bool], action_goals_met: bool
    ) -> Share:
        """Return the share of met conditions in the option with the largest share.

        An option is a list of conditions that together satisfy the goals.

        Args:
            final: the state in which the conditions are tested.
            reached: whether each goal, in order, is reached. This decides goals over time and goals whose
                options cannot be listed. Each of them counts as one condition.
            action_goals_met: whether all action goals are met. Together they count as one condition.
        """
        binding = self._binding.copy()  # derived predicates write into the binding, so each call needs a copy
        true = 0
        for number, truth in enumerate(self._truths):
            if truth(final, binding):
                true |= 1 << number
        whole = sum([reached[number] for number in self._whole]) + (self._has_actions and action_goals_met)
        share = self._known.get((true, whole))
        if share is None:
            if len(self._known) >= _MAX_CACHED_SHARES:
                self._known = {}
            best = self._best(true, whole)
            share = Share(best.met, best.total) if best.total else Share(1, 1)
            self._known[true, whole] = share
        return share


def _build_option_tree_of_goal(goal: Goal, scene: Scene) -> AndOrTree | None:
    """Return the and-or tree of the conditions that meet a goal.

    Return None if the goal is temporal or has no such tree.
    """
    if goal.is_temporal:
        return None
    try:
        return build_and_or_tree(goal.formula, scene.names_of_category)
    except InputError:
        return None


def solves_task(domain: Domain, task: Task, plan: Sequence[Action]) -> bool:
    """Whether a plan runs to its end from the start of a task and reaches all goals."""
    trajectory = execute_plan(domain, task.initial, plan)
    operators = [action.operator for action in trajectory.executed_actions]
    return trajectory.failure is None and all(
        GoalTest(task).evaluate_each_goal(trajectory.final_state, operators, trajectory)
    )


def list_actions_that_meet_goal(goal: Goal) -> tuple[str, ...]:
    """Return in order the names of the actions that meet an action goal. Any one of them is enough."""
    return tuple([part.action for part in get_operands(goal.formula, Or) if isinstance(part, Occurs)])


def find_remaining_goals(task: Task, actions: Sequence[str]) -> tuple[Goal, ...]:
    """Return the goals of a task that are still to be reached after some actions.

    Only action goals can be left out. They are met in order: each by the first of its alternative actions
    that was executed after the previous action goal was met.
    """
    action_goals = [i for i, goal in enumerate(task.goals) if goal.kind is GoalKind.ACTION]
    met = 0
    for name in actions:
        if met < len(action_goals) and name in list_actions_that_meet_goal(task.goals[action_goals[met]]):
            met += 1
    return tuple([goal for i, goal in enumerate(task.goals) if i not in action_goals[:met]])


def find_longest_series_of_met_action_goals(
    alternative_actions_of_goals: Sequence[tuple[str, ...]], actions: Sequence[str]
) -> tuple[int, ...]:
    """Return the indices of the longest series of action goals that the actions meet in order.

    Goals between those of the series may be unmet.
    If several series are equally long, return the series that is complete after the fewest actions.
    """
    if _are_action_goals_met_in_order(alternative_actions_of_goals, actions):
        return tuple(range(len(alternative_actions_of_goals)))
    # best[n]: the indices of n goals that the actions meet in order, and the number of actions until then.
    # No other series of n goals is complete after fewer actions.
    best: list[tuple[tuple[int, ...], int]] = [((), 0)]
    for number, wanted in enumerate(alternative_actions_of_goals):
        for met, start in reversed(best):
            length = len(met) + 1
            end = next((i + 1 for i in range(start, len(actions)) if actions[i] in wanted), None)
            if end is not None and (length == len(best) or end < best[length][1]):
                best[length : length + 1] = [((*met, number), end)]
    return best[-1][0]


def _are_action_goals_met_in_order(
    alternative_actions_of_goals: Sequence[tuple[str, ...]], actions: Sequence[str]
) -> bool:
    left = iter(actions)
    return all(any(action in wanted for action in left) for wanted in alternative_actions_of_goals)


def _divide_credit_among_goal_kinds(goal: Goal) -> tuple[float, float, float]:
    """Return how much of a goal counts for states, for relations and for actions. The sum is 1.

    A goal about states and relations counts half for each. Every other goal counts wholly for its kind.
    """
    if goal.kind is GoalKind.ACTION:
        return 0, 0, 1
    binary = {len(part.arguments) > 1 for part in walk_subformulas(goal.formula) if isinstance(part, Atom)}
    if binary == {True, False}:
        return 0.5, 0.5, 0
    return (0, 1, 0) if binary == {True} else (1, 0, 0)


def _add_credit(credit_of_goals: Iterable[float]) -> int | float:
    """Return the sum of the credit of goals, as an integer if it is whole."""
    total = sum(credit_of_goals)
    return int(total) if total == int(total) else total
