"""Shortcuts: rules that answer questions without knowledge of the world, such as "take the longest choice".

Choices are drawn so that each shortcut is right about as often as chance. The module also measures the
entropy of gold answers, and how often guessing and each shortcut are right.
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
from eai.extensions.questions.question import (
    Question,
    QuestionForm,
    QuestionKind,
    format_gold_answer,
    grade_answer,
)
from eai.extensions.questions.setting import QuestionSetting, QuestionWithRightAndWrongTexts
from eai.results.rate import Rate, compute_rate
from eai.tasks.share import Share

LETTERS = "ABCD"
"""Letters that name the choices of a question, in order."""

_TEMPTING_PROBABILITY = 0.5
"""Probability that a yes-no question uses the statement that most readers are likely to misjudge."""

_MAX_DRAWS = 24
"""Maximum number of times that choices are drawn for a question.

Choices are drawn again if shortcuts would be right too often. After the last draw, the best draw is used.
"""

_NAME_PATTERN = re.compile(r"\w+(?:[.-]\w+)*")

_CUE_WEIGHT = 12
"""Amount by which a wrong statement lowers the balance of each of its cues.

A cue is a mark by which a shortcut chooses a statement, such as the greatest length. The balance of a cue is
a counter, which is above 0 if statements with the cue were right more often than chance predicts. In a
question with four choices, a wrong statement lowers the balance by 12, and the right statement raises it by
3 x 12. So if right choices are random, the balance stays at 0 on average. If several statements share a mark
such as the greatest length, they share the amount.
"""

_TOLERATED_BIAS = 6
"""Tolerated bias towards shortcuts in the first `_QUESTIONS_PER_TOLERANCE` questions of a kind and form.

The bias is the sum of the squared balances of all cues (see `_CUE_WEIGHT`). Here, 1 stands for the bias that
a single right statement with a single cue causes.
"""

_QUESTIONS_PER_TOLERANCE = 10
"""Number of questions after which the tolerated bias towards shortcuts (`_TOLERATED_BIAS`) grows by 1."""

_MAX_OCCURRENCES = 5
"""Maximum count of occurrences of a statement's names in the text of a yes-no question.

The shortcut ``text`` (see `SHORTCUTS`) compares statements by this count; larger counts are treated alike.
"""


SHORTCUTS = ("names", "longest", "operator", "text", "unchanged")
"""Names of the shortcuts: rules that answer without knowledge of the world.

For questions with choices, a shortcut takes this choice:
``names``: the choice that shares most names with the other choices. ``longest``: the longest choice.
``text``: the choice with most names that occur in the question's text. ``unchanged``: a fact that holds
before the actions. ``operator``: the choice whose operator or predicate was right most often in earlier
questions.

For yes-no questions, a shortcut takes the answer that was right more often for similar earlier statements.
Similar means: the same operator (``operator``), number of names in the text (``text``), length class
(``longest``), or value before the actions (``unchanged``). ``names`` guesses.
"""


class _StatementTextFeatures(NamedTuple):
    """Superficial features of a statement of a question, which need no knowledge of the world.

    Attributes:
        names: the names of objects, operators and predicates in the statement.
        mentioned_names: number of its names that occur in the question's text.
        mentions: total number of occurrences of its names in the question's text.
        length: number of characters.
        holds: whether the statement is a fact that holds before the actions.
        labels: labels of the groups to which the statement belongs, such as its operator or predicate.
    """

    names: frozenset[str]
    mentioned_names: int
    mentions: int
    length: int
    holds: bool
    labels: tuple[str, ...]


def make_feature_reader(
    question_text: str, initial_facts: Collection[str], labels: Mapping[str, Sequence[str]]
) -> Callable[[str], _StatementTextFeatures]:
    """Return a function that reads the superficial features of a statement.

    Args:
        question_text: the text of the question without the statements.
        initial_facts: texts of the facts that hold before the actions.
        labels: the labels of statements such as ``step 3``, by the text of the statement. A statement without
            an entry is a fact or an action; its label is its predicate or operator. The shortcut ``operator``
            (see `SHORTCUTS`) treats statements with equal labels alike.
    """
    mentioned = Counter(_NAME_PATTERN.findall(question_text))

    @cache
    def read_features(text: str) -> _StatementTextFeatures:
        names = frozenset(_NAME_PATTERN.findall(text))
        return _StatementTextFeatures(
            names,
            sum([name in mentioned for name in names]),
            sum([mentioned[name] for name in names]),
            len(text),
            text in initial_facts,
            tuple(labels.get(text, (text.partition("(")[0],))),
        )

    return read_features


class YesNoOrChoiceQuestion(NamedTuple):
    """A question in closed form: yes or no, or multiple choice.

    Attributes:
        shown: the choices, or the single statement of a yes-no question.
        right: index of the right text in ``shown``; None if the statement of a yes-no question is wrong.
        read_features: returns the superficial features of a text.
    """

    shown: Sequence[str]
    right: int | None
    read_features: Callable[[str], _StatementTextFeatures]


_SurfaceCue: TypeAlias = tuple[str, str]
"""A cue: a mark of a statement, such as the greatest length, by which a shortcut chooses the statement.

