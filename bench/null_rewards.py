"""Measure the rewards of null answers, and the wins of a random agent.

    python -m bench null_rewards [--suite virtualhome/goal] [--sweeps 10] [--declining pairs/]

Null answers are: an empty text, or an empty answer in the form that is asked for; the prompt itself; and the
answers of the null models (`eai/copy`, `eai/random`, `eai/lookup`). For goals and operators there is also an
answer that asserts everything possible, and for plans the copy with a movement to an object before each
action. For each shaping, the program prints the mean over the tasks that can
pay a reward. Answers of any length are read.

The agent plays each task once per sweep, with commands that are possible in the current state. The program
prints the share of episodes won within some numbers of steps, and the reward of an immediate `DONE`.

With ``--declining`` it prints the rewards of two answers only: refusing each task, and asking about each.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import permutations, product
from random import Random
from statistics import mean
from typing import get_args

from bench.record import add_write_option, get_suite_title, write_rows
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.declining import QUESTION, write_refusal_answer
from eai.abilities.notation.goal_lexicon import GoalLexicon
from eai.abilities.notation.goals import WrittenGoal
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.abilities.verdict import ErrorReport, Unreadable
from eai.agents.command import DONE
from eai.agents.gym import TextEnvironment, make
from eai.agents.rules import Observe
from eai.benchmarks.copied_answers import (
    open_answers_copied_from_questions,
    open_answers_of_similar_tasks,
    open_empty_answers,
)
from eai.benchmarks.gold_answers import AnswersByTask, join_operators_as_answer
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.random_answers import open_random_answers
from eai.benchmarks.suite import Suite, open_suite
from eai.logic.formula import And, Atom, Variable
from eai.pddl.model import Add, AndEffect
from eai.pddl.writer import write_action
from eai.planning.role import infer_operator_role
from eai.results.reward import Reward, Shaping
from eai.tasks.source import Source
from eai.world.action import Action
from eai.world.operator import OperatorRole

HOUSEHOLDS = ("virtualhome", "behavior")
STEPS = (10, 20, 50, 100)
SHOWN = ("copy", "copy, walking", "random", "everything")
"""Null answers that the page of results shows."""


def list_null_answers(suite: Suite) -> Iterator[tuple[str, Callable[[str], str]]]:
    """Yield the null answers of a suite: a name, and a function from a task to its answer."""
    benchmark, ability, source = suite.benchmark, suite.ability, suite.source
    prompts = PromptLibrary("official", None, source).open(benchmark, ability)
    chance = open_random_answers(benchmark, ability, source)
    yield '""', lambda task_id: ""
    for name, opened in (
        ("empty", open_empty_answers),
        ("copy", open_answers_copied_from_questions),
        ("lookup", open_answers_of_similar_tasks),
    ):
        yield name, get_answer_text(opened(benchmark, ability, source))
    yield "random", lambda task_id: chance(task_id, "0", ()).text
    yield "the prompt", lambda task_id: prompts[task_id].user
    if ability is Ability.ACTION_SEQUENCING:
        copies = open_answers_copied_from_questions(benchmark, ability, source)
        yield "copy, walking", lambda task_id: add_movements(suite, task_id, copies[task_id].text)
    if ability is Ability.GOAL_INTERPRETATION:
        yield "everything", lambda task_id: write_all_goals(suite, task_id)
    if ability is Ability.TRANSITION_MODELING:
        yield "everything", lambda task_id: write_all_operators(suite, task_id)


def get_answer_text(book: AnswersByTask) -> Callable[[str], str]:
    """Return a function from a task to the text of a null model's answer."""
    return lambda task_id: book[task_id].text


def write_all_goals(suite: Suite, task_id: str) -> str:
    """Return all states of all objects, all relations, and all actions if answers may have actions."""
    notation, task = suite.benchmark.notation.goals, suite.tasks[task_id]
    lexicon = GoalLexicon(task, suite.benchmark.domain, notation)
    said = [
        WrittenGoal(word, names)
        for word, arity in lexicon.words
        for names in permutations(lexicon.objects, arity)
    ]
    if notation.states_actions:
        said += [WrittenGoal(name, is_action=True) for name in lexicon.actions]
    return notation.join(notation.write(said))


def write_all_operators(suite: Suite, task_id: str) -> str:
    """Return operators whose preconditions and effects have every predicate of their parameters."""
    task = suite.benchmark.operator_tasks(suite.source)[task_id]
    written = []
    for operator in task.gold_operators.values():
        names = [Variable(each.name) for each in operator.parameters]
        atoms = tuple(
            [
                Atom(predicate.name, terms)
                for predicate in task.domain.header.predicates
                for terms in product(names, repeat=len(predicate.parameters))
            ]
        )
        effect = AndEffect(tuple(map(Add, atoms)))
        written.append(write_action(replace(operator, precondition=And(atoms), effect=effect)))
    return join_operators_as_answer(written)


