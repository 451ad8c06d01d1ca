"""Questions about plans: their final state, their outcome, and their unneeded steps.

Three kinds of question are about all plans that consist of a few listed actions: reachable facts, the first
action of a shortest plan, and actions that every plan contains (landmarks).
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple, TypeAlias

from eai.extensions.questions.one_step import draw_true_and_false_facts, draw_untrue_facts
from eai.extensions.questions.question import Accept
from eai.extensions.questions.setting import (
    GraphOfReachableStates,
    QuestionSetting,
    QuestionWithRightAndWrongTexts,
    draw_sample_keeping_order,
    explore_states,
    find_texts_with_shared_operator,
    format_list,
    format_numbered_list,
)
from eai.tasks.goal_text import write_goal
from eai.world.action import Action
from eai.world.state import Fact, State

_MAX_FACTS = 12
"""Maximum number of gold facts in a question that asks for all facts about one object."""

_MAX_PLAN_CHANGES = 12
"""Maximum number of random changes of a plan that are tried to get the wanted outcome."""

_WRONG_CHOICES = 3
"""Number of wrong choices of a question, beside the right choice."""

_MAX_DETOURS = 3
"""Maximum number of unneeded actions that are inserted into a plan."""

_PLAN_OPERATOR_PROBABILITY = 0.75
"""Probability that an inserted unneeded action uses an operator of the plan.

Its name then does not reveal that the action was inserted.
"""

_WANTED_OUTCOMES = ("works", "fails", "misses", "fails")
"""Outcomes of plans, which consecutive questions take in turn.

Half of the plans fail, because two of the four choices of a question say that a step fails.
"""

_MAX_ACTIONS = 8
"""Maximum length of the list of actions, in a question about all plans that use only listed actions."""

_MIN_ACTIONS = 5
"""Minimum length of the list of actions, in a question about all plans that use only listed actions."""

_MAX_STATES = 150
"""Maximum number of states to which the actions listed in a question lead. Beyond it, no question is made."""

_MAX_STATE_GRAPHS = 4
"""Maximum number of state graphs for the questions about one task.

A state graph holds all states to which some drawn actions lead (`GraphOfReachableStates`). A question lists
the actions.
"""

_MAX_FACTS_PER_ANSWER = 4
"""Maximum number of reachable facts in a question, and maximum number of unreachable facts."""

_MIN_DISTANCE = 2
"""Minimum length of a shortest plan for a goal, in actions."""

_MAX_GOALS = 3
"""Maximum number of facts in the goal of a question."""

_PLAN_LENGTHS = 4
"""Number of different lengths that are wanted for the shortest plan of a question's goal.

