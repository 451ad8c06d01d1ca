"""The goals of a task as answers state them, with all ways to meet each."""

from __future__ import annotations

from dataclasses import dataclass

from eai.abilities.goal_interpretation.lexicon import GoalLexicon
from eai.abilities.goal_interpretation.notation import Alternatives, GoalNotation, WrittenGoal
from eai.abilities.task import GoalKind, Task
from eai.logic.choice import Literal
from eai.logic.options import choice_options
from eai.logic.overlap import BestOverlap, best_overlap
from eai.world.domain import Domain
from eai.world.relation import bits


@dataclass(frozen=True, slots=True)
class _GoldGoal:
    """A goal of a task; its options are sets of conditions, as masks.

    Attributes:
        kind: its kind, for explanations.
        text: it in words, for explanations; None for the option that an answer is compared with.
        best: gives the option that an answer meets best.
    """

    kind: str
    text: str | None
    best: BestOverlap

    @property
    def is_possible(self) -> bool:
        """Whether there is an option at all."""
        return self.best(0) is not None


class GoldGoals:
    """The goals of a task. Conditions are numbered; sets of them are masks (bit i = condition i).

    Attributes:
        goals: the goals, in order.
        stated: how each condition is stated in an answer, in canonical form.
        mask_of: the conditions that are stated in the same way, by that way.
        of_kind: the conditions of each kind, by its name.
    """

    def __init__(self, alternatives: tuple[Alternatives, ...], lexicon: GoalLexicon) -> None:
        self._lexicon = lexicon
        self._numbers: dict[WrittenGoal, int] = {}
        self.stated: list[WrittenGoal] = []
        self._texts: list[str] = []
        self.mask_of: dict[WrittenGoal, int] = {}
        self.of_kind: dict[str, int] = {kind.value: 0 for kind in GoalKind}
        self.goals = tuple(
            _GoldGoal(each.kind, each.text, best_overlap(each.options, self._number)) for each in alternatives
        )

    def chosen(self, said: int) -> list[int]:
        """Of each goal the option that shares most with what is said; 0 where there is none."""
        return [0 if (best := goal.best(said)) is None else best.conditions for goal in self.goals]

    def conditions(self, mask: int) -> tuple[WrittenGoal, ...]:
        """The conditions of a set, as they are stated."""
        return tuple([self.stated[number] for number in bits(mask)])

    def as_texts(self, mask: int) -> tuple[str, ...]:
        """The conditions of a set as texts."""
        return tuple([self._texts[number] for number in bits(mask)])

    def _number(self, literal: Literal) -> int:
        ground = self._lexicon.canonical(self._lexicon.grounded(literal))
        number = self._numbers.get(ground)
        if number is None:
            number = self._numbers[ground] = len(self.stated)
            stated = self._lexicon.canonical(self._lexicon.spelt(literal))
            self.stated.append(stated)
            self._texts.append(str(stated))
            self.mask_of[stated] = self.mask_of.get(stated, 0) | 1 << number
            self.of_kind[self._lexicon.kind(stated)] |= 1 << number
        return number


def write_goals(task: Task, domain: Domain, notation: GoalNotation) -> tuple[str, ...]:
    """A right answer, in parts: the first option of each goal at the end."""
    task = task.at_the_end
    lexicon = GoalLexicon(task, domain, notation)
    options = [next(choice_options(goal.options), ()) for goal in notation.alternatives(task)]
    conditions = dict.fromkeys(condition for option in options for condition in option)
    return notation.write([lexicon.spelt(condition) for condition in conditions])
