"""Shortcuts: answers that take no knowledge of the world, kept near chance while questions are written.

The balance of gold answers says how even they are, and what can be had of them without knowing the world.
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
"""The letters of choices."""

_TEMPTING = 0.5
"""How often a statement is the most tempting one there is."""

_DRAWS = 24
"""How often choices are drawn to find some that no shortcut gains by."""

_NAME = re.compile(r"\w+(?:[.-]\w+)*")

_WHOLE = 12
"""A trait that one statement has alone; of several that have it in common each has an equal part."""

_SLACK = 6
"""How far traits may be out of balance all together: the sum of squares of how many questions they are."""

_GROWTH = 10
"""After how many questions it may be one more."""

_TIMES = 5
"""From how many times on that names of a statement stand in the text it is all the same how often they do."""


SHORTCUTS = ("names", "longest", "operator", "text", "unchanged")
"""The names of the shortcuts, ways to answer without knowing the world.

Of several choices: ``names``: the one that shares most names with the others. ``longest``: the longest.
``text``: the one of which most names stand in the text of the question. ``unchanged``: a fact that holds
before. ``operator``: the one whose operator, or predicate, was right most often in the questions before.

Yes or no: what was right more often in the questions before, for statements with this operator, with as many
names in the text, longer (or not) than most, or that held before (or not); ``names`` guesses.
"""


class _Look(NamedTuple):
    """The look of a statement.

    Attributes:
        names: the names in it.
        mentioned: how many of them stand in the text of the question.
        often: how often they stand there.
        length: how long it is.
        holds: whether it holds when it is asked.
        labels: its operator or predicate, and what else sorts it.
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
    """The look of statements beside a question without thinking of the world.

    Args:
        asked: the text of the question without them.
        holding: the facts that hold when it is asked.
        about: the labels of texts that do not begin with their operator or predicate.
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
        shown: the texts to choose from, or the one statement that is right or not.
        right: the place of the one that is right; None if none is.
        glance: what can be seen of them.
    """

    shown: Sequence[str]
    right: int | None
    glance: Callable[[str], _Look]


_Trait: TypeAlias = tuple[str, str]
"""The shortcut that goes by a trait of a statement, and a label that tells several traits of it apart."""


class Ledger:
    """How often statements with each visible trait were right, in the questions of one kind and form so far.

    A trait is in balance if such statements are right as often as guesses are.
    """

    def __init__(self) -> None:
        self._balance: Counter[_Trait] = Counter()
        self._right: Counter[_Trait] = Counter()
        self._times: Counter[_Trait] = Counter()
        self._lengths: list[int] = []
        self._questions = 0
        self._imbalance = 0

    def excess(self, posed: Posed) -> int:
        """By how much a question would bring traits out of balance beyond what is tolerated, or 0."""
        step = self._step(posed)
        if step <= 0:
            return 0
        one = (_WHOLE * (_options(posed) - 1)) ** 2
        return max(0, self._imbalance + step - one * (_SLACK + self._questions // _GROWTH))

    def add(self, posed: Posed) -> Mapping[str, float]:
        """Take note of a question.

        Returns:
            How much of it each shortcut, by name, gets right that knows the questions before: all, nothing,
            or a part where it has to guess among several.
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
        """By how much a question changes the imbalance."""
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
        """How often statements with a trait were right so far, with chance as if seen once."""
        if trait is None:
            return _share(1, options)
        return _share(self._right[trait] * options + 1, (self._times[trait] + 1) * options)

    def _traits(self, posed: Posed) -> list[dict[_Trait, int]]:
        """The traits of each statement, with the part that it has of each."""
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
        """Whether a statement is longer or shorter than half of those before."""
        shorter = bisect_left(self._lengths, length)
        longer = len(self._lengths) - bisect_right(self._lengths, length)
        return "long" if shorter > longer else "short" if shorter < longer else "medium"


def _weights(posed: Posed, traits: Sequence[Mapping[_Trait, int]]) -> dict[_Trait, int]:
    """The addition of a question to the balance of each trait, so that chance adds up to nothing."""
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


GUESS = "guess"
"""The name of guessing beside the shortcuts."""


def entropy_of(questions: Sequence[Question], kind: Kind, form: Form) -> float | None:
    """The entropy of the answers to the questions of a kind and form; None if there are fewer than two.

    It is a share of what it would be if all possible answers were equally frequent: yes and no, the letters,
    what can become of a plan, else in open form as many different ones as there are.
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
    """The answer; of what becomes of a plan only whether it works, fails at a step or misses a goal."""
    if question.form is Form.OPEN and question.kind in (Kind.COUNTERFACTUAL, Kind.VALIDATION):
        return (question.answer[0].partition(" ")[0],)
    return question.answer


def guesses_of(questions: Sequence[Question]) -> dict[str, float]:
    """How often guessing hits each question, by id: at random; in open form with the most common answer."""
    common = _common_answers(questions)
    return {
        question.id: Rate(1, question.options).share or float(grade(question, common[question.kind]).exact)
        for question in questions
    }


def chances_of(questions: Sequence[Question], guesses: Mapping[str, float]) -> dict[str, Rate]:
    """The rates of guessing and of each shortcut, by name; where there is no shortcut it guesses.

    Args:
        questions: the questions.
        guesses: how often guessing hits each, by id.
    """
    names = dict.fromkeys([GUESS, *(name for question in questions for name in question.shortcuts)])
    return {
        name: rate_of([Share(each.shortcuts.get(name, guesses[each.id]), 1) for each in questions])
        for name in names
    }


def best_chance(chances: Mapping[str, Rate]) -> str:
    """The name of what gives most; guessing, if nothing gives more."""
    return max(chances, key=lambda name: chances[name].numerator)


def _common_answers(questions: Iterable[Question]) -> dict[Kind, str]:
    """The gold answer that most questions in open form of each kind have; of several the first."""
    golds = group_pairs((each.kind, gold_text(each)) for each in questions if each.form is Form.OPEN)
    counts = {kind: Counter(golds.get(kind, ())) for kind in Kind}
    return {kind: max(count, key=count.__getitem__, default="") for kind, count in counts.items()}
