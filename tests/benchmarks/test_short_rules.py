"""The rules of the prompt set ``short``, which are written by hand, state every check of every action."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from eai.benchmarks.registry import find_benchmark

PHRASES = Path(__file__).parent / "golden" / "short_rules.tsv"
"""For each benchmark and reason of a failed check: the words that state the check, with alternatives."""

NAMES = ("virtualhome", "behavior", "behavior-1k")
_HEAD = re.compile(r"([A-Z][A-Z_]*)\(([a-z, ]*)\)")


def read_rules(name: str) -> tuple[Mapping[tuple[str, int], str], str]:
    """Return the rule of each action, by name and number of parameters, and the rules of all actions."""
    general, *lines = find_benchmark(name).notation.short_texts["rules"].splitlines()
    rules = {head: line for line in lines for head in _read_heads(line)}
    return rules, "\n".join([general, *[line for line in lines if not _HEAD.match(line)]])


def _read_heads(line: str) -> Iterator[tuple[str, int]]:
    heads = line.partition(":")[0]
    for action, parameters in _HEAD.findall(heads):
        arity = len(parameters.split(", ")) if parameters else 0
        sides = ("LEFT_", "RIGHT_") if action.startswith("H_") else ("",)
        yield from ((side + action.removeprefix("H_"), arity) for side in sides)


@pytest.mark.parametrize("name", NAMES)
def test_short_rules_have_every_action_with_its_parameters(name: str) -> None:
    rules, _ = read_rules(name)
    assert rules.keys() == {
        (operator.name, operator.arity) for operator in find_benchmark(name).domain.operators
    }


@pytest.mark.parametrize("name", NAMES)
def test_short_rules_state_every_check(name: str) -> None:
    rules, general = read_rules(name)
    rows = [line.split("\t") for line in PHRASES.read_text(encoding="utf-8").splitlines()]
    phrases = {reason: words.split("|") for of, reason, words in rows if of == name}
    missing, used = [], set()
    for operator in find_benchmark(name).domain.operators:
        text = f"{rules[operator.name, operator.arity]}\n{general}"
        checks = (*operator.checks, *(check for attempt in operator.alternatives for check in attempt.checks))
        for check in checks:
            used.add(check.reason)
            if not any(words in text for words in phrases.get(check.reason, ())):
                missing.append((operator.name, check.reason))
    assert missing == []
    assert phrases.keys() == used, "a listed reason is no reason of a check"


def test_an_action_without_a_check_in_its_rule_is_noticed() -> None:
    rules, general = read_rules("virtualhome")
    assert "not shut in" in rules["GRAB", 1]
    assert "not shut in" not in f"{rules['EAT', 1]}\n{general}"
