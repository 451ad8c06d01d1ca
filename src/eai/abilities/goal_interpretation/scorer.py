"""The scorer of goal interpretation: from the text of an answer to counts, for any benchmark.

Ill-formed goals and goals with unknown names are left out first. They are counted separately, and are neither
right nor wrong (paper, appendix "Goal Interpretation: State Goal, Relation Goal and Action Goal"). All other
goals of the answer are compared with the goals of the task. If there are several ways (options) to meet a
goal of the task, the option with most stated conditions counts. If several objects have the same name,
repetitions of a stated goal match goals about different objects with this name. More repetitions than there
are such objects do not count. An unreadable answer misses all goals of its task.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterable, Iterator
from dataclasses import replace
from functools import partial, reduce
from operator import or_
from textwrap import shorten
from typing import NamedTuple, TypeAlias

from eai.abilities.explanation import GoalReport, VerdictExplanation, find_predicate_names, write_repair_notes
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.notation.goal_lexicon import GoalLexicon
from eai.abilities.notation.goals import GoalAlternatives, GoalNotation, IllFormed, WrittenGoal, WrittenGoals
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.verdict import ALL, ConfusionCounts, ErrorReport, Unreadable
from eai.logic.choice import Literal, make_finder_of_dnf_term_closest_to_answer
from eai.tasks.task import GoalKind, Task
from eai.world.domain import Domain
from eai.world.fault import FaultKind
from eai.world.relation import iterate_bits, keep_lowest_set_bits

_MAX_ENTRY_CHARACTERS = 100
"""Maximum number of characters that a message quotes from an ill-formed entry of an answer."""


class _GoalsByValidity(NamedTuple):
    """The goals of an answer, sorted by whether they can be compared with the task's goals.

    Attributes:
        known: well-formed goals without an unknown name, each with its number of occurrences.
        unknown: pairs of a well-formed goal with an unknown name, and the first unknown name in the goal.
        ill_formed: ill-formed goals, each once.
    """

    known: dict[WrittenGoal, int]
    unknown: tuple[tuple[WrittenGoal, str], ...]
    ill_formed: tuple[WrittenGoal, ...]


_ConditionMask: TypeAlias = int
"""Set of conditions of a task's goals: a bit mask in which bit i stands for condition i."""


class _GoldGoals:
    """The goals of a task. All conditions in these goals have numbers.

    A bit mask stands for a set of conditions: bit i for condition i. An option of a goal is a set of
    conditions that meets the goal.

    Attributes:
        goals: the goals, in order.
        option_finders: for each goal, a function that takes the mask of the conditions in an answer, and
            returns the option with most stated conditions.
        stated: for each condition, the goal (in canonical form) that an answer writes for the condition.
        mask_of: mapping from each goal in ``stated`` to the mask of the conditions that it can mean. It can
            mean several conditions if objects have the same name in answers.
        mask_of_kind: mapping from the name of each kind of goals to the mask of the conditions of this kind.
    """

    def __init__(self, alternatives: tuple[GoalAlternatives, ...], lexicon: GoalLexicon) -> None:
        self._lexicon = lexicon
        self._numbers: dict[WrittenGoal, int] = {}
        self.stated: list[WrittenGoal] = []
        self._texts: list[str] = []
        self.mask_of: dict[WrittenGoal, int] = {}
        self.mask_of_kind: dict[str, int] = {kind.value: 0 for kind in GoalKind}
        self.goals = alternatives
        self.option_finders = [
            make_finder_of_dnf_term_closest_to_answer(goal.options, self._get_or_add_condition_index)
            for goal in alternatives
        ]

    def choose_best_matching_option_of_each_goal(
        self, stated_conditions: _ConditionMask
    ) -> list[_ConditionMask]:
        """Return for each goal the bit mask of the option that contains most of the stated conditions.

        An option is a set of conditions that meets the goal. The mask of a goal without options is 0.
        ``stated_conditions`` is the bit mask of the conditions that the answer states.
        """
        options = [find_option(stated_conditions) for find_option in self.option_finders]
        return [0 if option is None else option.conditions for option in options]

    def list_conditions_as_goals(self, conditions: _ConditionMask) -> tuple[WrittenGoal, ...]:
        """Return for each condition of a set the goal that an answer writes for the condition."""
        return tuple([self.stated[number] for number in iterate_bits(conditions)])

    def list_condition_texts(self, conditions: _ConditionMask) -> tuple[str, ...]:
        """Return the text of each condition of a set."""
        return tuple([self._texts[number] for number in iterate_bits(conditions)])

    def _get_or_add_condition_index(self, literal: Literal) -> int:
        ground = self._lexicon.canonicalize(self._lexicon.to_goal_with_scene_names(literal))
        number = self._numbers.get(ground)
        if number is None:
            number = self._numbers[ground] = len(self.stated)
            stated = self._lexicon.canonicalize(self._lexicon.to_goal_with_answer_names(literal))
            self.stated.append(stated)
            self._texts.append(str(stated))
            self.mask_of[stated] = self.mask_of.get(stated, 0) | 1 << number
            self.mask_of_kind[self._lexicon.classify_goal(stated)] |= 1 << number
        return number