The first text is the name of the shortcut (see `SHORTCUTS`), the second describes the mark.
"""


class SurfaceCueCounts:
    """Counts, for each cue, how often statements with the cue were right in earlier questions.

    A cue is a mark of a statement, such as the greatest length. A shortcut is a rule that answers without
    knowledge of the world: it chooses a statement by its cues. The balance of a cue is 0 if statements with
    the cue are right as often as random guesses. The questions have one kind and form.
    """

    def __init__(self) -> None:
        self._balance: Counter[_SurfaceCue] = Counter()
        self._right: Counter[_SurfaceCue] = Counter()
        self._times: Counter[_SurfaceCue] = Counter()
        self._lengths: list[int] = []
        self._questions = 0
        self._bias = 0

    def compute_shortcut_bias_above_limit_if_added(self, question: YesNoOrChoiceQuestion) -> int:
        """Return by how much the shortcut bias would exceed the tolerated bias if a question were added.

        Return 0 if it would not exceed the tolerated bias, or if the question does not raise the bias. A cue
        is a mark of a statement, such as the greatest length. Its balance is 0 if statements with the cue are
        right as often as chance predicts (see `_CUE_WEIGHT`). The bias is the sum of the squared balances of
        all cues.
        """
        step = self._compute_shortcut_bias_change_if_added(question)
        if step <= 0:
            return 0
        one = (_CUE_WEIGHT * (_count_options(question) - 1)) ** 2
        return max(
            0,
            self._bias + step - one * (_TOLERATED_BIAS + self._questions // _QUESTIONS_PER_TOLERANCE),
        )

    def score_shortcuts_and_update_cue_counts(self, question: YesNoOrChoiceQuestion) -> Mapping[str, float]:
        """Add a question to the counts.

        Returns:
            the probability that each shortcut answers the question correctly, by name of the shortcut. It is
            computed from the counts before this question. It is a fraction if several answers
            fit the shortcut, which then guesses one of them.
        """
        cues = self._find_cues_of_each_statement(question)
        hits = {shortcut: self._score_shortcut(shortcut, question, cues) for shortcut in SHORTCUTS}
        self._bias += self._compute_shortcut_bias_change_if_added(question)
        self._balance.update(_compute_balance_changes_by_cue(question, cues))
        for position, statement_cues in enumerate(cues):
            self._times.update(statement_cues.keys())
            self._right.update(statement_cues.keys() if position == question.right else ())
        insort(self._lengths, len(question.shown[0]))
        self._questions += 1
        return hits

    def _compute_shortcut_bias_change_if_added(self, question: YesNoOrChoiceQuestion) -> int:
        weights = _compute_balance_changes_by_cue(question, self._find_cues_of_each_statement(question))
        return sum([weight * (2 * self._balance[cue] + weight) for cue, weight in weights.items()])

    def _score_shortcut(
        self, shortcut: str, question: YesNoOrChoiceQuestion, cues: Sequence[Mapping[_SurfaceCue, int]]
    ) -> float:
        seen = [next((cue for cue in statement_cues if cue[0] == shortcut), None) for statement_cues in cues]
        if not any(seen):
            return _compute_share(1, _count_options(question))
        if len(seen) == 1:
            yes = self._compute_success_rate_of_surface_cue(seen[0], 2)
            scores, right = [yes, 1 - yes], 1 if question.right is None else 0
        else:
            learned = shortcut == "operator"
            unlabelled_cue = (shortcut, "")
            scores = [
                self._compute_success_rate_of_surface_cue(cue, len(seen))
                if learned
                else unlabelled_cue in statement_cues
                for cue, statement_cues in zip(seen, cues, strict=True)
            ]
            right = question.right or 0
        best = max(scores)
        return _compute_share(scores[right] == best, scores.count(best))

    def _compute_success_rate_of_surface_cue(self, cue: _SurfaceCue | None, option_count: int) -> float:
        """Return how often statements with a cue were right: a share from 0 to 1.

        One fictitious observation at the rate of guessing is added, so that rare cues stay near that rate.
        """
        if cue is None:
            return _compute_share(1, option_count)
        return _compute_share(self._right[cue] * option_count + 1, (self._times[cue] + 1) * option_count)

    def _find_cues_of_each_statement(self, question: YesNoOrChoiceQuestion) -> list[dict[_SurfaceCue, int]]:
        features = [question.read_features(text) for text in question.shown]
        all_cues = [
            dict.fromkeys([("operator", label) for label in statement.labels], _CUE_WEIGHT)
            for statement in features
        ]
        if len(features) == 1:
            (statement,) = features
            all_cues[0] |= {
                ("text", f"{statement.mentioned_names} of {len(statement.names)}"): _CUE_WEIGHT,
                ("text", f"{min(statement.mentions, _MAX_OCCURRENCES)} times"): _CUE_WEIGHT,
                ("longest", self._compare_length_with_earlier_statements(statement.length)): _CUE_WEIGHT,
                ("unchanged", str(statement.holds)): _CUE_WEIGHT,
            }
            return all_cues
        marked: Mapping[_SurfaceCue, Sequence[int]] = {
            ("names", ""): [
                sum([len(one.names & other.names) for other in features]) - len(one.names) for one in features
            ],
            ("longest", ""): [statement.length for statement in features],
            ("longest", "not"): [-statement.length for statement in features],
            ("text", ""): [statement.mentioned_names for statement in features],
            ("text", "all times"): [statement.mentions for statement in features],
            ("unchanged", ""): [statement.holds for statement in features],
        }
        for cue, marks in marked.items():
            best = max(marks)
            weight = _CUE_WEIGHT // marks.count(best)
            for cues, mark in zip(all_cues, marks, strict=True):
                if mark == best:
                    cues[cue] = weight
        return all_cues

    def _compare_length_with_earlier_statements(self, length: int) -> str:
        """Return ``long``, ``short`` or ``medium``: a statement's length compared with earlier ones."""
        shorter = bisect_left(self._lengths, length)
        longer = len(self._lengths) - bisect_right(self._lengths, length)
        return "long" if shorter > longer else "short" if shorter < longer else "medium"


