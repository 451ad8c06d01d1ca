"""Items put into words: a form, templates and the facts of a setting make a prompt with its gold answer."""

from __future__ import annotations

import random
from collections.abc import Collection, Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

from eai.prompts.template import Templates
from eai.questions.question import Accept, Form, Kind
from eai.questions.setting import Item, Setting, listed
from eai.questions.shortcuts import Glance, Ledger, Posed

LETTERS = "ABCD"
"""The letters of choices."""

_TEMPTING = 0.5
"""How often a statement is the most tempting one there is."""

_BLOCKS = 16
"""After how many times all letters their order repeats itself."""

_DRAWS = 24
"""How often what is shown is drawn for one that no shortcut gains by."""

_ABOUT_RULES = frozenset(
    [*((Kind.WHY_NOT, form) for form in Form), (Kind.COUNTERFACTUAL, Form.OPEN), (Kind.VALIDATION, Form.OPEN)]
)
"""The kinds and forms that ask of requirements by their numbers, which the rules alone tell."""


def can_be_closed(kind: Kind, form: Form) -> bool:
    """Whether questions of a kind and form can be asked without the rules."""
    return (kind, form) not in _ABOUT_RULES


class Phrased(NamedTuple):
    """A question in words.

    Attributes:
        prompt: what is asked.
        closed: the same without the rules; None where it speaks of requirements by their numbers.
        answer: the gold answers.
        accept: whether all of these are wanted.
        options: how many answers there are to choose from; 0 where there are none.
    """

    prompt: str
    closed: str | None
    answer: tuple[str, ...]
    accept: Accept
    options: int


def pose(
    item: Item, setting: Setting, form: Form, asked: str, ledger: Ledger, rng: random.Random, turn: int
) -> tuple[int, Posed] | None:
    """The choices that are shown, drawn so that no shortcut gains; None if an item has too few.

    Args:
        item: what is asked.
        setting: what it is asked of.
        form: yes or no, or a choice.
        asked: the text of the question without this.
        ledger: what shortcuts get of the questions before.
        rng: draws.
        turn: which answer's turn it is to be the right one.
    """
    is_right, place = turn % 2 == 0, turn % len(LETTERS)
    among = item.right if is_right else item.wrong
    if item.yes_no is not None:
        among = [text for text in among if text in item.yes_no]
    if form is Form.YES_NO and not among:
        return None
    if form is Form.CHOICE and not (item.right and len(item.wrong) >= len(LETTERS) - 1):
        return None
    holding = () if item.actions or item.about else frozenset(map(setting.text_of, setting.facts(item.state)))
    glance = Glance(asked, holding, item.about)
    best: tuple[int, Posed] | None = None
    for _ in range(_DRAWS):
        if form is Form.YES_NO:
            posed = Posed([_statement(among, rng)], 0 if is_right else None, glance)
        else:
            posed = Posed(_choices(item, rng, place), place, glance)
        excess = ledger.excess(posed)
        if best is None or excess < best[0]:
            best = excess, posed
        if not excess:
            break
    return best


def question_text(
    item: Item, setting: Setting, kind: Kind, form: Form, templates: Templates, written: str = ""
) -> str:
    """The text of a question, with what there is to choose from if that is given."""
    fluents = ", ".join(sorted(setting.rules.fluents))
    values = {**item.values, "statement": written, "choices": written, "fluents": fluents}
    return templates.fill(f"questions/{kind.value}.{form.value}.txt", values)


