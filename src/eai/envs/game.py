"""Games: a task played by text, one action a turn, and the view of its world, without gymnasium."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from copy import copy
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache, partial
from itertools import groupby
from operator import itemgetter
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias

from typing_extensions import TypedDict, assert_never

from eai.abilities.goal_test import GoalTest
from eai.abilities.protocol import Ability
from eai.abilities.scorer import exception_text
from eai.abilities.task import Task
from eai.abilities.verdict import (
    ASK,
    REFUSE,
    ErrorReport,
    Merit,
    Share,
    gain_of_conditions,
    is_question,
    merit_of_actions,
    refusal_in,
)
from eai.abilities.wording import Wording
from eai.benchmark.benchmark import Benchmark
from eai.data.grouping import grouped
from eai.envs.command import DONE, Commands, Meant, is_look
from eai.envs.listed import HOW_TO_READ, facts_in_short, in_short
from eai.envs.rules import OUTCOMES, Feedback, Observe, Rules, View
from eai.errors import EaiError, InputError
from eai.logic.formula import TRUE
from eai.logic.traversal import predicates_of
from eai.planning.search import Effort
from eai.planning.successor_generator import applicable_actions
from eai.prompts.own import explanations
from eai.prompts.template import Templates
from eai.scoring.reward import Shaping, metrics_of, suite_of, worth
from eai.tasks.source import TaskReference
from eai.world.action import Action, Fault
from eai.world.derived import stored_sources
from eai.world.episode import Episode, Luck, Slip
from eai.world.execution import describe
from eai.world.fault import FaultKind
from eai.world.listing import Listing
from eai.world.relation import bits, mask_of
from eai.world.state import Change, Fact, State, change

if TYPE_CHECKING:
    from eai.abilities.mending import PlanMender
    from eai.envs.agents import Reference

_LOG = logging.getLogger(__name__)

Sight: TypeAlias = tuple[int, ...]
"""The objects that are seen, in the order in which they are listed."""

Ended: TypeAlias = Literal["goal", "done", "refused", "steps"]
"""How a game has ended: with its goals reached, by `DONE`, by a refusal, or cut off after so many actions."""

_OF_PAIR = 50
"""How many actions both tasks of a pair have: it must not say which has no plan, or is ambiguous."""


@dataclass(frozen=True, eq=False)
class _Shown:
    """The visible facts of one predicate, listed where they are asked for, and how they are stated."""

    listed: Callable[[], Sequence[Fact]]
    state: Callable[[Iterable[Fact]], Iterable[str]]

    @cached_property
    def facts(self) -> Sequence[Fact]:
        """The facts, in order."""
        return self.listed()

    @cached_property
    def text(self) -> str:
        """The lines that state them."""
        return "\n".join(self.state(self.facts))


class _Look(NamedTuple):
    """The visible part of a state: objects, and the facts about them by predicate."""

    state: State
    sight: Sight
    shown: Sequence[_Shown]

    @property
    def text(self) -> str:
        """All the facts, in lines."""
        return "\n".join([shown.text for shown in self.shown if shown.text])


SignedFact: TypeAlias = tuple[str, Fact]
"""A fact that became true, with ``+``, or false, with ``-``."""


class _View:
    """The view of one task's world, which all its episodes share.

    It is of the objects that the task is about, and the agent, or of all in the scene. A full view shows all
    of them, a partial one those that are visible, and landmarks.

    Args:
        task: the task.
        wording: what facts and objects are called.
        observe: how much is seen.
        of: which objects it is of.

    Attributes:
        subjects: what can ever be seen, by index, in the order in which it is listed. In a partial view it is
            that of the scene, which does not show which landmarks matter.
        agent: who acts; None where nobody is in the scene.
        landmarks: those of them that are known from the start.
        first: what is seen of the initial state.
    """

    def __init__(self, task: Task, wording: Wording, observe: Observe, of: View = "task") -> None:
        self._task = task
        self._wording = wording
        self._is_full = observe == "full"
        self._names = [wording.object_name(task, index) for index in range(len(task.scene.objects))]
        self._kind = cache(partial(wording.kind, task))
        self.agent = task.scene.agent
        self._of_agent = {each.name for each in wording.domain.egocentric if of == "scene"}
        known = wording.domain.known_of(task.initial, task.scene.everything)
        everything = range(len(task.scene.objects))
        self.landmarks = () if self._is_full else tuple(bits(known))
        about = wording.subjects(task) if of == "task" else everything
        self.subjects = tuple(about if self._is_full else sorted({*about, *self.landmarks}))
        self._place = {index: place for place, index in enumerate(self.subjects)}
        self._mask = mask_of(self.subjects)
        visible = wording.domain.visible or TRUE
        self._sight_sources = stored_sources(predicates_of(visible), wording.domain.vocabulary)
        sight = self._sight(task.initial)
        shown = [self._shown(each, task.initial, sight) for each in wording.told]
        self.first = _Look(task.initial, sight, shown)

    def objects(self, chosen: Collection[int]) -> str:
        """Objects with their kinds and properties; those that have all in common in one line."""
        of_kind = grouped((self._kind(index), index) for index in self.subjects if index in chosen)
        return "\n".join([f"{self.names(found)} {kind}" for kind, found in of_kind.items()])

    def names(self, chosen: Iterable[int]) -> str:
        """The names of objects."""
        return in_short([self._names[index] for index in chosen])

    def lines(self, facts: Iterable[Fact]) -> Iterator[str]:
        """The lines that state facts."""
        return facts_in_short(facts, self._names, self._wording.said)

    def fact(self, fact: Fact) -> str:
        """A fact by itself."""
        return self._wording.said(fact.predicate, [self._names[index] for index in fact.arguments])

    def about(self, look: _Look, chosen: AbstractSet[int]) -> list[Fact]:
        """The facts that are seen about some objects."""
        return [
            fact
            for listing in self._wording.told
            for fact in listing.facts(look.state, look.sight, self._chosen(listing, chosen))
            if not chosen.isdisjoint(fact.arguments)
        ]

    def next(self, look: _Look, state: State, stored: Change) -> _Look:
        """Return the view of a state of the same episode, which has changed so since the last."""
        changed = stored.predicates
        sight = look.sight if changed.isdisjoint(self._sight_sources) else self._sight(state)
        is_same = sight == look.sight
        shown = [
            before if is_same and changed.isdisjoint(listing.sources) else self._shown(listing, state, sight)
            for listing, before in zip(self._wording.told, look.shown, strict=True)
        ]
        return _Look(state, sight, shown)

    def changes(self, before: _Look, after: _Look, stored: Change) -> list[SignedFact]:
        """Return the visible facts that became true, and those that became false, by what has changed."""
        changed = stored.predicates
        is_same = before.sight == after.sight
        added: list[Fact] = []
        removed: list[Fact] = []
        for listing, old, new in zip(self._wording.told, before.shown, after.shown, strict=True):
            if changed.isdisjoint(listing.sources):
                continue
            if listing.is_stored:
                added += self._seen(listing, stored.added, after.sight)
                removed += self._seen(listing, stored.removed, before.sight)
                continue
            if is_same:
                was, remains = old.facts, new.facts
            else:
                was = self._facts(listing, before.state, after.sight)
                remains = self._facts(listing, after.state, before.sight)
            added += _without(new.facts, was)
            removed += _without(old.facts, remains)
        return [*[("+", fact) for fact in added], *[("-", fact) for fact in removed]]

    def since(self, before: _Look, after: _Look, chosen: AbstractSet[int]) -> list[SignedFact]:
        """Return those of the changes that are about some objects and not about the agent."""
        return [
            (sign, fact)
            for sign, fact in self.changes(before, after, change(before.state, after.state))
            if not chosen.isdisjoint(fact.arguments) and self.agent not in fact.arguments
        ]

    def _seen(self, listing: Listing, facts: Iterable[Fact], sight: Sight) -> list[Fact]:
        """Those of some facts that are of a listing, about what is seen."""
        found = [fact for fact in facts if fact.predicate == listing.predicate and listing.lists(fact)]
        if not found:
            return found
        seen, about = {*sight}, self._chosen(listing)
        found = [
            fact
            for fact in found
            if seen.issuperset(fact.arguments) and (about is None or not about.isdisjoint(fact.arguments))
        ]
        return sorted(found, key=lambda fact: [self._place[index] for index in fact.arguments])

    def _sight(self, state: State) -> Sight:
        """The objects that are seen in a state."""
        if self._is_full:
            return self.subjects
        return tuple(bits(self._wording.domain.seen(state, self._mask)))

    def _facts(self, listing: Listing, state: State, sight: Sight) -> Sequence[Fact]:
        """The facts of one predicate about what is seen."""
        return listing.facts(state, sight, self._chosen(listing))

    def _chosen(self, listing: Listing, chosen: AbstractSet[int] | None = None) -> AbstractSet[int] | None:
        """Of which objects one must be in a fact of a predicate for it to be told; None for any."""
        if listing.predicate not in self._of_agent:
            return chosen
        return frozenset() if self.agent is None else frozenset((self.agent,))

    def _shown(self, listing: Listing, state: State, sight: Sight) -> _Shown:
        return _Shown(partial(self._facts, listing, state, sight), self.lines)


def _without(facts: Iterable[Fact], others: Sequence[Fact]) -> list[Fact]:
    """The facts that are not among others."""
    known = frozenset(others)
    return [fact for fact in facts if fact not in known]


class _Info(TypedDict, total=False):
    """Everything known about one turn besides the observation.

    ``goals`` says of each goal whether it is reached now, and ``won`` whether the episode ended with all of
    them, by `DONE` where that ends it. ``fault`` is the kind of error of the action, or None; ``repairs`` are
    those that reading it took. ``admissible_commands`` are there if they were asked for.
    """

    task_id: str
    goals: list[bool]
    won: bool
    fault: str | None
    slipped: bool
    repairs: list[str]
    admissible_commands: list[str]


class _Turn(NamedTuple):
    """The outcome of an action, as `gymnasium.Env.step` returns it."""

    observation: str
    reward: float
    terminated: bool
    truncated: bool
    info: _Info


class Stage:
    """All that the games of one task share.

    Raises:
        InputError: the task has no goals that can be reached, or an action is called what ends the episode.
    """

    def __init__(self, task: Task, benchmark: Benchmark, rules: Rules) -> None:
        if task.left_out is not None:
            raise InputError(f"{benchmark.name}: {task.id} cannot be played: {task.left_out}")
        if rules.until == "done" and DONE in benchmark.domain.arities:
            raise InputError(f"{benchmark.name}: {DONE} is an action, so it cannot end an episode")
        wording = benchmark.observed_wording()
        self.task = task
        self.rules = rules
        self.benchmark = benchmark
        self.domain = benchmark.domain
        self.commands = Commands(task, benchmark)
        self.view = _View(task, wording, rules.observe, rules.view)
        self.goals = GoalTest(task)
        self.opening = _opening(task, wording, rules)

    @cached_property
    def met_at_start(self) -> Share:
        """The partial success of an episode without actions."""
        initial, goals = self.task.initial, self.goals
        return goals.partial(initial, (), goals.reached(initial, ()))

    @cached_property
    def reference(self) -> Reference:
        """The shortest plan known, and commands that win in this view."""
        from eai.envs.agents import reference_of

        return reference_of(self)

    @cached_property
    def limit(self) -> int | None:
        """After how many actions a game is cut off; None for never."""
        most = [] if self.rules.max_steps is None else [self.rules.max_steps]
        if self.rules.budget is not None:
            is_of_pair = self.task.missing is not None or self.task.fits is not None
            most.append(_OF_PAIR if is_of_pair else self.reference.budget(self.rules.budget))
        return min(most, default=None)

    @cached_property
    def mender(self) -> PlanMender:
        """Tells how near actions are to success."""
        from eai.abilities.mending import PlanMender

        return PlanMender(self.task, self.domain, self.benchmark.plans)

    def endless(self) -> Stage:
        """The same task seen in the same way, without slips or limits, until `DONE`."""
        stage = copy(self)
        stage.rules = self.rules.model_copy(
            update={"slip": 0.0, "max_steps": None, "budget": None, "until": "done"}
        )
        stage.__dict__.pop("limit", None)
        return stage


def _opening(task: Task, wording: Wording, rules: Rules) -> str:
    """Return the first observation of a task."""
    parts = [f"{task.title}\n{task.instruction}"]
    parts += [f"Goals:\n{wording.goals(task)}"] if task.is_told_by_goals else []
    parts += explanations("environment", [task], Templates())
    known = "" if wording.conventions is None else wording.conventions(task)
    parts += [known] if known else []
    agent = task.scene.agent
    notes = [] if agent is None else [f"You are {wording.object_name(task, agent)}."]
    if rules.observe == "partial":
        notes.append("You do not see everything: an action may name only what is listed below or seen later.")
    return "\n\n".join([*parts, " ".join(notes)] if notes else parts)


class _Tried(NamedTuple):
    """The outcome of a command: in words, and the fault and slip of its action."""

    text: str
    fault: FaultKind | None = None
    slipped: bool = False


class Game:
    """One game.

    Args:
        stage: the task, and how it is played.
        seed: of the slips.
        epoch: which of the games with this seed it is.

    Attributes:
        stage: the values that it shares with the other games of its task.
        task: the task that is played.
        ended: how it has ended; None while it lasts.
        won: whether it has ended with all goals reached; where `DONE` ends it, that was said. One that was
            refused is won if nothing leads to the goals.
        refused: why the task cannot be done, as the agent said; None if it did not.
        taken: the operators of the actions that were carried out.
        reached: which goals are reached now.
        worth: what it is worth by its state now; 0 where nothing can be earned.
        tried: how many actions have been tried, impossible ones too.
        action: the action that the last command meant; None where it meant none.
    """

    def __init__(self, stage: Stage, seed: int = 0, epoch: int = 0) -> None:
        luck = Luck(stage.rules.slip, stage.task.id, seed=seed, epoch=epoch)
        self.stage, self.task = stage, stage.task
        self._rules = stage.rules
        self._episode = Episode(stage.domain, stage.task.initial, luck)
        self.taken: list[str] = []
        self._last: Action | None = None
        self._turns = 0
        self._failed = False
        self._faults: Counter[FaultKind] = Counter()
        self._look = stage.view.first
        self._known = {*self._look.sight, *stage.view.landmarks}
        self._seen = {*self._look.sight}
        self._left: dict[int, _Look] = {}
        self._has_looked = False
        self._at_start = self.reached = self._goals_reached()
        self.ended: Ended | None = None
        self.won = False
        self.refused: str | None = None
        self.worth = 0.0
        self.tried = 0
        self.action: Action | None = None
        self._changes: list[SignedFact] = []

    @property
    def look(self) -> _Look:
        """The present view."""
        self._catch_up()
        return self._look

    @property
    def known(self) -> set[int]:
        """The objects that have been seen, and landmarks."""
        self._catch_up()
        return self._known

    @property
    def changes(self) -> list[SignedFact]:
        """The changes by the last command of what is seen, and those seen to have come before."""
        self._catch_up()
        return self._changes

    def _catch_up(self) -> None:
        """See what the last actions have changed, where turns have not told it."""
        if self._look.state is not self.state:
            self._news(self.state)

    @property
    def over(self) -> bool:
        """Whether it has ended."""
        return self.ended is not None

    @property
    def state(self) -> State:
        """The state of the world now, seen or not."""
        return self._episode.state

    @property
    def metrics(self) -> Mapping[str, float]:
        """Numbers to watch, as those of `eai.scoring.reward.Grade`."""
        return metrics_of(self._earned(is_last=self.over))

    @property
    def final_worth(self) -> float:
        """The worth if nothing more is played: by `success` and `goals` nothing if it lacks its `DONE`."""
        return self._worth(is_last=True)

    def _worth(self, *, is_last: bool) -> float:
        if self.refused is not None:
            return float(self.won)
        earned = self._earned(is_last=is_last)
        if earned is not None and self._rules.reward is Shaping.REPAIR:
            last = [None] if self._is_undeclared(is_last=is_last) else [self._last] if self._failed else []
            return self.stage.mender.nearness((*self._worked(), *last)) or 0.0
        return 0.0 if earned is None else worth(earned, self._rules.reward)

    def _worked(self) -> list[Action]:
        """The actions that were carried out, or not needed."""
        steps = self._episode.trajectory.steps
        return [
            step.action
            for step in steps
            if step.executed or (step.fault is not None and step.fault.kind is FaultKind.ADDITIONAL_STEP)
        ]

    def _earned(self, *, is_last: bool) -> Merit | None:
        if self.refused is not None:
            return Merit(float(self.won), self.won, ended=False, faults=self._faults)
        if self.task.missing:  # what is reached on the way to goals that cannot be
            return None
        ended = self._failed or self._is_undeclared(is_last=is_last)
        earned = merit_of_actions(self.reached, self._at_start, ended=ended, faults=self._faults)
        if earned is None or self._rules.reward is not Shaping.PARTIAL:
            return earned
        partial = self.stage.goals.partial(self.state, self.taken, self.reached)
        gained = gain_of_conditions(partial, self.stage.met_at_start, earned.gain)
        return replace(earned, conditions=gained)

    def _is_undeclared(self, *, is_last: bool) -> bool:
        """Whether it lacks the `DONE` that it is to end with."""
        return is_last and self._rules.until == "done" and self.ended != "done"

    def briefing(self) -> str:
        """The text that an agent reads before its first action: the world, and the task."""
        return f"{manual(self.stage.benchmark, self._rules)}\n\n{self.opening()}"

    def opening(self) -> str:
        """The first observation."""
        text = self.stage.opening
        if self._rules.budget is not None:
            text += f"\n\n{Templates().fill('acting.txt', {'limit': str(self.stage.limit)})}"
        return f"{text}\n\n{self._described(self.known)}"

    def look_around(self) -> str:
        """All that is seen now; no more than once between two actions."""
        if self._has_looked:
            return "You have looked already: nothing has changed since."
        self._has_looked = True
        return self._described(self.look.sight)

    def _described(self, objects: Collection[int]) -> str:
        things = self.stage.view.objects(objects)
        is_pictured = self._rules.feedback == "pictures"
        now = "What the pictures show." if is_pictured else self.look.text or "-"
        return f"Objects [kind]: properties\n{things}\n\nNow:\n{now}"

    def act(self, text: str) -> _Turn:
        """Play one turn. Whatever the text, it is a turn and costs an action, but the first `LOOK` after one.

        If the world raises an exception, the action fails and the episode goes on.

        Raises:
            InputError: the episode has ended.
            EaiError: the simulator of the world has failed.
        """
        if self.over:
            raise InputError("the episode is over")
        self.action, self._changes = None, []
        turns, tried = self._turns, self.tried
        try:
            return self._play(text)
        except EaiError:
            raise
        except Exception as error:
            _LOG.warning("an action in %s fails: %s", self.task.id, exception_text(error))
            self._turns, self.tried = turns + 1, tried + 1
            kind = FaultKind.UNCATEGORISED
            self._failed, self._has_looked = True, False
            self._faults[kind] += 1
            words = f"Failed ({_words(kind)}): the world raised {type(error).__name__}."
            return self._turn(_Tried(words, kind), ())

    def _play(self, text: str) -> _Turn:
        if self._rules.feedback == "changes" and is_look(text, self.stage.domain):
            self._turns += self._has_looked
            return self._turn(_Tried(self.look_around()), ())
        fits, operators = self.task.fits, self.stage.domain.arities
        if fits is not None and ASK not in operators and is_question(text):
            return self._answer(fits[0])
        if self.task.missing is not None and REFUSE not in operators:
            self.refused = refusal_in(self.stage.benchmark.plans.decoded(text))
            if self.refused is not None:
                return self._turn(_Tried(f"{REFUSE}."), ())
        ends = self._rules.until == "done"
        nameable = self.known if self._rules.observe == "partial" else range(len(self.task.scene.objects))
        meant, repairs = self.stage.commands.read(text, nameable, ends=ends)
        self._has_looked = False
        self._turns += meant is not None
        if self._is_late:
            return self._turn(_Tried("No actions are left."), ())
        tried = self._try(meant)
        self.action = meant if isinstance(meant, Action) else None
        if meant is not None:
            self.tried += 1
            self._failed = tried.fault not in (None, FaultKind.ADDITIONAL_STEP)
            self._last = self.action
        if tried.fault is not None:
            self._faults[tried.fault] += 1
        self.reached = self._goals_reached()
        return self._turn(tried, repairs, done=meant is None)

    def _answer(self, meant: str) -> _Turn:
        """Say which object is meant, whatever was asked, for an action."""
        self._has_looked = False
        self._turns += 1
        if self._is_late:
            return self._turn(_Tried("No actions are left."), ())
        self.tried += 1
        name = self.stage.view.names((self.task.scene.index[meant],))
        return self._turn(_Tried(f"{name} is meant."), ())

    def _turn(self, tried: _Tried, repairs: tuple[str, ...], *, done: bool = False) -> _Turn:
        """Return the turn that follows from the outcome of a command."""
        complete, limit = all(self.reached), self.stage.limit
        if self.refused is not None:
            self.ended = "refused"
        elif done:
            self.ended = "done"
        elif self._rules.until == "goal" and complete:
            self.ended = "goal"
        elif self._is_late or (self._turns == limit and self._rules.until == "goal"):
            self.ended = "steps"
        truncated = self.ended == "steps"
        self.won = self.over and complete and not truncated
        if self.refused is not None:
            self.won = bool(self.task.missing)
        observation = tried.text
        if self.over:
            observation += "\nAll goals are reached." if self.ended == "goal" else "\nThe episode is over."
        elif self._rules.budget is not None and limit is not None:
            observation += f"\n{limit - self._turns} of {limit} actions left."
        if self._rules.feedback == "facts":
            observation += f"\n\nNow:\n{self.look.text or '-'}"
        terminated = self.over and not truncated
        info = self.info(tried.fault, slipped=tried.slipped, repairs=repairs)
        return _Turn(observation, self._pay(), terminated, truncated, info)

    @property
    def _is_late(self) -> bool:
        """Whether more is tried than is allowed; after the last action that is, `DONE` may still be said."""
        return self.stage.limit is not None and self._turns > self.stage.limit

    def _pay(self) -> float:
        """The reward of the turn: by how much it changes what the episode is worth."""
        before, self.worth = self.worth, self._worth(is_last=self.over)
        return self._rules.gamma * self.worth - before

    def _try(self, meant: Meant) -> _Tried:
        """Carry out what a command means."""
        if meant is None:
            return _Tried(f"{DONE}.")
        if isinstance(meant, ErrorReport):
            hint = f" {self.stage.commands.hint}" if meant.kind is FaultKind.PARSING else ""
            return _Tried(f"Failed ({_words(meant.kind)}): {meant.detail}.{hint}", meant.kind)
        line, outcome = self.stage.commands.write(meant), self._episode.act(meant)
        match outcome:
            case Fault(kind):
                reason = describe(outcome, self.stage.domain, meant, self.stage.task.scene)
                failed = "not needed" if kind is FaultKind.ADDITIONAL_STEP else f"failed ({_words(kind)})"
                return _Tried(f"{line}: {failed}: {reason}.", kind)
            case Slip():
                return _Tried(f"{line}: nothing happened.", slipped=True)
            case State():
                self.taken.append(meant.operator)
                if self._rules.feedback not in OUTCOMES:
                    return _Tried(f"{line}: done.\n{self._news(outcome)}")
                if self._rules.observe == "partial":  # what is in sight now may not be later
                    self._catch_up()
                return _Tried(f"{line}: done.")
            case _:
                assert_never(outcome)

    def _news(self, state: State) -> str:
        """Return the visible changes of an action, and things that are seen for the first time."""
        view, before = self.stage.view, self._look
        stored = change(before.state, state)
        self._look = after = view.next(before, state, stored)
        self._changes = view.changes(before, after, stored)
        news = [*self._signed(self._changes)] or ["No fact that you see has changed."]
        new = [index for index in after.sight if index not in self._known]
        self._known.update(new)
        is_brief = self._rules.feedback == "changes" and before.sight != after.sight
        if is_brief:
            new = [index for index in after.sight if index not in self._seen]
            self._seen.update(new)
            news += self._moved(before, new)
        if new:
            news += ["", "You see for the first time:", view.objects(new)]
        if new and is_brief:
            told = {fact for sign, fact in self._changes if sign == "+"}
            facts = [fact for fact in view.about(after, {*new}) if fact not in told]
            news += ["", "Of these:", *(view.lines(facts) if facts else "-")]
        return "\n".join(news)

    def _signed(self, changes: Sequence[SignedFact]) -> Iterator[str]:
        """The lines of changes."""
        for sign, facts in groupby(changes, itemgetter(0)):
            yield from (f"{sign} {line}" for line in self.stage.view.lines(fact for _, fact in facts))

    def _moved(self, before: _Look, new: Sequence[int]) -> Iterator[str]:
        """Return what went out of sight and what came back, with what has changed of that since."""
        view, after = self.stage.view, self.look
        seen, known = {*after.sight}, {*before.sight, *new}
        gone = [index for index in before.sight if index not in seen]
        back = [index for index in after.sight if index not in known]
        if gone:
            self._left.update(dict.fromkeys(gone, before))
            kept = [index for index in before.sight if index in seen]
            is_more = len(gone) > len(kept) > 0
            yield f"Gone out of sight: {f'all but {view.names(kept)}' if is_more else view.names(gone)}."
        if back:
            yield f"In sight again: {view.names(back)}."
        looks = {id(look): look for index in back if (look := self._left.get(index)) is not None}
        for look in looks.values():
            chosen = {index for index in back if self._left.get(index) is look}
            since = view.since(look, after, chosen)
            self._changes += since
            yield from self._signed(since)

    def _goals_reached(self) -> tuple[bool, ...]:
        goals, episode = self.stage.goals, self._episode
        return goals.reached(episode.state, self.taken, episode.trajectory if goals.watches else None)

    def info(
        self, fault: FaultKind | None = None, *, slipped: bool = False, repairs: Sequence[str] = ()
    ) -> _Info:
        """All that there is to know of a turn besides its observation, or at the beginning."""
        info = _Info(
            task_id=self.stage.task.id,
            goals=list(self.reached),
            won=self.won,
            fault=None if fault is None else fault.value,
            slipped=slipped,
            repairs=list(repairs),
        )
        if self._rules.admissible:
            info["admissible_commands"] = self.admissible_commands()
        return info

    def admissible_commands(self) -> list[str]:
        """Return all commands for possible actions about what has been seen, and `DONE` if that is one.

        Raises:
            InputError: there are too many.
        """
        bindings = Effort(_MAX_BINDINGS)
        commands = [self.stage.commands.write(action) for action in self.admissible(bindings)]
        if bindings.is_exceeded:
            raise InputError(
                f"admissible: too many actions are possible in the task {self.task.id}; leave the option out"
            )
        return [*commands, DONE] if self._rules.until == "done" else commands

    def admissible(self, bindings: Effort | None = None) -> Iterator[Action]:
        """Yield all actions that are possible now, about objects that the agent has seen.

        Args:
            bindings: counts the effort and ends the actions early, as in `applicable_actions`. By default it
                has a limit.
        """
        objects = [index for index in self.stage.view.subjects if index in self.known]
        domain, state = self.stage.domain, self._episode.state
        bindings = bindings or Effort(_MAX_BINDINGS)
        for operator in domain.operators:
            yield from applicable_actions(domain, operator, state, objects, bindings)


_MAX_BINDINGS = 1_000_000
"""Maximum number of values of parameters that are tried to list the possible actions."""

_AT_FIRST = "At first you are told what holds of what you see; nothing else does. Each turn you are told what"
_OBSERVED: Mapping[Feedback, str] = {
    "facts": (
        "Each turn you are told what your action has changed and what holds now; of what you see, nothing"
        " else holds."
    ),
    "changes": f"{_AT_FIRST} your action has changed.",
    "outcome": f"{_AT_FIRST} became of your action; what it changes follows from the list of actions.",
    "pictures": (
        "At first and after each turn two pictures show what holds: from where the robot stands, and near the"
        " place of work. Each turn you are told what became of your action."
    ),
}


def manual(benchmark: Benchmark, rules: Rules) -> str:
    """Return the manual of a world: its predicates, and its actions."""
    egocentric = benchmark.domain.egocentric if rules.view == "scene" else ()
    names, told = " and ".join([each.name for each in egocentric]), _OBSERVED[rules.feedback]
    told = f"{told} {names}: of yourself alone." if names else told
    wording = benchmark.observed_wording()
    values = {
        "told": told,
        "how_to_read": HOW_TO_READ,
        "vocabulary": wording.vocabulary(),
        "operators": wording.operators(),
        "of_each": wording.contents_of("each"),
    }
    return Templates().fill("environment.txt", values)


def _words(kind: FaultKind) -> str:
    return kind.value.replace("_", " ")


RULES = Rules(max_steps=50)
"""How trainers play tasks where nothing else is asked for."""

_KEPT = 4096
"""How many tasks are kept ready; one takes some milliseconds to make."""


@lru_cache(_KEPT)
def stage_of(task: str, rules: Rules = RULES) -> Stage:
    """A named task made ready to be played.

    Args:
        task: the task, of action sequencing, as `Suite.reference` writes it.
        rules: how it is played.

    Raises:
        InputError: there is no such task, or it cannot be played.
        DataError: the data cannot be had.
    """
    reference = TaskReference.parse(task)
    if reference.ability is not Ability.ACTION_SEQUENCING:
        raise InputError(f"{task}: only tasks of {Ability.ACTION_SEQUENCING.value} are played")
    suite = suite_of(reference.benchmark, reference.ability)
    if reference.task_id not in suite.tasks:
        raise InputError(f"{suite.domain} has no task {reference.task_id!r}")
    return staged(suite.tasks[reference.task_id], suite.benchmark, rules)


@lru_cache(_KEPT)
def staged(task: Task, benchmark: Benchmark, rules: Rules) -> Stage:
    """A task made ready to be played, which all share who play it and who score what was played.

    Raises:
        InputError: it cannot be played.
    """
    return Stage(task, benchmark, rules)