Consecutive questions use the lengths in turn, and then begin again with the shortest length.
"""

_GOAL_CANDIDATES = 8
"""Number of goals that are tried to get the wanted length of a shortest plan."""

_NumberedSteps: TypeAlias = Sequence[tuple[int, Action]]
"""Steps of a changed plan: pairs of a number in the original plan (0 for an added step) and an action."""


class _PlanOutcome(NamedTuple):
    """The outcome of a plan.

    Attributes:
        missed_goals: numbers, from 1, of the goals that do not hold at the end.
        failing_step: index, from 0, of the first impossible step; also 0 if all steps are possible.
        unmet_requirement: number, from 1, of the first unmet requirement of that step; 0 if no step is
            impossible.
    """

    missed_goals: tuple[int, ...] = ()
    failing_step: int = 0
    unmet_requirement: int = 0

    @property
    def result_word(self) -> Literal["works", "misses", "fails"]:
        """The result of the plan as one word: ``works``, ``misses`` (a goal) or ``fails`` (at a step)."""
        return "fails" if self.unmet_requirement else "misses" if self.missed_goals else "works"


def _find_outcome_of_plan(
    setting: QuestionSetting, start: State, plan: Sequence[Action], executed_steps: int = 0
) -> _PlanOutcome:
    """Return the outcome of a plan whose first ``executed_steps`` steps are already executed.

    ``start`` is the state after these steps.
    """
    states = _find_states(setting, start, plan[executed_steps:])
    position = executed_steps + len(states) - 1
    if position < len(plan):
        return _PlanOutcome(
            (), position, setting.list_unmet_requirement_numbers(states[-1], plan[position])[0]
        )
    return _PlanOutcome(
        tuple([n for n, held in enumerate(setting.evaluate_goals(states[-1]), 1) if not held])
    )


def _find_states(setting: QuestionSetting, start: State, plan: Sequence[Action]) -> list[State]:
    """Return the state before each step of a plan, up to the first impossible step.

    If all steps are possible, the state after the last step follows.
    """
    states = [start]
    for action in plan:
        after = setting.find_next_state(states[-1], action)
        if after is None:
            break
        states.append(after)
    return states


def make_state_tracking_question(
    setting: QuestionSetting, rng: random.Random, number: int
) -> QuestionWithRightAndWrongTexts | None:
    """Ask which facts hold after several actions. The open form asks for all facts about one object.

    Return None if the task's path (its executable actions) is empty, or if the object has too many facts.
    """
    if not setting.path:
        return None
    first = rng.randrange(len(setting.path))
    last = rng.randrange(first + 1, len(setting.path) + 1)
    states, plan = setting.states[first : last + 1], setting.path[first:last]
    right, wrong = draw_true_and_false_facts(setting, rng, states)
    subject = rng.choice([i for action in plan for i in action.arguments] or [0])
    facts = [fact for fact in setting.list_changeable_facts(states[-1]) if subject in fact.arguments]
    if len(facts) > _MAX_FACTS:
        return None
    values = {
        "plan": format_numbered_list(setting.format_elements(plan)),
        "object": setting.scene.objects[subject].name,
    }
    return QuestionWithRightAndWrongTexts(
        states[0],
        _collect_operator_names(plan),
        len(plan),
        right,
        wrong,
        setting.format_elements(facts),
        values=values,
    )


def make_counterfactual_question(
    setting: QuestionSetting, rng: random.Random, number: int
) -> QuestionWithRightAndWrongTexts | None:
    """Ask for the outcome of a working plan after a step is left out, added, or swapped with the next.

    Return None if the task's path (its executable actions) does not reach the goals, if no random change has
    the wanted outcome, or if the added step fails.
    """
    if not setting.has_path_from_unmet_to_met_goals:
        return None
    for _ in range(_MAX_PLAN_CHANGES):
        variant = _make_plan_with_one_change(setting, rng)
        if variant is None:
            continue
        steps, position, change = variant
        plan = [action for _, action in steps]
        outcome = _find_outcome_of_plan(setting, setting.states[position], plan, position)
        if outcome.result_word == _WANTED_OUTCOMES[number % len(_WANTED_OUTCOMES)]:
            operators = _collect_operator_names([*plan, *setting.path])
            values = {"plan": format_numbered_list(setting.format_elements(setting.path)), "change": change}
            return _make_outcome_question(setting, rng, outcome, steps, operators, values)
    return None


def make_validation_question(
    setting: QuestionSetting, rng: random.Random, number: int
) -> QuestionWithRightAndWrongTexts | None:
    """Ask whether a plan works. If it fails, ask at which step and why.

    Return None if the task's path (its executable actions) does not reach the goals, or if no random change
    of the plan has the wanted result.
    """
    if not setting.has_path_from_unmet_to_met_goals:
        return None
    working_plan, states = _add_detours_to_path_and_list_states(setting, rng)
    plan, outcome, wanted = working_plan, _PlanOutcome(), _WANTED_OUTCOMES[number % len(_WANTED_OUTCOMES)]
    if wanted != outcome.result_word:
        for _ in range(_MAX_PLAN_CHANGES):
            position = rng.randrange(len(working_plan))
            plan = _corrupt_plan(setting, working_plan, position, rng)
            outcome = _find_outcome_of_plan(setting, states[position], plan, position)
            if plan and outcome.result_word == wanted:
                break
        else:
            return None
    values = {"plan": format_numbered_list(setting.format_elements(plan))}
    return _make_outcome_question(
        setting, rng, outcome, list(enumerate(plan, 1)), _collect_operator_names(plan), values
    )


def make_justification_question(
    setting: QuestionSetting, rng: random.Random, number: int
) -> QuestionWithRightAndWrongTexts | None:
    """Ask which single step of a plan can be left out if all other steps are kept.

    Return None if the task's path (its executable actions) does not reach the goals.
    """
    if not setting.has_path_from_unmet_to_met_goals:
        return None
    plan, states = _add_detours_to_path_and_list_states(setting, rng)
    unneeded = [
        number
        for number, before in enumerate(states[:-1], 1)
        if _find_outcome_of_plan(setting, before, plan[number:]).result_word == "works"
    ]
    operators = {f"step {number}": action.operator for number, action in enumerate(plan, 1)}
    right = [f"step {number}" for number in unneeded]
    wrong = [step for step in operators if step not in right]
    return QuestionWithRightAndWrongTexts(
        setting.states[0],
        _collect_operator_names(plan),
        len(plan),
        right,
        wrong,
        list(map(str, unneeded)),
        values={"plan": format_numbered_list(setting.format_elements(plan)), "goals": _format_goals(setting)},
        formulas=setting.goals,
        labels={step: (operator,) for step, operator in operators.items()},
        yes_no_texts=find_texts_with_shared_operator(right, wrong, operators.__getitem__),
    )


def _make_plan_with_one_change(
    setting: QuestionSetting, rng: random.Random
) -> tuple[_NumberedSteps, int, str] | None:
    """Return the task's path (its executable actions) with one random change, and which change was made.

    The change is described by its position, an index from 0 in the path, and an English text. Return None if
    the random kind of change is impossible at the random position.
    """
    steps = list(enumerate(setting.path, 1))
    position = rng.randrange(len(steps))
    match rng.choice(("leave out", "exchange", "put in")):
        case "leave out" if len(steps) > 1:
            return steps[:position] + steps[position + 1 :], position, f"step {position + 1} is left out"
        case "exchange" if position + 1 < len(steps):
            steps[position : position + 2] = reversed(steps[position : position + 2])
            return steps, position, f"steps {position + 1} and {position + 2} change places"
        case "put in":
            action = setting.draw_action(rng, setting.states[position], possible=True)
            if action is not None:
                steps.insert(position, (0, action))
                change = (
                    f"just before step {position + 1}, {setting.format_fact_or_action(action)} is carried out"
                )
                return steps, position, change
    return None


def _make_outcome_question(
    setting: QuestionSetting,
    rng: random.Random,
    outcome: _PlanOutcome,
    plan: _NumberedSteps,
    operators: set[str],
    values: Mapping[str, str],
) -> QuestionWithRightAndWrongTexts | None:
    """Make a question about the outcome of a plan.

    The choices of a question are that the plan works, that it misses a goal, and that one of two steps fails.
    Choices name a step by its number. An added step has no number, so if it fails, return None.
    """
    failing = plan[outcome.failing_step][0] if outcome.unmet_requirement else 0
    if outcome.unmet_requirement and not failing:
        return None
    sentences = {
        "works": "every step can be carried out, and all goals hold at the end",
        "misses": "every step can be carried out, but at the end not all goals hold",
    }
    fails = {n: f"step {n} is the first that cannot be carried out" for n, _ in plan if n}
    right = fails[failing] if failing else sentences[outcome.result_word]
    answer = [f"goal {n}" for n in outcome.missed_goals] or ["works"]
    if failing:
        answer = [f"step {failing}", f"requirement {outcome.unmet_requirement}"]
    classes = [text for text in sentences.values() if text != right]
    steps = [text for text in fails.values() if text != right]
    return QuestionWithRightAndWrongTexts(
        setting.states[0],
        operators,
        len(plan),
        [right],
        [*classes, *draw_sample_keeping_order(rng, steps, _WRONG_CHOICES - len(classes))],
        answer,
        values={**values, "goals": _format_goals(setting)},
        formulas=setting.goals,
        labels={
            **{text: (text,) for text in sentences.values()},
            **{fails[n]: (action.operator, "a step fails") for n, action in plan if n},
        },
    )


def _corrupt_plan(
    setting: QuestionSetting, plan: Sequence[Action], position: int, rng: random.Random
) -> list[Action]:
    """Return a plan in which one step was removed, swapped with the next step, or changed.

    A changed step has another operator or object.
    """
    action, corrupted = plan[position], list(plan)
    match rng.choice(("leave out", "exchange", "object", "operator")):
        case "leave out":
            del corrupted[position]
        case "exchange":
            corrupted[position : position + 2] = reversed(corrupted[position : position + 2])
        case "object" if action.arguments:
            changed = list(action.arguments)
            changed[rng.randrange(len(changed))] = rng.choice(setting.non_agent_object_indices)
            corrupted[position] = Action(action.operator, tuple(changed))
        case _:
            same_arity = [o.name for o in setting.rules.operators if o.arity == len(action.arguments)]
            corrupted[position] = Action(rng.choice(same_arity), action.arguments)
    return corrupted


def _add_detours_to_path_and_list_states(
    setting: QuestionSetting, rng: random.Random
) -> tuple[list[Action], list[State]]:
    """Return a task's path (its executable actions) with up to three unneeded actions, and its states."""
    plan, states = list(setting.path), list(setting.states)
    length = len(plan) + rng.randint(0, _MAX_DETOURS)
    for _ in range(_MAX_PLAN_CHANGES):
        if len(plan) == length:
            break
        position = rng.randrange(len(plan) + 1)
        operators = [step.operator for step in plan] if rng.random() < _PLAN_OPERATOR_PROBABILITY else ()
        action = setting.draw_action(rng, states[position], possible=True, operators=operators)
        if action is None:
            continue
        rest = [action, *plan[position:]]
        new_states = _find_states(setting, states[position], rest)
        if len(new_states) > len(rest) and all(setting.evaluate_goals(new_states[-1])):
            plan[position:], states[position:] = rest, new_states
    return plan, states