def _compute_balance_changes_by_cue(
    question: YesNoOrChoiceQuestion, cues_of_each_statement: Sequence[Mapping[_SurfaceCue, int]]
) -> dict[_SurfaceCue, int]:
    """Return how much a question changes the balance of each cue (see `_CUE_WEIGHT`).

    A cue is a mark of a statement, such as the greatest length. Its balance rises if the right statement has
    the cue, and falls if a wrong statement has it. If right choices are random, the mean change is 0.
    """
    weights: dict[_SurfaceCue, int] = {}
    for position, statement_cues in enumerate(cues_of_each_statement):
        for cue, part in statement_cues.items():
            weight = part * (_count_options(question) - 1) if position == question.right else -part
            weights[cue] = weights.get(cue, 0) + weight
    return weights


def _count_options(question: YesNoOrChoiceQuestion) -> int:
    return max(2, len(question.shown))


def _compute_share(part: float, whole: float) -> float:
    return Rate(part, whole).share or 0.0


def draw_question_with_least_shortcut_bias(
    item: QuestionWithRightAndWrongTexts,
    setting: QuestionSetting,
    form: QuestionForm,
    question_text: str,
    cue_counts: SurfaceCueCounts,
    rng: random.Random,
    turn: int,
) -> tuple[int, YesNoOrChoiceQuestion] | None:
    """Draw choices, or the statement of a yes-no question, so that no shortcut beats guessing.

    A shortcut is a rule that answers without knowledge of the world, such as "take the longest choice".
    Draws are repeated until one keeps the bias towards shortcuts within the tolerated bias.

    Args:
        item: the right and wrong texts from which the question is made.
        setting: the task, with its states and its names of objects.
        form: yes or no, or multiple choice.
        question_text: the text of the question without the choices.
        cue_counts: how often the statements that shortcuts choose were right in earlier questions.
        rng: the random generator.
        turn: a number that selects the right letter, or whether yes or no is right.

    Returns:
        the result of `SurfaceCueCounts.compute_shortcut_bias_above_limit_if_added` for the best draw, and the
        question of this draw. The result is 0 if the bias is tolerated. None if there are too few right or
        wrong texts.
    """
    is_right, position = turn % 2 == 0, turn % len(LETTERS)
    candidates = item.right if is_right else item.wrong
    if item.yes_no_texts is not None:
        candidates = [text for text in candidates if text in item.yes_no_texts]
    if form is QuestionForm.YES_NO and not candidates:
        return None
    if form is QuestionForm.CHOICE and not (item.right and len(item.wrong) >= len(LETTERS) - 1):
        return None
    initial_facts = (
        ()
        if item.are_actions or item.labels
        else frozenset(map(setting.format_fact_or_action, setting.list_changeable_facts(item.state)))
    )
    read_features = make_feature_reader(question_text, initial_facts, item.labels)
    best: tuple[int, YesNoOrChoiceQuestion] | None = None
    for _ in range(_MAX_DRAWS):
        if form is QuestionForm.YES_NO:
            question = YesNoOrChoiceQuestion(
                [_draw_statement_preferring_most_misleading(candidates, rng)],
                0 if is_right else None,
                read_features,
            )
        else:
            question = YesNoOrChoiceQuestion(_draw_choices(item, rng, position), position, read_features)
        excess = cue_counts.compute_shortcut_bias_above_limit_if_added(question)
        if best is None or excess < best[0]:
            best = excess, question
        if not excess:
            break
    return best


