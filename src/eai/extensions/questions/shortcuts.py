"""Shortcuts: answering without knowledge of the world. Choices are drawn so that shortcuts stay near chance.

The module also measures the entropy of gold answers and the rates that guessing and shortcuts reach.
"""

from __future__ import annotations

import math
import random
import re
from bisect import bisect_left, bisect_right, insort
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import NamedTuple, TypeAlias

from eai.base.grouping import group_pairs
from eai.extensions.questions.question import Form, Kind, Question, gold_text, grade
from eai.extensions.questions.setting import Item, Setting
from eai.results.rate import Rate, rate_of
from eai.tasks.share import Share

LETTERS = "ABCD"
"""Letters of the choices."""

_TEMPTING = 0.5
"""Probability that a yes-no question uses the most tempting statement."""

_DRAWS = 24
"""Maximum number of draws of choices until no shortcut gains."""

_NAME = re.compile(r"\w+(?:[.-]\w+)*")

_WHOLE = 12
"""Weight of a trait that one statement has alone. Statements that share a trait share the weight equally."""

_SLACK = 6
"""Tolerated imbalance of all traits together: the sum of squared differences, in questions."""

_GROWTH = 10
"""Number of questions after which the tolerated imbalance grows by one."""

_TIMES = 5
"""Maximum counted occurrences of a statement's names in the question's text."""


SHORTCUTS = ("names", "longest", "operator", "text", "unchanged")
"""Names of the shortcuts, which answer without knowledge of the world.

For choices: ``names``: the choice that shares most names with the others. ``longest``: the longest choice.
``text``: the choice with most names in the question's text. ``unchanged``: a fact that holds before the
actions. ``operator``: the choice whose operator or predicate was right most often in earlier questions.

For yes or no: the more frequent answer to earlier statements with the same operator, number of names in the
text, length class, or value before the actions. ``names`` guesses.
"""


class _Look(NamedTuple):
    """Superficial features of a statement.

    Attributes:
        names: the names in the statement.
        mentioned: number of its names that occur in the question's text.
        often: total number of their occurrences there.
        length: number of characters.
        holds: whether the statement is a fact that holds before the actions.
        labels: its operator or predicate, and further labels that group it.
    """

    names: frozenset[str]
    mentioned: int
    often: int
    length: int
    holds: bool
    labels: tuple[str, ...]


def glance_at(
    asked: str, holding: Collection[str], about: Mapping[str, Sequence[str]]
) -> Callable[[str], _Look]:
    """Return a function that reads the superficial features of a statement.

    Args:
        asked: the text of the question without the statements.
        holding: texts of the facts that hold before the actions.
        about: labels of texts that do not begin with their operator or predicate.
    """
    mentioned = Counter(_NAME.findall(asked))

    @cache
    def look(text: str) -> _Look:
        names = frozenset(_NAME.findall(text))
        return _Look(
            names,
            sum([name in mentioned for name in names]),
            sum([mentioned[name] for name in names]),
            len(text),
            text in holding,
            tuple(about.get(text, (text.partition("(")[0],))),
        )

    return look


class Posed(NamedTuple):
    """A question in closed form.

    Attributes:
        shown: the choices, or the single statement of a yes-no question.
        right: position of the right text; None if the statement is wrong.
        glance: reads the superficial features of a text.
    """

    shown: Sequence[str]
    right: int | None
    glance: Callable[[str], _Look]


_Trait: TypeAlias = tuple[str, str]
"""A shortcut and a label of the trait that it uses."""