def _collect_operator_names(plan: Sequence[Action]) -> set[str]:
    return {action.operator for action in plan}


def _format_goals(setting: QuestionSetting) -> str:
    return format_numbered_list([write_goal(goal) for goal in setting.goals])


def make_reachability_question(
    setting: QuestionSetting, rng: random.Random, number: int
) -> QuestionWithRightAndWrongTexts | None:
    """Ask which facts the listed actions can make true, and which facts they never make true.

    Return None if too few actions are found, if they lead to too many states, or if one of both sets of
    facts is empty.
    """
    wider = _draw_or_reuse_state_graph(setting, rng)
    if wider is None:
        return None
    narrower = wider.restrict_to_actions(
        draw_sample_keeping_order(rng, range(len(wider.actions)), len(wider.actions) - 2)
    )
    within = narrower.reachable_facts
    beyond = wider.reachable_facts - within
    right = setting.format_elements(draw_sample_keeping_order(rng, sorted(within), _MAX_FACTS_PER_ANSWER))
    ever = within.union(setting.list_changeable_facts(wider.states[0]))
    tempting = draw_sample_keeping_order(rng, sorted(beyond), _MAX_FACTS_PER_ANSWER)
    others = [
        fact for fact in draw_untrue_facts(setting, rng, ever, _MAX_FACTS_PER_ANSWER) if fact not in tempting
    ]
    wrong = setting.format_elements([*tempting, *others][:_MAX_FACTS_PER_ANSWER])
    if not right or not wrong:
        return None
    together = rng.sample([*right, *wrong], len(right) + len(wrong))
    values = {
        "actions": format_list(setting.format_elements(narrower.actions)),
        "facts": format_list(together),
    }
    shown = _collect_operator_names(narrower.actions)
    return QuestionWithRightAndWrongTexts(
        wider.states[0], shown, max(narrower.depths) or 1, right, wrong, right, values=values
    )


