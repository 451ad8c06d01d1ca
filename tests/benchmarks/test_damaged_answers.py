"""A damaged answer is read completely or not at all, never in part.

Gold answers of every suite are damaged at random. Then as many parts (steps, goals, subgoals, operators) are
read as were written, or the answer is a parsing error. An ill-formed goal counts as a part.
"""

from __future__ import annotations

import random
import re
from collections import Counter
from collections.abc import Callable, Iterator

import pytest

from by_path import TESTS
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.goal_interpretation.scorer import GoalInterpretationScorer
from eai.abilities.protocol import Ability
from eai.abilities.scorer import Scorer
from eai.abilities.subgoal_decomposition.scorer import SubgoalDecompositionScorer
from eai.abilities.transition_modeling.extraction import ResultCache, read_operators
from eai.abilities.verdict import Unreadable
from eai.base.store import DataPackStore
from eai.benchmarks.gold_answers import AnswerInParts, open_answers_of_planner, open_gold_answers
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice
from eai.tasks.source import Source
from suites import SUITES
from sweeps import sweep

DOMAINS = TESTS / "pddl" / "domains"
BLOCKS = f"pddl:{DOMAINS / 'gripper' / 'domain.pddl'},{DOMAINS / 'gripper'}"

Damage = Callable[[AnswerInParts, random.Random], str]


def cut_end(answer: AnswerInParts, lots: random.Random) -> str:
    return answer.text[: lots.randrange(1, len(answer.text))]


def remove_sign(answer: AnswerInParts, lots: random.Random) -> str:
    position = lots.choice([match.start() for match in re.finditer(r"[^\w\s]", answer.text)])
    return answer.text[:position] + answer.text[position + 1 :]


def insert_bracket(answer: AnswerInParts, lots: random.Random) -> str:
    position = lots.randrange(len(answer.text))
    return answer.text[:position] + lots.choice("[](){}") + answer.text[position:]


def remove_letter(answer: AnswerInParts, lots: random.Random) -> str:
    position = lots.choice([match.start() for match in re.finditer(r"\w", answer.text)])
    return answer.text[:position] + answer.text[position + 1 :]


