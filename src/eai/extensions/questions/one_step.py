"""Questions about one action: its effects, whether it is possible and why not, and which action it was."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence

from eai.extensions.questions.setting import (
    QuestionSetting,
    QuestionWithRightAndWrongTexts,
    draw_sample_keeping_order,
    find_texts_with_shared_operator,
    format_list,
)
from eai.planning.search import SearchEffort
from eai.planning.successor_generator import generate_applicable_actions_of_operator
from eai.world.action import Action
from eai.world.state import Fact, State

_LISTED_ACTIONS = 8
"""Number of actions that a question about possible actions lists. Half of them are possible."""

_MAX_DRAWS = 20
"""Maximum number of random draws to find one fact or action."""

_MAX_BINDINGS = 200_000
"""Maximum number of actions (operators with objects) that are tried to find all right answers."""

_RANDOM_BINDINGS = 40
"""Number of random actions of one operator that are drawn to find actions with unmet requirements."""

_FEWEST_UNMET_PROBABILITY = 0.5
"""Probability that a question of kind `WHY_NOT` is about the action with the fewest unmet requirements.

Otherwise, the question is about a random action. Only actions with a certain unmet requirement are
candidates. The requirement is chosen at random.
"""

_PATH_OPERATOR_PROBABILITY = 0.2
"""Probability that an operator of the task's path (its executable actions) is kept for a `WHY_NOT` question.

