"""Goal interpretation: from an answer's text to counts, for any benchmark.

What is ill-formed, or names what does not exist, is left out first: it is counted apart, and is neither
right nor wrong (paper, appendix "Goal Interpretation: State Goal, Relation Goal and Action Goal"). The rest
is compared with the goals of the task. A goal can be met in several ways, its options; the option that the
answer meets best is what the answer is compared with. Where several objects share one name, goals are
matched up to renaming: said twice, a goal matches two that are stated in the same way. What is said more
often than of how many objects it can be said is mere repetition, and counts nothing. An answer that cannot
be read misses all goals of its task.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from functools import partial, reduce
from operator import or_
from typing import NamedTuple

from eai.abilities.explanation import Explanation, GoalReport, repairs_told
from eai.abilities.goal_interpretation.gold import GoldGoals
from eai.abilities.goal_interpretation.lexicon import GoalLexicon
from eai.abilities.goal_interpretation.notation import GoalNotation
from eai.abilities.goal_interpretation.written import SECTIONS, WrittenGoal, WrittenGoals
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.task import GoalKind, Task
from eai.abilities.unreadable import Unreadable
from eai.abilities.verdict import ALL, Confusion, ErrorReport, GoalVerdict
from eai.world.domain import Domain
from eai.world.fault import FaultKind
from eai.world.relation import bits


class Compared(NamedTuple):
    """How often a goal is stated rightly, and how often wrongly."""

    kind: GoalKind
    right: int
    wrong: int


class Hallucination(NamedTuple):
    """A goal, and the first name in it that means nothing."""

    goal: WrittenGoal
    name: str


class Stated(NamedTuple):
    """The well-formed goals of an answer: how often each is stated that can be compared, and the others."""

    known: Counter[WrittenGoal]
    unknown: tuple[Hallucination, ...]


class GoalInterpretation(Scorer):
    """The scorer of one task."""

    def __init__(self, task: Task, domain: Domain, notation: GoalNotation) -> None:
        self.task = task
        self.notation = notation
        self.lexicon = GoalLexicon(task, domain, notation)
        self.gold = GoldGoals(notation.alternatives(task), self.lexicon)

    def assess(self, text: str) -> Assessment:
        """The verdict on an answer, and which goals of the task it has, and what else it says."""
        goals = self.notation.read(text)
        if isinstance(goals, Unreadable):
            return Assessment(self.unread(goals), partial(Explanation, (f"parsing: {goals.reason}",)))
        verdict = self.judge(goals)
        return Assessment(verdict, partial(self._explain, goals, verdict))

    def unread(self, goals: Unreadable) -> GoalVerdict:
        """The verdict on an answer in which no goals can be read."""
        return GoalVerdict(
            error=ErrorReport(FaultKind.PARSING, None, goals.reason),
            counts=self.judge(WrittenGoals(())).counts,
        )

    def judge(self, goals: WrittenGoals) -> GoalVerdict:
        """The verdict on the goals of an answer."""
        said, unknown = self._stated(goals)
        ill_formed = len(self._faults(goals))
        wanted = reduce(or_, self._chosen(said), 0)
        compared = []
        for goal, times in said.items():
            asked = (self.gold.mask_of.get(goal, 0) & wanted).bit_count()
            if times > 1:
                times = min(times, max(1, asked, self.lexicon.instances(goal)))
            right = min(times, asked)
            compared.append(Compared(self.lexicon.kind(goal), right, times - right))
        counts = {
            kind.value: _confusion([each for each in compared if each.kind is kind], wanted & mask)
            for kind, mask in self.gold.of_kind.items()
        }
        everything = _confusion(compared, wanted)
        return GoalVerdict(
            counts={**counts, ALL: everything},
            repairs=goals.repairs,
            predicted=everything.true_positives + everything.false_positives + len(unknown) + ill_formed,
            ill_formed=ill_formed,
            hallucinated=tuple([each.name for each in unknown]),
            unknown_predicates=tuple(
                [goal.predicate for goal in goals.goals if not self.lexicon.has_predicate(goal)]
            ),
        )

    def wrong(self, goals: WrittenGoals) -> Iterable[WrittenGoal]:
        """What an answer states that could be a goal of the task and is none, each once."""
        said = self._stated(goals).known
        wanted = {goal for option in self._chosen(said) for goal in self.gold.conditions(option)}
        return [goal for goal in said if goal not in wanted]

    def left_out(self, goals: WrittenGoals) -> Iterable[str]:
        """What of an answer is neither right nor wrong, and why, in words."""
        yield from ill_formed_told(self._faults(goals))
        for goal, name in dict.fromkeys(self._stated(goals).unknown):
            yield f"left out as hallucination: {goal}, there is no {name}"

    def reports(self, goals: WrittenGoals) -> tuple[GoalReport, ...]:
        """For each goal of the task whether an answer has it; a condition uses up one statement of it."""
        left = self._stated(goals).known
        options = self._chosen(left)
        met = 0
        for number in bits(reduce(or_, options, 0)):
            condition = self.gold.stated[number]
            if left[condition] > 0:
                left[condition] -= 1
                met |= 1 << number
        return tuple(
            GoalReport(
                goal.kind,
                goal.text or " and ".join(map(str, self.gold.conditions(option))),
                goal.is_possible and not option & ~met,
            )
            for goal, option in zip(self.gold.goals, options, strict=True)
        )

    def _explain(self, goals: WrittenGoals, verdict: GoalVerdict) -> Explanation:
        return Explanation(
            notes=(
                *repairs_told(goals.repairs),
                *self.left_out(goals),
                *(
                    f"{kind} goals: {count.true_positives} right, {count.false_positives} wrong"
                    for kind, count in (verdict.counts or {}).items()
                    if isinstance(count, Confusion) and kind != ALL
                ),
                *dict.fromkeys(f"wrong: {goal}" for goal in self.wrong(goals)),
            ),
            goals=self.reports(goals),
        )

    def _stated(self, goals: WrittenGoals) -> Stated:
        """The well-formed goals of an answer, in canonical form."""
        lexicon = self.lexicon
        known = Counter([lexicon.canonical(goal) for goal in goals.goals if lexicon.is_well_formed(goal)])
        unknown: list[Hallucination] = []
        for goal in [*known]:
            name = lexicon.first_unknown(goal)
            if name is not None:
                times = min(known.pop(goal), max(1, lexicon.instances(goal)))
                unknown += [Hallucination(goal, name)] * times
        return Stated(known, tuple(unknown))

    def _faults(self, goals: WrittenGoals) -> list[GoalKind | None]:
        """The kind of every entry that is ill-formed, each entry once; None for one of no kind."""
        lexicon = self.lexicon
        stated = dict.fromkeys(goal for goal in goals.goals if not lexicon.is_well_formed(goal))
        return [
            *map(lexicon.kind, stated),
            *[entry.kind for entry in dict.fromkeys(goals.ill_formed)],
        ]

    def _chosen(self, said: Iterable[WrittenGoal]) -> list[int]:
        """Of each goal the option that an answer meets best."""
        mask_of = self.gold.mask_of
        return self.gold.chosen(reduce(or_, [mask_of.get(goal, 0) for goal in said], 0))


def ill_formed_told(kinds: Iterable[GoalKind | None]) -> Iterator[str]:
    """How many entries of each kind are ill-formed, in words."""
    for kind, number in Counter(kinds).items():
        section = "no kind" if kind is None else f"the {SECTIONS[kind]}"
        yield f"left out as ill-formed: {number} of {section}"


def _confusion(compared: Sequence[Compared], wanted: int) -> Confusion:
    """The counts of some goals, compared with a set of conditions."""
    right = sum([each.right for each in compared])
    return Confusion(right, sum([each.wrong for each in compared]), wanted.bit_count() - right)