def make_next_action_question(
    setting: QuestionSetting, rng: random.Random, number: int
) -> QuestionWithRightAndWrongTexts | None:
    """Ask which of the listed actions begins a shortest plan for a goal.

    Return None if no goal is found that needs several of the listed actions.
    """
    goal = _draw_distant_goal(setting, rng, number)
    if goal is None:
        return None
    left = goal.graph.find_distances_to_goal_states(goal.goal_states)
    best = {action for action, target in goal.graph.edges[0] if left.get(target) == goal.distance - 1}
    return _make_question_about_listed_actions(setting, goal, best, "any")


def make_landmarks_question(
    setting: QuestionSetting, rng: random.Random, number: int
) -> QuestionWithRightAndWrongTexts | None:
    """Ask which of the listed actions every plan for a goal contains.

    Return None if no goal is found that needs several of the listed actions.
    """
    goal = _draw_distant_goal(setting, rng, number)
    if goal is None:
        return None
    numbers = range(len(goal.graph.actions))
    fewer = [goal.graph.restrict_to_actions([other for other in numbers if other != n]) for n in numbers]
    needed = {n for n, graph in enumerate(fewer) if not any(map(goal.facts.issubset, graph.added_facts))}
    return _make_question_about_listed_actions(setting, goal, needed, "all")