def malform_step(answer: AnswerInParts, lots: random.Random) -> str:
    parts = list(answer.parts)
    number = lots.randrange(len(parts))
    parts[number] = lots.choice(
        [
            parts[number].replace(",", "", 1),
            parts[number].replace('"', "", 2),
            re.sub(r"(?<=\w)[\[(].*[\])]", "1", parts[number], count=1, flags=re.DOTALL),
            parts[number].replace("(", "", 1),
            parts[number][: len(parts[number]) // 2],
        ]
    )
    return replace_parts(answer, parts)


def remove_brackets(answer: AnswerInParts, lots: random.Random) -> str:
    parts = list(answer.parts)
    number = lots.randrange(len(parts))
    parts[number] = re.sub(r"[\[\](){}]", "", parts[number])
    return replace_parts(answer, parts)


def misspell_key(answer: AnswerInParts, lots: random.Random) -> str:
    keys = list(re.finditer(r'"(\w[\w ]*)"(?=\s*:)|(?<=:)\w+', answer.text)) or list(
        re.finditer(r"\w+", answer.text)
    )
    key = lots.choice(keys)
    position = lots.randrange(key.start() + 1, key.end() - 1) if len(key[0]) > 2 else key.start()
    return answer.text[:position] + lots.choice(["x", "_", ""]) + answer.text[position + 1 :]


def append_text(answer: AnswerInParts, lots: random.Random) -> str:
    return answer.text + lots.choice(
        ["\n\nThis plan reaches the goal.", "}", "]", " Note: [1] holds.", "\n```"]
    )


def replace_parts(answer: AnswerInParts, parts: list[str]) -> str:
    """Return the gold answer with changed parts."""
    text = answer.text
    for old, new in zip(answer.parts, parts, strict=True):
        if old != new:
            text = text.replace(old, new, 1)
    return text


def write_lines(answer: AnswerInParts) -> AnswerInParts:
    """Return a plan as JSON lines: one object a line, without a list around them."""
    parts = [part if part.startswith("{") else f"{{{part}}}" for part in answer.parts]
    return AnswerInParts(tuple(parts), "\n".join)


DAMAGES: tuple[Damage, ...] = (
    cut_end,
    remove_sign,
    insert_bracket,
    remove_letter,
    malform_step,
    remove_brackets,
    misspell_key,
    append_text,
)


def count_parts(scorer: Scorer, text: str) -> int | None:
    """Return the number of parts that are read from an answer, or None if it cannot be read."""
    match scorer:
        case ActionSequencingScorer():
            plan = scorer.read(text)
            return None if isinstance(plan, Unreadable) else len(plan.steps)
        case GoalInterpretationScorer():
            goals = scorer.notation.read(text)
            return None if isinstance(goals, Unreadable) else len(goals.goals) + len(goals.ill_formed)
        case SubgoalDecompositionScorer():
            subgoals = scorer.notation.read(text)
            return None if isinstance(subgoals, Unreadable) else len(subgoals.subgoals)
        case _:
            operators = read_operators(text, ResultCache())
            return None if isinstance(operators, Unreadable) else len(operators.value)


def damage_answers(
    name: str, ability: Ability, source: Source, number: int
) -> Iterator[tuple[str, Scorer, str, str]]:
    """Yield the name of each damage, a scorer, a gold answer and the damaged answer."""
    benchmark = find_benchmark(name)
    opened = open_answers_of_planner if name == BLOCKS else open_gold_answers
    book = opened(benchmark, ability, source)
    suite = open_suite(benchmark, ability, source=source)
    task_ids = [task_id for task_id in book if book[task_id].parts]
    for seed in range(number):
        task_id = task_ids[seed % len(task_ids)]
        damage = DAMAGES[seed % len(DAMAGES)]
        answer = book[task_id]
        yield damage.__name__, suite.scorer(task_id), answer.text, damage(answer, random.Random(seed))


@pytest.mark.parametrize("number", [105, pytest.param(2000, marks=sweep)])
@pytest.mark.parametrize("name", ["virtualhome", "behavior"])
def test_damaged_json_lines_are_read_completely_or_not_at_all(
    data_store: DataPackStore, name: str, number: int
) -> None:
    """Cutting the end is left out: a cut between two lines leaves a complete answer."""
    source = Source(data_store)
    suite = open_suite(name, Ability.ACTION_SEQUENCING, source=source)
    book = open_gold_answers(find_benchmark(name), Ability.ACTION_SEQUENCING, source)
    task_ids = [task_id for task_id in book if book[task_id].parts]
    for seed in range(number):
        task_id, damage = task_ids[seed % len(task_ids)], DAMAGES[1 + seed % (len(DAMAGES) - 1)]
        answer = write_lines(book[task_id])
        text = damage(answer, random.Random(seed))
        assert count_parts(suite.scorer(task_id), text) in (None, len(answer.parts)), text


@pytest.mark.parametrize("number", [210, pytest.param(2000, marks=sweep)])
@pytest.mark.parametrize(("name", "ability"), [*SUITES, (BLOCKS, Ability.ACTION_SEQUENCING)])
def test_a_damaged_answer_is_read_completely_or_not_at_all(
    data_store: DataPackStore, name: str, ability: Ability, number: int
) -> None:
    source = Source(data_store, planner=PlannerChoice.NONE)
    parts: list[tuple[str, str]] = []
    outcomes: Counter[str] = Counter()
    for damage, scorer, gold, text in damage_answers(name, ability, source, number):
        read, written = count_parts(scorer, text), count_parts(scorer, gold) or 0
        is_whole = read == written or (
            ability is Ability.GOAL_INTERPRETATION and (read or 0) > (written or 0)
        )
        outcomes["unreadable" if read is None else "whole"] += 1
        if read is not None and not is_whole:
            parts.append((damage, text))
    assert parts == []
    assert min(outcomes["unreadable"], outcomes["whole"]) > number // 10
