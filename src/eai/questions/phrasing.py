"""Items put into words: a form, templates and the facts of a setting make a prompt with its gold answer."""

from __future__ import annotations

import random
from collections.abc import Collection, Sequence
from itertools import groupby
from typing import NamedTuple

from eai.prompts.template import Templates
from eai.questions.item import Item, listed
from eai.questions.question import Accept, Form, Kind
from eai.questions.setting import Setting

LETTERS = "ABCD"
"""What choices are called."""

_TEMPTING = 0.5
"""How often a statement is the most tempting one there is."""

_BLOCKS = 16
"""After how many times all letters their order repeats itself."""


class Phrased(NamedTuple):
    """A question in words.

    Attributes:
        prompt: what is asked.
        answer: the gold answers.
        accept: whether all of these are wanted.
        options: how many answers there are to choose from; 0 where there are none.
    """

    prompt: str
    answer: tuple[str, ...]
    accept: Accept
    options: int


class _Posed(NamedTuple):
    """What a form makes of an item: the texts to choose from, how they are written, the answer."""

    shown: Sequence[str]
    written: str
    answer: tuple[str, ...]


def phrase(
    item: Item, setting: Setting, kind: Kind, form: Form, templates: Templates, rng: random.Random, turn: int
) -> Phrased | None:
    """An item as a question of a form; None if it has nothing right, or too little wrong, to choose.

    Args:
        item: what is asked.
        setting: what it is asked of.
        kind: its kind.
        form: the form.
        templates: the texts of prompts.
        rng: chooses what is shown.
        turn: which answer's turn it is to be the right one.
    """
    posed = _posed(item, form, rng, turn)
    if posed is None:
        return None
    chosen = item.actions and posed.shown
    told = {text.partition("(")[0] for text in posed.shown} if chosen else item.operators
    accept = item.accept if form is Form.OPEN else Accept.ALL
    values = {
        **item.values,
        "statement": posed.written,
        "choices": posed.written,
        "fluents": ", ".join(sorted(setting.rules.fluents)),
    }
    prompt = {
        "objects": _objects(setting),
        "facts": _facts(setting, item, told),
        "rules": setting.rules.text(told, item.formulas),
        "question": templates.fill(f"questions/{kind.value}.{form.value}.txt", values),
        "answer": templates.text(f"questions/answer.{'any' if accept is Accept.ANY else form.value}.txt"),
    }
    options = 2 if form is Form.YES_NO else len(posed.shown)
    return Phrased(templates.fill("question.txt", prompt), posed.answer, accept, options)


def turns(seed: str) -> list[int]:
    """The order in which answers have their turn, over and over.

    Of each four turns two are yes and two no, and each letter has one.
    """
    rng = random.Random(seed)  # noqa: S311 - chance, not secrets
    return [turn for _ in range(_BLOCKS) for turn in rng.sample(range(len(LETTERS)), len(LETTERS))]


def _posed(item: Item, form: Form, rng: random.Random, turn: int) -> _Posed | None:
    match form:
        case Form.OPEN:
            return _Posed((), "", tuple(item.answer))
        case Form.YES_NO:
            is_right = turn % 2 == 0
            among = item.right if is_right else item.wrong
            if not among:
                return None
            statement = rng.choice(among[:1] if rng.random() < _TEMPTING else among)
            return _Posed([statement], statement, ("yes" if is_right else "no",))
        case Form.CHOICE:
            if not item.right or len(item.wrong) < len(LETTERS) - 1:
                return None
            shown = rng.sample(item.wrong, len(LETTERS) - 1)
            place = turn % len(LETTERS)
            shown.insert(place, rng.choice(item.right))
            written = "\n".join([f"{letter}. {text}" for letter, text in zip(LETTERS, shown, strict=True)])
            return _Posed(shown, written, (LETTERS[place],))


def _objects(setting: Setting) -> str:
    agent = setting.scene.agent
    return listed(
        [
            f"{thing.name} [{thing.category}]{', the agent' if i == agent else ''}"
            for i, thing in enumerate(setting.scene.objects)
        ]
    )


def _facts(setting: Setting, item: Item, operators: Collection[str]) -> str:
    """What holds: all that can change, and of the rest what decides the rules.

    A predicate has a line, in which ``p(a, {b, c})`` stands for ``p(a, b)`` and ``p(a, c)``.
    """
    told = setting.rules.fluents | setting.rules.predicates(operators, item.formulas)
    names = [thing.name for thing in setting.scene.objects]
    lines: dict[str, list[str]] = {}
    facts = [fact for fact in item.state.facts() if fact.predicate in told]
    for (predicate, first), alike in groupby(facts, lambda fact: (fact.predicate, fact.arguments[:-1])):
        last = [[names[i] for i in fact.arguments[-1:]] for fact in alike]
        if first and len(last) > 1:
            last = [["{" + ", ".join([name for (name,) in last]) + "}"]]
        before = [names[i] for i in first]
        texts = [f"{predicate}({', '.join([*before, *each])})" for each in last]
        lines.setdefault(predicate, []).extend(texts)
    return listed([", ".join(texts) for texts in lines.values()]) or "- nothing"