class GoalInterpretationScorer(Scorer):
    """The scorer of goal interpretations for one task.

    It leaves out goals about the whole execution, because answers cannot state them.
    """

    def __init__(self, task: Task, domain: Domain, notation: GoalNotation) -> None:
        self.task = task = task.without_goals_over_time
        self.notation = notation
        self.lexicon = GoalLexicon(task, domain, notation)
        self.gold = _GoldGoals(notation.list_alternatives_of_goals(task), self.lexicon)

    def assess(self, text: str) -> Assessment:
        """Return the verdict on an answer, with the right, missed and wrong goals as its explanation."""
        goals = self.notation.read(text)
        if isinstance(goals, Unreadable):
            notes = (f"parsing: {goals.reason}",)
            nothing = WrittenGoals(())
            return Assessment(
                self.judge_unreadable(goals),
                lambda: replace(self._explain(nothing, self.judge(nothing)), notes=notes),
            )
        verdict = self.judge(goals)
        return Assessment(verdict, partial(self._explain, goals, verdict))

    def judge_unreadable(self, goals: Unreadable) -> GoalVerdict:
        """Return the verdict on an unreadable answer."""
        error = ErrorReport(FaultKind.PARSING, None, goals.reason)
        return replace(self.judge(WrittenGoals(())), error=error, spans=goals.spans)

    def judge(self, goals: WrittenGoals) -> GoalVerdict:
        """Return the verdict on the goals that an answer states."""
        said, unknown, lacking = self._group_goals_by_validity(goals)
        ill_formed = len(lacking) + len(dict.fromkeys(goals.ill_formed))
        wanted, matched = reduce(or_, self._choose_best_matching_option_of_each_goal(said), 0), 0
        wrong: list[str] = []
        kinds: list[str] = []
        for goal, times in said.items():
            meant = self.gold.mask_of.get(goal, 0) & wanted
            wanted_number = meant.bit_count()
            if times > 1:
                times = min(times, max(1, wanted_number, self.lexicon.count_possible_object_tuples(goal)))
            matched |= meant if times >= wanted_number else keep_lowest_set_bits(meant, times)
            if times > wanted_number:
                wrong += [str(goal)] * (times - wanted_number)
                kinds += [self.lexicon.classify_goal(goal)] * (times - wanted_number)
        missing = wanted & ~matched
        return GoalVerdict(
            counts={
                **{
                    kind: ConfusionCounts(
                        (matched & of).bit_count(), kinds.count(kind), (missing & of).bit_count()
                    )
                    for kind, of in self.gold.mask_of_kind.items()
                },
                ALL: ConfusionCounts(matched.bit_count(), len(wrong), missing.bit_count()),
            },
            repairs=goals.repairs,
            spans=goals.spans,
            predicted=matched.bit_count() + len(wrong) + len(unknown) + ill_formed,
            ill_formed=ill_formed,
            hallucinated=tuple([name for _, name in unknown]),
            unknown_predicates=tuple(
                [goal.predicate for goal in goals.goals if not self.lexicon.has_predicate_of_goal(goal)]
            ),
            matched=self.gold.list_condition_texts(matched),
            wrong=tuple(wrong),
            missing=self.gold.list_condition_texts(missing),
        )

    def describe_goals_left_out_of_score(self, goals: WrittenGoals) -> Iterable[str]:
        """Yield texts on the goals in an answer that are neither right nor wrong, with the reasons."""
        _, unknown, lacking = self._group_goals_by_validity(goals)
        entries = [(self.lexicon.classify_goal(goal), str(goal)) for goal in lacking]
        yield from describe_ill_formed_entries([*entries, *goals.ill_formed])
        for goal, name in dict.fromkeys(unknown):
            yield f"left out as hallucination: {goal}, there is no {name}"

    def report_goals(self, goals: WrittenGoals) -> tuple[GoalReport, ...]:
        """Return for each goal of the task a report that says whether the answer states the goal.

        Each goal in the answer counts for only one condition of the task's goals.
        """
        left = self._group_goals_by_validity(goals).known
        options = self._choose_best_matching_option_of_each_goal(left)
        met = 0
        for number in iterate_bits(reduce(or_, options, 0)):
            condition = self.gold.stated[number]
            times = left.get(condition, 0)
            if times > 0:
                left[condition] = times - 1
                met |= 1 << number
        reports = []
        for goal, find_option, option in zip(self.gold.goals, self.gold.option_finders, options, strict=True):
            text = goal.text or " and ".join(map(str, self.gold.list_conditions_as_goals(option)))
            is_met = find_option(0) is not None and not option & ~met
            reports.append(GoalReport(goal.kind, text, is_met, predicates=find_predicate_names(text)))
        return tuple(reports)

    def _explain(self, goals: WrittenGoals, verdict: GoalVerdict) -> VerdictExplanation:
        reported = {*verdict.matched, *verdict.wrong, *verdict.missing}
        notes = [*write_repair_notes(goals.repairs), *self.describe_goals_left_out_of_score(goals)]
        for kind, (right, wrong, missed) in (verdict.counts or {}).items():
            if kind != ALL:
                notes.append(f"{kind} goals: {right} right, {wrong} wrong, {missed} missed")
        if not self.gold.mask_of:
            notes.append("the task has no goals, so nothing that is stated is right")
        notes += describe_wrong_goals(verdict, {str(goal) for goal in self.gold.mask_of})
        notes += self._describe_incompletely_stated_goals(goals)
        return VerdictExplanation(
            notes=tuple(notes),
            goals=self.report_goals(goals),
            atoms={
                text: goal.atom_or_action
                for goal in (*self.gold.stated, *self.list_goals_with_known_names(goals))
                if (text := str(goal)) in reported
            },
        )

    def list_goals_with_known_names(self, goals: WrittenGoals) -> Iterable[WrittenGoal]:
        """Return the well-formed goals of an answer that contain only known names."""
        return self._group_goals_by_validity(goals).known

    def _describe_incompletely_stated_goals(self, goals: WrittenGoals) -> Iterator[str]:
        """Yield a text on each goal that the answer states incompletely, with the missed conditions."""
        left = self._group_goals_by_validity(goals).known
        for option in self._choose_best_matching_option_of_each_goal(left):
            missed = [
                str(condition)
                for condition in self.gold.list_conditions_as_goals(option)
                if condition not in left
            ]
            if 0 < len(missed) < option.bit_count():
                yield f"missed of a goal that is stated in part: {', '.join(missed)}"

    def _group_goals_by_validity(self, goals: WrittenGoals) -> _GoalsByValidity:
        """Group the goals of an answer: with known names, with unknown names, ill-formed.

        Well-formed goals are returned in their canonical form.
        """
        lexicon = self.lexicon
        known: dict[WrittenGoal, int] = {}
        ill_formed: dict[WrittenGoal, None] = {}
        for goal in goals.goals:
            if lexicon.is_well_formed(goal):
                goal = lexicon.canonicalize(lexicon.replace_scene_names_by_answer_names(goal))
                known[goal] = known.get(goal, 0) + 1
            else:
                ill_formed[goal] = None
        unknown: list[tuple[WrittenGoal, str]] = []
        for goal in [*known]:
            name = lexicon.find_unknown_name(goal)
            if name is not None:
                times = min(known.pop(goal), max(1, lexicon.count_possible_object_tuples(goal)))
                unknown += [(goal, name)] * times
        return _GoalsByValidity(known, tuple(unknown), tuple(ill_formed))

    def _choose_best_matching_option_of_each_goal(
        self, stated_goals: Iterable[WrittenGoal]
    ) -> list[_ConditionMask]:
        mask_of = self.gold.mask_of
        return self.gold.choose_best_matching_option_of_each_goal(
            reduce(or_, [mask_of.get(goal, 0) for goal in stated_goals], 0)
        )


def describe_ill_formed_entries(entries: Iterable[IllFormed]) -> Iterator[str]:
    """Yield one line of text on each different ill-formed entry of an answer. Long entries are cut off."""
    for _, text in dict.fromkeys(entries):
        yield f"left out as ill-formed: {shorten(text, _MAX_ENTRY_CHARACTERS, placeholder=' ...')}"


def describe_wrong_goals(verdict: GoalVerdict, options: Container[str] = ()) -> tuple[str, ...]:
    """Return one sentence on each wrong goal of an answer, with the goal's number of occurrences.

    Args:
        verdict: the verdict on the answer.
        options: texts of all conditions that can help to meet a goal of the task. Wrong goals among these
            conditions get an explanation.
    """
    return tuple(
        f"wrong: {goal}"
        + (f", {times} times" if times > 1 else "")
        + (
            ", said more often than it is a goal"
            if goal in verdict.matched
            else ", of another way to meet a goal than the one that counts"
            if goal in options
            else ""
        )
        for goal, times in Counter(verdict.wrong).items()
    )