class _GoalNeedingSeveralActions:
    """A goal that takes several actions to reach.

    Attributes:
        graph: the actions that the question lists, and all states that these actions lead to.
        goals: the facts that must hold together.
        goal_states: indices of the states that satisfy the goal, nearest to the start first.
        distance: number of actions in a shortest plan.
    """

    def __init__(self, graph: GraphOfReachableStates, goals: Sequence[Fact]) -> None:
        self.graph, self.goals, self.facts = graph, goals, frozenset(goals)
        self.goal_states = [n for n, gained in enumerate(graph.added_facts) if self.facts.issubset(gained)]
        self.distance = graph.depths[self.goal_states[0]]


def _draw_distant_goal(
    setting: QuestionSetting, rng: random.Random, number: int
) -> _GoalNeedingSeveralActions | None:
    """Choose a goal at random: facts that become true together only after several actions.

    Several goals are tried. The shortest plan of the returned goal comes nearest to a wanted length. This
    length depends on the question's ``number``.
    """
    graph = _draw_or_reuse_state_graph(setting, rng)
    if graph is None:
        return None
    wanted = _MIN_DISTANCE + number % _PLAN_LENGTHS
    far = [n for n, depth in enumerate(graph.depths) if depth >= _MIN_DISTANCE]
    farther = [n for n in far if graph.depths[n] >= wanted]
    goals = [
        _GoalNeedingSeveralActions(
            graph, draw_sample_keeping_order(rng, graph.added_facts[n], rng.randint(1, _MAX_GOALS))
        )
        for n in draw_sample_keeping_order(rng, farther or far, _GOAL_CANDIDATES)
        if graph.added_facts[n]
    ]
    fitting = [goal for goal in goals if goal.distance >= _MIN_DISTANCE]
    return min(fitting, key=lambda goal: abs(goal.distance - wanted), default=None)


def _draw_or_reuse_state_graph(setting: QuestionSetting, rng: random.Random) -> GraphOfReachableStates | None:
    """Choose some actions of a task at random, and return the graph of all states that they lead to.

    A question lists these actions. A task has at most `_MAX_STATE_GRAPHS` sets of such actions, so that
    questions share the computed graphs. The result is None if a set has too few actions or too many states.
    """
    number = rng.randrange(_MAX_STATE_GRAPHS)
    if number not in setting.state_graphs:
        generator = random.Random(f"{setting.seed} {number}")  # noqa: S311 - chance, not secrets
        setting.state_graphs[number] = _draw_actions_and_make_state_graph(setting, generator)
    return setting.state_graphs[number]


def _draw_actions_and_make_state_graph(
    setting: QuestionSetting, rng: random.Random
) -> GraphOfReachableStates | None:
    """Draw actions, and return the graph of all states that they lead to.

    Some of the actions are from the task's path (its executable actions), the others are random.
    Return None if too few actions are found, or if there are too many states.
    """
    first = rng.randrange(len(setting.path)) if setting.path else 0
    chosen = dict.fromkeys(setting.path[first : first + rng.randint(3, _MAX_ACTIONS - 2)])
    states = setting.states[first : first + len(chosen) + 1]
    for _ in range(2 * _MAX_ACTIONS):
        if len(chosen) >= _MAX_ACTIONS:
            break
        state = rng.choice(states)
        action = setting.draw_action(rng, state, possible=True)
        if action is not None and setting.find_next_state(state, action) != state:
            chosen[action] = None
    if len(chosen) < _MIN_ACTIONS:
        return None
    return explore_states(setting, states[0], rng.sample(list(chosen), len(chosen)), _MAX_STATES)


def _make_question_about_listed_actions(
    setting: QuestionSetting, goal: _GoalNeedingSeveralActions, right_indices: set[int], accept: Accept
) -> QuestionWithRightAndWrongTexts:
    texts = setting.format_elements(goal.graph.actions)
    answer = [text for n, text in enumerate(texts) if n in right_indices]
    return QuestionWithRightAndWrongTexts(
        goal.graph.states[0],
        _collect_operator_names(goal.graph.actions),
        goal.distance,
        answer,
        [text for n, text in enumerate(texts) if n not in right_indices],
        answer,
        accept,
        {"actions": format_list(texts), "goals": format_numbered_list(setting.format_elements(goal.goals))},
    )