def phrase(
    item: Item, setting: Setting, kind: Kind, form: Form, templates: Templates, posed: Posed | None
) -> Phrased:
    """An item as a question of a form.

    Args:
        item: what is asked.
        setting: what it is asked of.
        kind: its kind.
        form: the form.
        templates: the texts of prompts.
        posed: what there is to choose from; None in open form.
    """
    shown = [] if posed is None else posed.shown
    right = None if posed is None else posed.right
    match form:
        case Form.OPEN:
            written, answer = "", tuple(item.answer)
        case Form.YES_NO:
            written, answer = shown[0], ("no" if right is None else "yes",)
        case Form.CHOICE:
            written = "\n".join([f"{letter}. {text}" for letter, text in zip(LETTERS, shown, strict=True)])
            answer = (LETTERS[right or 0],)
    shown_operators = {text.partition("(")[0] for text in shown} if item.actions and shown else item.operators
    accept = item.accept if form is Form.OPEN else Accept.ALL
    prompt = {
        "objects": _objects(setting),
        "facts": _facts(setting, item, shown_operators),
        "rules": setting.rules.text(shown_operators, item.formulas),
        "actions": setting.rules.heads(shown_operators),
        "question": question_text(item, setting, kind, form, templates, written),
        "answer": templates.text(f"questions/answer.{'any' if accept is Accept.ANY else form.value}.txt"),
    }
    return Phrased(
        templates.fill("question.txt", prompt),
        templates.fill("closed_book.txt", prompt) if can_be_closed(kind, form) else None,
        answer,
        accept,
        2 if form is Form.YES_NO else len(shown),
    )


def turns(seed: str) -> list[int]:
    """The order in which answers have their turn, over and over.

    Of each four turns two are yes and two no, and each letter has one.
    """
    rng = random.Random(seed)  # noqa: S311 - chance, not secrets
    return [turn for _ in range(_BLOCKS) for turn in rng.sample(range(len(LETTERS)), len(LETTERS))]


def _statement(among: Sequence[str], rng: random.Random) -> str:
    return rng.choice(among[:1] if rng.random() < _TEMPTING else among)


def _choices(item: Item, rng: random.Random, place: int) -> list[str]:
    """A right text at a place among wrong ones that have as much in common with it as with each other."""
    right = rng.choice(item.right)
    alike = [each for each in _alike(right, item.wrong, rng) if len(each) >= len(LETTERS) - 1]
    shown = rng.sample(rng.choice(alike) if alike else item.wrong, len(LETTERS) - 1)
    shown.insert(place, right)
    return shown


def _alike(right: str, wrong: Sequence[str], rng: random.Random) -> Iterator[Sequence[str]]:
    """Wrong texts that differ from each other as they do from the right one.

    All have its name, or all its arguments; or two names and two arguments are combined in all four ways.
    """
    name, _, arguments = right.partition("(")
    far = rng.choice(wrong)
    other, _, others = far.partition("(")
    yield [each for each in wrong if each.partition("(")[0] == name]
    yield [each for each in wrong if each.partition("(")[2] == arguments]
    if other != name and others != arguments:
        yield [each for each in (far, f"{name}({others}", f"{other}({arguments}") if each in wrong]


def _objects(setting: Setting) -> str:
    agent = setting.scene.agent
    return listed(
        [
            f"{thing.name} [{thing.category}]{', the agent' if i == agent else ''}"
            for i, thing in enumerate(setting.scene.objects)
        ]
    )


def _facts(setting: Setting, item: Item, operators: Collection[str]) -> str:
    """The facts that hold: all that can change, and of the rest those that decide the rules.

    A predicate has a line, in which ``p(a, {b, c})`` stands for ``p(a, b)`` and ``p(a, c)``.
    """
    shown = setting.rules.fluents | setting.rules.predicates(operators, item.formulas)
    names = [thing.name for thing in setting.scene.objects]
    lines: dict[str, list[str]] = {}
    facts = [fact for fact in item.state.facts() if fact.predicate in shown]
    for (predicate, first), alike in groupby(facts, lambda fact: (fact.predicate, fact.arguments[:-1])):
        last = [[names[i] for i in fact.arguments[-1:]] for fact in alike]
        if first and len(last) > 1:
            last = [["{" + ", ".join([name for (name,) in last]) + "}"]]
        before = [names[i] for i in first]
        texts = [f"{predicate}({', '.join([*before, *each])})" for each in last]
        lines.setdefault(predicate, []).extend(texts)
    return listed([", ".join(texts) for texts in lines.values()]) or "- nothing"