def _draw_statement_preferring_most_misleading(statements: Sequence[str], rng: random.Random) -> str:
    return rng.choice(statements[:1] if rng.random() < _TEMPTING_PROBABILITY else statements)


def _draw_choices(
    item: QuestionWithRightAndWrongTexts, rng: random.Random, right_choice_index: int
) -> list[str]:
    """Return the texts of the choices: a random right text at the given position, and random wrong texts.

    If possible, the wrong texts resemble each other as much as they resemble the right text.
    """
    right = rng.choice(item.right)
    similar = [
        texts
        for texts in _generate_sets_of_similar_wrong_answers(right, item.wrong, rng)
        if len(texts) >= len(LETTERS) - 1
    ]
    shown = rng.sample(rng.choice(similar) if similar else item.wrong, len(LETTERS) - 1)
    shown.insert(right_choice_index, right)
    return shown


def _generate_sets_of_similar_wrong_answers(
    right: str, wrong: Sequence[str], rng: random.Random
) -> Iterator[Sequence[str]]:
    """Yield sets of wrong answers among which the right answer does not stand out by its similarity.

    The first set has the wrong answers with the right answer's predicate or operator, the second set those
    with its arguments. The third set has a random wrong answer, and wrong answers that combine its predicate
    or arguments with those of the right answer.
    """
    name, _, arguments = right.partition("(")
    far = rng.choice(wrong)
    other, _, others = far.partition("(")
    yield [text for text in wrong if text.partition("(")[0] == name]
    yield [text for text in wrong if text.partition("(")[2] == arguments]
    if other != name and others != arguments:
        yield [text for text in (far, f"{name}({others}", f"{other}({arguments}") if text in wrong]