The question is about an action of one operator, drawn from the kept operators. If no operator was kept, it is
drawn from all operators with several requirements.
"""

_NO_EFFECT_PROBABILITY = 0.3
"""Probability that a question is kept although its action changes nothing."""

_WRONG_CHOICES = 3
"""Number of wrong choices of a question, beside the right choice."""


def make_question_about_facts_after_action(
    setting: QuestionSetting, rng: random.Random, number: int
) -> QuestionWithRightAndWrongTexts | None:
    """Ask which facts hold after an action. The open form asks which facts the action changes.

    Return None if no possible action is found. If the random action changes nothing, usually return None too
    (with probability 1 - `_NO_EFFECT_PROBABILITY`).
    """
    moment = _draw_transition(setting, rng)
    if moment is None:
        return None
    state, action, after = moment
    changes = setting.format_changes(state, after)
    if not changes and rng.random() > _NO_EFFECT_PROBABILITY:
        return None
    right, wrong = draw_true_and_false_facts(setting, rng, [state, after])
    return QuestionWithRightAndWrongTexts(
        state,
        {action.operator},
        1,
        right,
        wrong,
        changes,
        values={"action": setting.format_fact_or_action(action)},
    )


def make_question_about_action_that_changes_fact(
    setting: QuestionSetting, rng: random.Random, number: int
) -> QuestionWithRightAndWrongTexts | None:
    """Ask which single action makes a false fact true or a true fact false.

    A possible action is drawn, and the fact is drawn from its changes. Return None if no possible action is
    found, the drawn action changes nothing, or there are too many actions to try.
    """
    moment = _draw_transition(setting, rng)
    if moment is None:
        return None
    state, action, after = moment
    added, removed = setting.find_added_facts(state, after), setting.find_added_facts(after, state)
    if not added and not removed:
        return None
    fact = rng.choice([*added, *removed])
    literal = (
        setting.format_fact_or_action(fact) if fact in added else f"not {setting.format_fact_or_action(fact)}"
    )

    def is_wanted_state(reached: State) -> bool:
        return reached.has(fact.predicate, *fact.arguments) is (fact in added)

    values = {"fact": literal}
    return _make_which_action_question(setting, rng, state, action, {fact.predicate}, is_wanted_state, values)


def make_question_about_action_that_made_changes(
    setting: QuestionSetting, rng: random.Random, number: int
) -> QuestionWithRightAndWrongTexts | None:
    """Ask which single action changed exactly the facts that the question lists.

    A possible action is drawn, and the question lists its changes. Return None if no possible action is
    found, the drawn action changes nothing, or there are too many actions to try.
    """
    moment = _draw_transition(setting, rng)
    if moment is None:
        return None
    state, action, after = moment
    changed = {
        fact.predicate
        for fact in (*setting.find_added_facts(state, after), *setting.find_added_facts(after, state))
    }
    if not changed:
        return None
    values = {"changes": format_list(setting.format_changes(state, after))}
    return _make_which_action_question(
        setting, rng, state, action, changed, lambda reached: setting.is_same_state(reached, after), values
    )


def make_applicability_question(
    setting: QuestionSetting, rng: random.Random, number: int
) -> QuestionWithRightAndWrongTexts | None:
    """Ask which of the listed actions are possible. Half of them are possible.

    Return None if too few possible or too few impossible actions are found.
    """
    state = rng.choice(setting.states)
    right, wrong = _draw_possible_and_impossible_actions(setting, rng, state, _LISTED_ACTIONS // 2)
    if len(right) < _LISTED_ACTIONS // 2 or len(wrong) < _LISTED_ACTIONS // 2:
        return None
    together = rng.sample([*right, *wrong], _LISTED_ACTIONS)
    answer = setting.format_elements(right)
    return QuestionWithRightAndWrongTexts(
        state,
        {action.operator for action in together},
        1,
        answer,
        setting.format_elements(wrong),
        answer,
        values={"actions": format_list(setting.format_elements(together))},
        are_actions=True,
    )


def make_why_not_question(
    setting: QuestionSetting, rng: random.Random, number: int
) -> QuestionWithRightAndWrongTexts | None:
    """Ask which requirements of an action are not met.

    Return None if no operator with several requirements has enough objects for its parameters, or if no
    tried action has an unmet requirement.
    """
    state = rng.choice(setting.states)
    candidates = [
        each
        for each in setting.rules.operators
        if len(each.checks) > 1 and each.arity <= len(setting.non_agent_object_indices)
    ]
    if not candidates:
        return None
    path_operators = {step.operator for step in setting.path}
    operator = rng.choice(
        [
            each
            for each in candidates
            if each.name in path_operators and rng.random() < _PATH_OPERATOR_PROBABILITY
        ]
        or candidates
    )
    drawn = [step for step in setting.path if step.operator == operator.name]
    drawn += [
        Action(operator.name, tuple(rng.sample(setting.non_agent_object_indices, operator.arity)))
        for _ in range(_RANDOM_BINDINGS)
    ]
    unmet = {each: setting.list_unmet_requirement_numbers(state, each) for each in drawn}
    seen = sorted({n for each in unmet.values() for n in each})
    if not seen:
        return None
    one = rng.choice(seen)  # drawing an action first would favour requirements that many actions do not meet
    fitting = [each for each in drawn if one in unmet[each]]
    best = min(fitting, key=lambda each: len(unmet[each]))
    action = best if rng.random() < _FEWEST_UNMET_PROBABILITY else rng.choice(fitting)
    failing = unmet[action]
    numbers = range(1, len(operator.checks) + 1)
    reasons, met = [f"requirement {n}" for n in numbers], [n for n in numbers if n not in failing]
    return QuestionWithRightAndWrongTexts(
        state,
        {action.operator},
        1,
        [reasons[n - 1] for n in sorted(failing, key=lambda n: n != one)],
        [reasons[n - 1] for n in sorted(met, key=lambda n: n not in seen)],
        [str(n) for n in failing],
        values={"action": setting.format_fact_or_action(action)},
        labels={reason: (f"{action.operator} {reason}", reason) for reason in reasons},
        yes_no_texts={reasons[n - 1] for n in seen if any(n not in each for each in unmet.values())},
    )


def draw_true_and_false_facts(
    setting: QuestionSetting, rng: random.Random, states: Sequence[State]
) -> tuple[list[str], list[str]]:
    """Return two lists of texts: facts that hold in the last of several states, and facts that do not.

    If possible, each list has two facts that had the other truth value in an earlier state. Then neither
    "nothing changed" nor "everything changed" separates true from false statements.
    """
    start, last = frozenset(setting.list_changeable_facts(states[0])), states[-1]
    gained = frozenset([fact for state in states[1:] for fact in setting.find_added_facts(states[0], state)])
    lost = frozenset([fact for state in states[1:] for fact in setting.find_added_facts(state, states[0])])
    ever, always = start | gained, start - lost
    now = start.difference(setting.find_added_facts(last, states[0])).union(
        setting.find_added_facts(states[0], last)
    )
    right = [
        *draw_sample_keeping_order(rng, sorted(now - always), 2),
        *draw_sample_keeping_order(rng, sorted(always), 2),
    ]
    wrong = draw_sample_keeping_order(rng, sorted(ever - now), 2)
    wrong += draw_untrue_facts(setting, rng, ever, max(2, _WRONG_CHOICES - len(wrong)))
    return setting.format_elements(right), setting.format_elements(wrong)


def draw_untrue_facts(
    setting: QuestionSetting, rng: random.Random, facts_true_at_some_time: frozenset[Fact], number: int
) -> list[Fact]:
    """Draw facts that are never true: facts that are true at some time, with one object replaced."""
    facts: list[Fact] = []
    true_facts, objects = sorted(facts_true_at_some_time), range(len(setting.scene.objects))
    for _ in range(_MAX_DRAWS if true_facts else 0):
        predicate, arguments = rng.choice(true_facts)
        changed = list(arguments)
        if changed:
            changed[rng.randrange(len(changed))] = rng.choice(objects)
        fact = Fact(predicate, tuple(changed))
        if fact not in facts_true_at_some_time and len(set(changed)) == len(changed) and fact not in facts:
            facts.append(fact)
    return facts[:number]


def _draw_transition(setting: QuestionSetting, rng: random.Random) -> tuple[State, Action, State] | None:
    """Draw a state and an action. Return the state, the action and the state after the action.

    The task's path (its executable actions) passes through the state. The action is the next action of the
    path or a random possible action, with equal probability. Return None if no possible action was found.
    """
    step = rng.randrange(len(setting.states))
    state = setting.states[step]
    if step < len(setting.path) and rng.random() < 0.5:
        return state, setting.path[step], setting.states[step + 1]
    action = setting.draw_action(rng, state, possible=True)
    after = None if action is None else setting.find_next_state(state, action)
    return None if action is None or after is None else (state, action, after)


def _make_which_action_question(
    setting: QuestionSetting,
    rng: random.Random,
    state: State,
    action: Action,
    changed: set[str],
    is_wanted_state: Callable[[State], bool],
    values: Mapping[str, str],
) -> QuestionWithRightAndWrongTexts | None:
    """Make a question that asks which single action leads to a state with a given property.

    All actions on all objects are tried; return None if there are more than `_MAX_BINDINGS`. An action is
    right if its operator can change all predicates in ``changed``, and ``is_wanted_state`` is true for the
    state after it. Wrong actions are drawn at random. Some have the operator or the objects of ``action``,
    and some can be executed.
    """
    bindings, all_objects = SearchEffort(_MAX_BINDINGS), range(len(setting.scene.objects))
    tried = [
        candidate
        for operator in setting.rules.operators
        if changed <= setting.rules.changed_predicates_by_operator[operator.name]
        for candidate in generate_applicable_actions_of_operator(
            setting.domain, operator, state, all_objects, bindings
        )
    ]
    if bindings.is_limit_exceeded:
        return None
    right = [
        candidate
        for candidate in tried
        if (after := setting.find_next_state(state, candidate)) is not None and is_wanted_state(after)
    ]
    number = len(action.arguments)
    same_arity = [operator.name for operator in setting.rules.operators if operator.arity == number]
    drawn: list[Action] = []
    for _ in range(_LISTED_ACTIONS):
        name, arguments = rng.choice(same_arity), tuple(rng.sample(setting.non_agent_object_indices, number))
        drawn += [Action(name, action.arguments), Action(action.operator, arguments), Action(name, arguments)]
    drawn += _draw_actions(setting, rng, state, _WRONG_CHOICES, possible=True)
    reached = {candidate: setting.find_next_state(state, candidate) for candidate in drawn}
    wrong = setting.format_elements(
        [candidate for candidate, after in reached.items() if after is None or not is_wanted_state(after)]
    )
    answer = setting.format_elements(right)
    return QuestionWithRightAndWrongTexts(
        state,
        setting.rules.operator_names,
        1,
        answer,
        wrong,
        answer,
        "any",
        values,
        are_actions=True,
        yes_no_texts=find_texts_with_shared_operator(answer, wrong, lambda text: text.partition("(")[0]),
    )


def _draw_possible_and_impossible_actions(
    setting: QuestionSetting, rng: random.Random, state: State, number: int
) -> tuple[list[Action], list[Action]]:
    """Return a list of possible and a list of impossible actions, from the same operators if these exist.

    The name of an operator then does not reveal whether the action is possible.
    """
    right: list[Action] = []
    wrong: list[Action] = []
    for operator in rng.sample(setting.rules.operators, len(setting.rules.operators)):
        if len(right) == number or operator.arity > len(setting.non_agent_object_indices):
            continue
        possible = other = None
        for _ in range(_MAX_DRAWS):
            action = Action(
                operator.name, tuple(rng.sample(setting.non_agent_object_indices, operator.arity))
            )
            if setting.find_next_state(state, action) is None:
                other = other or action
            else:
                possible = possible or action
            if possible and other:
                break
        if possible is not None and other is not None:
            right.append(possible)
            wrong.append(other)
    right += _draw_actions(setting, rng, state, number - len(right), possible=True)
    wrong += _draw_actions(setting, rng, state, number - len(wrong), possible=False)
    return list(dict.fromkeys(right)), list(dict.fromkeys(wrong))


def _draw_actions(
    setting: QuestionSetting, rng: random.Random, state: State, number: int, *, possible: bool
) -> list[Action]:
    """Draw different random actions. Return fewer than requested if not enough are found."""
    actions: dict[Action, None] = {}
    for _ in range(2 * number):
        action = setting.draw_action(rng, state, possible=possible)
        if action is not None:
            actions[action] = None
        if len(actions) == number:
            break
    return list(actions)