class Ledger:
    """Counts how often statements with each trait were right, in the questions of one kind and form so far.

    A trait is in balance if its statements are right as often as guesses are.
    """

    def __init__(self) -> None:
        self._balance: Counter[_Trait] = Counter()
        self._right: Counter[_Trait] = Counter()
        self._times: Counter[_Trait] = Counter()
        self._lengths: list[int] = []
        self._questions = 0
        self._imbalance = 0

    def excess(self, posed: Posed) -> int:
        """Return by how much a question would exceed the tolerated imbalance; 0 if it would not."""
        step = self._step(posed)
        if step <= 0:
            return 0
        one = (_WHOLE * (_options(posed) - 1)) ** 2
        return max(0, self._imbalance + step - one * (_SLACK + self._questions // _GROWTH))

    def add(self, posed: Posed) -> Mapping[str, float]:
        """Count a question.

        Returns:
            The credit of each shortcut for the question, given the questions before. It is 1, 0, or a
            fraction for a guess among several choices.
        """
        traits = self._traits(posed)
        hits = {shortcut: self._hit(shortcut, posed, traits) for shortcut in SHORTCUTS}
        self._imbalance += self._step(posed)
        self._balance.update(_weights(posed, traits))
        for place, each in enumerate(traits):
            self._times.update(each.keys())
            self._right.update(each.keys() if place == posed.right else ())
        insort(self._lengths, len(posed.shown[0]))
        self._questions += 1
        return hits

    def _step(self, posed: Posed) -> int:
        """Return the change of the imbalance by a question."""
        weights = _weights(posed, self._traits(posed))
        return sum([weight * (2 * self._balance[trait] + weight) for trait, weight in weights.items()])

    def _hit(self, shortcut: str, posed: Posed, traits: Sequence[Mapping[_Trait, int]]) -> float:
        seen = [next((trait for trait in each if trait[0] == shortcut), None) for each in traits]
        if not any(seen):
            return _share(1, _options(posed))
        if len(seen) == 1:
            yes = self._rate(seen[0], 2)
            scores, right = [yes, 1 - yes], 1 if posed.right is None else 0
        else:
            learned = shortcut == "operator"
            alone = (shortcut, "")
            scores = [
                self._rate(trait, len(seen)) if learned else alone in each
                for trait, each in zip(seen, traits, strict=True)
            ]
            right = posed.right or 0
        best = max(scores)
        return _share(scores[right] == best, scores.count(best))

    def _rate(self, trait: _Trait | None, options: int) -> float:
        """Return how often statements with a trait were right, smoothed by one observation at chance."""
        if trait is None:
            return _share(1, options)
        return _share(self._right[trait] * options + 1, (self._times[trait] + 1) * options)

    def _traits(self, posed: Posed) -> list[dict[_Trait, int]]:
        """Return the traits of each statement with their weights."""
        looks = [posed.glance(text) for text in posed.shown]
        found = [dict.fromkeys([("operator", label) for label in look.labels], _WHOLE) for look in looks]
        if len(looks) == 1:
            (look,) = looks
            found[0] |= {
                ("text", f"{look.mentioned} of {len(look.names)}"): _WHOLE,
                ("text", f"{min(look.often, _TIMES)} times"): _WHOLE,
                ("longest", self._size(look.length)): _WHOLE,
                ("unchanged", str(look.holds)): _WHOLE,
            }
            return found
        marked: Mapping[_Trait, Sequence[int]] = {
            ("names", ""): [
                sum([len(one.names & other.names) for other in looks]) - len(one.names) for one in looks
            ],
            ("longest", ""): [look.length for look in looks],
            ("longest", "not"): [-look.length for look in looks],
            ("text", ""): [look.mentioned for look in looks],
            ("text", "all times"): [look.often for look in looks],
            ("unchanged", ""): [look.holds for look in looks],
        }
        for trait, marks in marked.items():
            best = max(marks)
            part = _WHOLE // marks.count(best)
            for traits, mark in zip(found, marks, strict=True):
                if mark == best:
                    traits[trait] = part
        return found

    def _size(self, length: int) -> str:
        """Return whether a statement is longer or shorter than most statements so far."""
        shorter = bisect_left(self._lengths, length)
        longer = len(self._lengths) - bisect_right(self._lengths, length)
        return "long" if shorter > longer else "short" if shorter < longer else "medium"


def _weights(posed: Posed, traits: Sequence[Mapping[_Trait, int]]) -> dict[_Trait, int]:
    """Return what a question adds to the balance of each trait; the expected sum of a guess is 0."""
    weights: dict[_Trait, int] = {}
    for place, each in enumerate(traits):
        for trait, part in each.items():
            weight = part * (_options(posed) - 1) if place == posed.right else -part
            weights[trait] = weights.get(trait, 0) + weight
    return weights


def _options(posed: Posed) -> int:
    return max(2, len(posed.shown))


def _share(part: float, whole: float) -> float:
    return Rate(part, whole).share or 0.0


def pose(
    item: Item, setting: Setting, form: Form, asked: str, ledger: Ledger, rng: random.Random, turn: int
) -> tuple[int, Posed] | None:
    """Draw choices so that no shortcut gains; return the remaining excess and the question.

    None if the item has too few texts.

    Args:
        item: the content of the question.
        setting: the material of the task.
        form: yes or no, or a choice.
        asked: the text of the question without the choices.
        ledger: counts of the questions before.
        rng: the random generator.
        turn: selects the letter or the yes or no that is right.
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
    glance = glance_at(asked, holding, item.about)
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


def _statement(among: Sequence[str], rng: random.Random) -> str:
    return rng.choice(among[:1] if rng.random() < _TEMPTING else among)


def _choices(item: Item, rng: random.Random, place: int) -> list[str]:
    """Draw wrong texts that resemble each other as much as the right text, and insert the right text."""
    right = rng.choice(item.right)
    alike = [each for each in _alike(right, item.wrong, rng) if len(each) >= len(LETTERS) - 1]
    shown = rng.sample(rng.choice(alike) if alike else item.wrong, len(LETTERS) - 1)
    shown.insert(place, right)
    return shown


def _alike(right: str, wrong: Sequence[str], rng: random.Random) -> Iterator[Sequence[str]]:
    """Yield sets of wrong texts that differ from each other as they differ from the right text.

    All share its name, or all share its arguments, or two names and two arguments are combined in four ways.
    """
    name, _, arguments = right.partition("(")
    far = rng.choice(wrong)
    other, _, others = far.partition("(")
    yield [each for each in wrong if each.partition("(")[0] == name]
    yield [each for each in wrong if each.partition("(")[2] == arguments]
    if other != name and others != arguments:
        yield [each for each in (far, f"{name}({others}", f"{other}({arguments}") if each in wrong]


GUESS = "guess"
"""Name of guessing, listed beside the shortcuts."""


def entropy_of(questions: Sequence[Question], kind: Kind, form: Form) -> float | None:
    """Return the entropy of the answers to questions of a kind and form; None for fewer than two questions.

    It is a share of the maximum, which equally frequent answers reach. Possible answers are yes and no, the
    letters, or the outcomes of a plan; in other open questions, the different answers that occur.
    """
    chosen = [question for question in questions if question.kind is kind and question.form is form]
    if len(chosen) < 2:
        return None
    counts = Counter(map(_label, chosen))
    shares = [Rate(times, len(chosen)).share or 0.0 for times in counts.values()]
    most = max([question.options for question in chosen]) or len(counts)
    entropy = 0.0 - sum([share * math.log2(share) for share in shares])
    return Rate(entropy, math.log2(most)).share if most > 1 else 0.0


def _label(question: Question) -> tuple[str, ...]:
    """Return the answer as a class. An outcome of a plan counts only as works, fails or misses a goal."""
    if question.form is Form.OPEN and question.kind in (Kind.COUNTERFACTUAL, Kind.VALIDATION):
        return (question.answer[0].partition(" ")[0],)
    return question.answer


def guesses_of(questions: Sequence[Question]) -> dict[str, float]:
    """Return the probability that a guess is right, by id of the question.

    A guess is a random choice. In open form, it is the most frequent answer.
    """
    common = _common_answers(questions)
    return {
        question.id: Rate(1, question.options).share or float(grade(question, common[question.kind]).exact)
        for question in questions
    }


def chances_of(questions: Sequence[Question], guesses: Mapping[str, float]) -> dict[str, Rate]:
    """Return the rates of guessing and of each shortcut, by name. Guessing stands in for an absent shortcut.

    Args:
        questions: the questions.
        guesses: the probability that a guess is right, by id of the question.
    """
    names = dict.fromkeys([GUESS, *(name for question in questions for name in question.shortcuts)])
    return {
        name: rate_of([Share(each.shortcuts.get(name, guesses[each.id]), 1) for each in questions])
        for name in names
    }


def best_chance(chances: Mapping[str, Rate]) -> str:
    """Return the name with the highest rate; guessing wins ties."""
    return max(chances, key=lambda name: chances[name].numerator)


def _common_answers(questions: Iterable[Question]) -> dict[Kind, str]:
    """Return the most frequent gold answer of each kind in open form; the first one wins ties."""
    golds = group_pairs((each.kind, gold_text(each)) for each in questions if each.form is Form.OPEN)
    counts = {kind: Counter(golds.get(kind, ())) for kind in Kind}
    return {kind: max(count, key=count.__getitem__, default="") for kind, count in counts.items()}