def add_movements(suite: Suite, task_id: str, plan: str) -> str:
    """Return a plan with a movement to the first object of each action before the action."""
    scorer, notation = suite.scorer(task_id), suite.benchmark.notation.plans
    if not isinstance(scorer, ActionSequencingScorer):
        raise TypeError(f"expected a scorer of plans, found {scorer}")
    written = scorer.read(plan)
    actions = () if isinstance(written, Unreadable) else scorer.resolve_names(written)
    if isinstance(actions, ErrorReport):
        raise ValueError(f"{task_id}: {actions.detail}")
    moves = [
        operator.name
        for operator in suite.benchmark.domain.operators
        if operator.arity == 1 and infer_operator_role(operator) is OperatorRole.MOVEMENT
    ]
    steps = [
        step
        for action in actions
        for step in (*(Action(moves[0], action.arguments[:1]),) * bool(action.arguments), action)
    ]
    return notation.join(notation.write(steps, suite.tasks[task_id].scene))


def make_declining_answers(suite: Suite) -> Iterator[tuple[str, Callable[[str], str]]]:
    """Return two answers for each task: a refusal and a question."""
    refused, asked = write_refusal_answer("nothing leads there"), write_refusal_answer("Which one?", QUESTION)
    yield "refuse", lambda task_id: refused
    yield "ask", lambda task_id: asked


def measure_mean_reward(suite: Suite, answer: Callable[[str], str]) -> Mapping[Shaping, float]:
    """Return the mean reward of an answer over the tasks that can pay a reward."""
    texts = list(map(answer, suite.task_ids))
    of_plans = suite.ability is Ability.ACTION_SEQUENCING
    values = {
        shaping: Reward(suite, shaping, limit=sys.maxsize).batch(suite.task_ids, texts)
        for shaping in Shaping
        if of_plans or shaping is not Shaping.REPAIR
    }
    return {shaping: mean([each for each in paid if each is not None]) for shaping, paid in values.items()}


def list_playable_tasks(environment: TextEnvironment) -> list[str]:
    """Return the tasks that have goals."""
    tasks = environment.benchmark.tasks_for(Ability.ACTION_SEQUENCING, Source())
    return [task_id for task_id in environment.task_ids if tasks[task_id].unplannable_reason is None]


def compute_reward_of_immediate_done(name: str, reward: Shaping) -> float:
    """Return the mean reward of an agent that says `DONE` at once."""
    environment, paid = make(name, reward=reward, gamma=0.9, until="done"), []
    for task_id in list_playable_tasks(environment):
        environment.reset(seed=0, options={"task_id": task_id})
        paid.append(environment.step(DONE)[1])
    return mean(paid)


def count_steps_to_win(name: str, observe: Observe, sweeps: int) -> list[int]:
    """Return the number of steps after which a random agent won each episode.

    An episode that it did not win has the maximum number of steps plus one.
    """
    feedback = "facts" if observe == "partial" else "outcome"
    environment = make(name, observe=observe, feedback=feedback, admissible=True, max_steps=STEPS[-1])
    steps = []
    for sweep in range(sweeps):
        rng = Random(sweep)  # noqa: S311 - chance, not secrets
        for task_id in list_playable_tasks(environment):
            _, info = environment.reset(seed=sweep, options={"task_id": task_id})
            taken, over = 0, False
            while not over:
                command = rng.choice(info["admissible_commands"])
                _, _, terminated, truncated, info = environment.step(command)
                taken, over = taken + 1, terminated or truncated
            steps.append(taken if info["won"] else taken + 1)
    return steps


def main() -> None:
    """Print the rewards of null answers and the wins of the random agent."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--suite", default="", help="a part of DOMAIN/ABILITY, such as virtualhome/goal")
    parser.add_argument(
        "--sweeps", type=int, default=10, help="how often the agent plays each task; 0: never"
    )
    parser.add_argument("--declining", default="", help="generated pairs or ambiguous tasks: these alone")
    add_write_option(parser)
    arguments, rows = parser.parse_args(), []
    print("| suite | answer |", *[f"`{shaping.value}` |" for shaping in Shaping])
    if arguments.declining:
        suite = open_suite(arguments.declining, Ability.ACTION_SEQUENCING)
        for called, answer in make_declining_answers(suite):
            print(
                f"| {suite.domain} | {called} |",
                *[f"{v:.3f} |" for v in measure_mean_reward(suite, answer).values()],
            )
        return
    for name, ability in product(HOUSEHOLDS, PAPER_ABILITIES):
        if arguments.suite in f"{name}/{ability.value}":
            suite = open_suite(name, ability)
            for called, answer in list_null_answers(suite):
                earned = measure_mean_reward(suite, answer)
                row = [get_suite_title(name, ability.value), called]
                print(f"| {' | '.join([*row, *(f'{value:.3f}' for value in earned.values())])} |", flush=True)
                if called in SHOWN:
                    values = [earned[shaping] for shaping in Shaping if shaping is not Shaping.REPAIR]
                    rows.append([*row, *(f"{value:.3f}" for value in values)])
    if arguments.write:
        write_rows("null_rewards", rows, keys=2)
    for name in HOUSEHOLDS if arguments.sweeps else ():
        print(name, {reward.value: compute_reward_of_immediate_done(name, reward) for reward in Shaping})
        for observe in get_args(Observe):
            steps = count_steps_to_win(name, observe, arguments.sweeps)
            won = {most: f"{100 * sum(step <= most for step in steps) / len(steps):.1f} %" for most in STEPS}
            print(name, observe, f"{len(steps)} episodes, won after steps:", won, flush=True)