GUESS = "guess"
"""Name of the row for random guessing, in tables that list how often each shortcut is right."""


_KINDS_ABOUT_PLAN_OUTCOMES = (QuestionKind.COUNTERFACTUAL, QuestionKind.VALIDATION)
_PLAN_OUTCOMES = ("works", "goal", "step")
"""First words of the gold answers to questions about the outcome of a plan in open form."""


def compute_answer_entropy(
    questions: Sequence[Question], kind: QuestionKind, form: QuestionForm
) -> float | None:
    """Return how evenly gold answers of a kind and form are distributed; None for fewer than two questions.

    The result is their entropy as a share, from 0 to 1, of its maximum. It is 1 if all possible answers are
    equally frequent. Possible answers are yes and no, the letters, or the outcomes of a plan. For other
    questions in open form, they are the different answers that occur.
    """
    chosen = [question for question in questions if question.kind is kind and question.form is form]
    if len(chosen) < 2:
        return None
    counts = Counter(map(_get_grouping_key_of_gold_answer, chosen))
    shares = [Rate(times, len(chosen)).share or 0.0 for times in counts.values()]
    outcomes = len(_PLAN_OUTCOMES) if kind in _KINDS_ABOUT_PLAN_OUTCOMES else len(counts)
    most = max([question.options for question in chosen]) or outcomes
    entropy = 0.0 - sum([share * math.log2(share) for share in shares])
    return Rate(entropy, math.log2(most)).share if most > 1 else 0.0


def _get_grouping_key_of_gold_answer(question: Question) -> tuple[str, ...]:
    """Return a key for counting gold answers: the whole answer, or only its first word.

    The first word is enough for the outcome of a plan in open form (`_PLAN_OUTCOMES`).
    """
    if question.form is QuestionForm.OPEN and question.kind in _KINDS_ABOUT_PLAN_OUTCOMES:
        return (question.answer[0].partition(" ")[0],)
    return question.answer


def compute_guess_probabilities(questions: Sequence[Question]) -> dict[str, float]:
    """Return the probability that a guess is right, by the id of the question.

    A guess takes one of the choices at random. In open form, it takes the most frequent gold answer of the
    question's kind.
    """
    common = _find_most_frequent_answers(questions)
    return {
        question.id: Rate(1, question.options).share
        or float(grade_answer(question, common[question.kind]).exact)
        for question in questions
    }


def compute_success_rates_of_shortcuts(
    questions: Sequence[Question], guesses: Mapping[str, float]
) -> dict[str, Rate]:
    """Return the rate of right answers of guessing and of each shortcut, by name.

    If a question records no value for a shortcut, the probability of a right guess is used.

    Args:
        questions: the questions.
        guesses: the probability that a guess is right, by the id of the question.
    """
    names = dict.fromkeys([GUESS, *(name for question in questions for name in question.shortcuts)])
    return {
        name: compute_rate(
            [Share(question.shortcuts.get(name, guesses[question.id]), 1) for question in questions]
        )
        for name in names
    }


def find_best_shortcut(success_rates: Mapping[str, Rate]) -> str:
    """Return the name of the shortcut, or of guessing, with the highest success rate. Guessing wins ties."""
    return max(success_rates, key=lambda name: success_rates[name].numerator)


def _find_most_frequent_answers(questions: Iterable[Question]) -> dict[QuestionKind, str]:
    """Return the most frequent gold answer to open questions, by kind. The earlier answer wins ties."""
    golds = group_pairs(
        (question.kind, format_gold_answer(question))
        for question in questions
        if question.form is QuestionForm.OPEN
    )
    counts = {kind: Counter(golds.get(kind, ())) for kind in QuestionKind}
    return {kind: max(count, key=count.__getitem__, default="") for kind, count in counts.items()}
