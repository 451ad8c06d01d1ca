"""Describe what an agent sees as text, and remember what it has seen in an episode."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from functools import cache, cached_property, partial
from itertools import groupby
from operator import itemgetter
from typing import NamedTuple, TypeAlias

from eai.agents.rules import Feedback, GameRules, Observe, View
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import Benchmark
from eai.logic.formula import TRUE
from eai.logic.traversal import find_predicates
from eai.tasks.prompts.own import explain_goal_notation, make_domain_texts_by_placeholder
from eai.tasks.prompts.short import merge_lines_of_similar_facts, merge_lines_of_similar_objects
from eai.tasks.prompts.template import PromptTemplates, Text
from eai.tasks.short_lists import (
    HOW_TO_READ,
    expand_shortened_lists,
    join_names_with_number_ranges,
    write_similar_facts_on_one_line,
)
from eai.tasks.task import Task
from eai.tasks.wording import PromptAndAnswerWording
from eai.world.derived import find_stored_dependencies
from eai.world.listing import FactLister
from eai.world.relation import iterate_bits, make_mask
from eai.world.state import Fact, State, StateChange, compare_states

Indices: TypeAlias = tuple[int, ...]
"""Indices of visible objects, in the order in which they are listed."""

SignedFact: TypeAlias = tuple[str, Fact]
"""A changed fact: ``+`` if it became true, ``-`` if it became false."""


@dataclass(frozen=True, eq=False)
class _VisibleFacts:
    """The facts of one predicate that the agent sees. List and text are made when first used."""

    list_facts: Callable[[], Sequence[Fact]]
    render: Callable[[Iterable[Fact]], Iterable[str]]

    @cached_property
    def facts(self) -> Sequence[Fact]:
        """The visible facts of the predicate, in the order in which they are listed."""
        return self.list_facts()

    @cached_property
    def text(self) -> str:
        """The visible facts of the predicate, as lines of text."""
        return "\n".join(self.render(self.facts))


class _Observation(NamedTuple):
    """A state, with the objects and facts that are visible in it.

    Attributes:
        state: the state.
        visible: the visible objects.
        facts_by_predicate: the visible facts of each predicate, in the order of the benchmark's fact lists.
    """

    state: State
    visible: Indices
    facts_by_predicate: Sequence[_VisibleFacts]

    @property
    def facts_text(self) -> str:
        """The visible facts of all predicates, as lines of text."""
        return "\n".join([facts.text for facts in self.facts_by_predicate if facts.text])


class Observer:
    """Makes the observations of one task. All episodes of the task share an observer.

    Args:
        task: the task.
        wording: the words for facts and objects.
        observe: whether all objects are visible, or only those that the agent sees from its place.
        view: whether every object of the scene can become visible, or only the agent and the objects
            listed in the task's prompts.

    Attributes:
        subjects: objects that can ever be visible, in the order in which they are listed. In a partial view
            this is the order of the scene, which does not show which objects the task needs.
        agent: the acting object; None if the scene has no agent.
        landmarks: objects that the agent knows from the start in a partial view.
        first: the observation of the initial state.
    """

    def __init__(
        self, task: Task, wording: PromptAndAnswerWording, observe: Observe, view: View = "task"
    ) -> None:
        self._task = task
        self._wording = wording
        self._is_full = observe == "full"
        self._names = [wording.object_name(task, index) for index in range(len(task.scene.objects))]
        self._get_kind = cache(partial(wording.describe_object_kind_and_properties, task))
        self.agent = task.scene.agent
        self._egocentric_predicates = {
            predicate.name for predicate in wording.domain.egocentric if view == "scene"
        }
        landmarks = wording.domain.initially_known_object_filter(task.initial, task.scene.everything)
        self.landmarks = () if self._is_full else tuple(iterate_bits(landmarks))
        everything = range(len(task.scene.objects))
        subjects = wording.list_prompt_objects(task) if view == "task" else everything
        self.subjects = tuple(subjects if self._is_full else sorted({*subjects, *self.landmarks}))
        self._rank = {index: rank for rank, index in enumerate(self.subjects)}
        self._mask = make_mask(self.subjects)
        visible = wording.domain.visible or TRUE
        self._visibility_sources = find_stored_dependencies(
            find_predicates(visible), wording.domain.vocabulary
        )
        self.first = self._make_first_observation(task.initial)

    def _make_first_observation(self, state: State) -> _Observation:
        visible = self._find_visible_objects(state)
        return _Observation(
            state,
            visible,
            [
                self._make_visible_facts(listing, state, visible)
                for listing in self._wording.fact_listers_of_state_predicates
            ],
        )

    def render_objects(self, objects: Collection[int]) -> str:
        """Return lines with objects, kinds and properties.

        Objects of equal kind and properties share a line.
        """
        by_kind = group_pairs((self._get_kind(index), index) for index in self.subjects if index in objects)
        return "\n".join([f"{self.render_names(objects)} {kind}" for kind, objects in by_kind.items()])

    def render_names(self, objects: Iterable[int]) -> str:
        """Return the names of objects as text. Names with consecutive numbers become ranges."""
        return join_names_with_number_ranges([self._names[index] for index in objects])

    def render_facts(self, facts: Iterable[Fact]) -> Iterator[str]:
        """Yield lines of text that state the given facts."""
        return write_similar_facts_on_one_line(facts, self._names, self._wording.write_fact_with_names)

    def render_fact(self, fact: Fact) -> str:
        """Return the text of a single fact."""
        return self._wording.write_fact_with_names(
            fact.predicate, [self._names[index] for index in fact.arguments]
        )

    def find_facts_about(self, observation: _Observation, objects: AbstractSet[int]) -> list[Fact]:
        """Return the visible facts about some objects."""
        state, visible = observation.state, observation.visible
        return [
            fact
            for listing in self._wording.fact_listers_of_state_predicates
            for fact in listing.list_facts(
                state, visible, self._find_objects_whose_facts_are_listed(listing, objects)
            )
            if not objects.isdisjoint(fact.arguments)
        ]

    def observe(self, earlier: _Observation, state: State, change: StateChange) -> _Observation:
        """Return the observation of a state, by updating an earlier observation.

        Args:
            earlier: an earlier observation in the same episode.
            state: the state.
            change: the facts that differ between the earlier state and this state.
        """
        changed = change.predicates
        visible = (
            earlier.visible
            if changed.isdisjoint(self._visibility_sources)
            else self._find_visible_objects(state)
        )
        is_same = visible == earlier.visible
        facts = [
            before
            if is_same and changed.isdisjoint(listing.sources)
            else self._make_visible_facts(listing, state, visible)
            for listing, before in zip(
                self._wording.fact_listers_of_state_predicates, earlier.facts_by_predicate, strict=True
            )
        ]
        return _Observation(state, visible, facts)

    def find_visible_changes(
        self, before: _Observation, after: _Observation, state_change: StateChange
    ) -> list[SignedFact]:
        """Return the visible facts that became true, then the visible facts that became false."""
        changed = state_change.predicates
        is_same = before.visible == after.visible
        added: list[Fact] = []
        removed: list[Fact] = []
        for listing, old, new in zip(
            self._wording.fact_listers_of_state_predicates,
            before.facts_by_predicate,
            after.facts_by_predicate,
            strict=True,
        ):
            if changed.isdisjoint(listing.sources):
                continue
            if listing.is_predicate_stored:
                added += self._select_visible_facts(listing, state_change.added, after.visible)
                removed += self._select_visible_facts(listing, state_change.removed, before.visible)
                continue
            if is_same:
                earlier, later = old.facts, new.facts
            else:
                earlier = self._list_visible_facts(listing, before.state, after.visible)
                later = self._list_visible_facts(listing, after.state, before.visible)
            added += _subtract_facts(new.facts, earlier)
            removed += _subtract_facts(old.facts, later)
        return [*[("+", fact) for fact in added], *[("-", fact) for fact in removed]]

    def find_changes_about(
        self, before: _Observation, after: _Observation, objects: AbstractSet[int]
    ) -> list[SignedFact]:
        """Return the facts about some objects that changed between two observations.

        Facts about the agent itself are left out.
        """
        return [
            (sign, fact)
            for sign, fact in self.find_visible_changes(
                before, after, compare_states(before.state, after.state)
            )
            if not objects.isdisjoint(fact.arguments) and self.agent not in fact.arguments
        ]

    def _select_visible_facts(
        self, listing: FactLister, facts: Iterable[Fact], visible: Indices
    ) -> list[Fact]:
        listed = [
            fact for fact in facts if fact.predicate == listing.predicate and listing.is_listed_if_true(fact)
        ]
        if not listed:
            return listed
        objects, required = {*visible}, self._find_objects_whose_facts_are_listed(listing)
        listed = [
            fact
            for fact in listed
            if objects.issuperset(fact.arguments)
            and (required is None or not required.isdisjoint(fact.arguments))
        ]
        return sorted(listed, key=lambda fact: [self._rank[index] for index in fact.arguments])

    def _find_visible_objects(self, state: State) -> Indices:
        if self._is_full:
            return self.subjects
        return tuple(iterate_bits(self._wording.domain.visible_object_filter(state, self._mask)))

    def _list_visible_facts(self, listing: FactLister, state: State, visible: Indices) -> Sequence[Fact]:
        return listing.list_facts(state, visible, self._find_objects_whose_facts_are_listed(listing))

    def _find_objects_whose_facts_are_listed(
        self, fact_lister: FactLister, chosen_objects: AbstractSet[int] | None = None
    ) -> AbstractSet[int] | None:
        """Return the objects whose facts a list of a predicate's facts may contain; None for all objects.

        The objects are ``chosen_objects``. For egocentric predicates, the agent is the only object.
        """
        if fact_lister.predicate not in self._egocentric_predicates:
            return chosen_objects
        return frozenset() if self.agent is None else frozenset((self.agent,))

    def _make_visible_facts(self, listing: FactLister, state: State, visible: Indices) -> _VisibleFacts:
        return _VisibleFacts(partial(self._list_visible_facts, listing, state, visible), self.render_facts)


def _subtract_facts(facts: Iterable[Fact], excluded_facts: Sequence[Fact]) -> list[Fact]:
    excluded = frozenset(excluded_facts)
    return [fact for fact in facts if fact not in excluded]


class AgentMemory:
    """The objects and facts that an agent has seen in one episode.

    Args:
        observer: the observer of the task.
        feedback: what the text after each turn contains: all visible facts, changes, or no facts.
        templates: the templates of texts on visible objects and facts; by default the plain templates.

    Attributes:
        observation: the last observation.
        known: objects that the agent has seen, and objects that it knows from the start (landmarks).
        changes: visible changes by the last command, and earlier changes of objects that are visible again.
        has_looked: whether the agent has looked around since its last action.
    """

    def __init__(
        self, observer: Observer, feedback: Feedback, templates: PromptTemplates | None = None
    ) -> None:
        self._observer = observer
        self._templates = templates or PromptTemplates()
        self._feedback = feedback
        self.observation = observer.first
        self.known = {*self.observation.visible, *observer.landmarks}
        self.changes: list[SignedFact] = []
        self.has_looked = False
        self._seen = {*self.observation.visible}
        self._last_seen: dict[int, _Observation] = {}

    def look_around(self) -> str:
        """Return the visible facts. If the agent looks again without acting, return a note instead."""
        if self.has_looked:
            return "You have looked already: nothing has changed since."
        self.has_looked = True
        return self.describe_objects_and_facts(self.observation.visible)

    def describe_objects_and_facts(self, objects: Collection[int]) -> str:
        """Return text on some objects and the visible facts, or a note that pictures show the facts."""
        described = self._observer.render_objects(objects)
        is_pictured = self._feedback == "pictures"
        facts = "What the pictures show." if is_pictured else self.observation.facts_text or "-"
        values: dict[str, Text] = {
            "objects": described,
            "short_objects": lambda: merge_lines_of_similar_objects(
                expand_shortened_lists(described), join_names_with_number_ranges
            ),
            "facts": facts,
            "short_facts": lambda: merge_lines_of_similar_facts(
                expand_shortened_lists(facts), expand_shortened_lists(described)
            ),
        }
        return self._templates.fill_template("view.txt", values)

    def update_and_describe_changes(self, state: State) -> str:
        """Update the memory with the next state.

        Return text about visible changes, and about the objects that are visible for the first time.
        """
        observer, before = self._observer, self.observation
        stored = compare_states(before.state, state)
        self.observation = after = observer.observe(before, state, stored)
        self.changes = observer.find_visible_changes(before, after, stored)
        news = [*self._render_changes(self.changes)] or ["No fact that you see has changed."]
        new = [index for index in after.visible if index not in self.known]
        self.known.update(new)
        is_brief = self._feedback == "changes" and before.visible != after.visible
        if is_brief:
            new = [index for index in after.visible if index not in self._seen]
            self._seen.update(new)
            news += self._describe_sight_changes(before, new)
        if new:
            news += ["", "You see for the first time:", observer.render_objects(new)]
        if new and is_brief:
            told = {fact for sign, fact in self.changes if sign == "+"}
            facts = [fact for fact in observer.find_facts_about(after, {*new}) if fact not in told]
            news += ["", "Of these:", *(observer.render_facts(facts) if facts else "-")]
        return "\n".join(news)

    def _render_changes(self, changes: Sequence[SignedFact]) -> Iterator[str]:
        for sign, facts in groupby(changes, itemgetter(0)):
            yield from (f"{sign} {line}" for line in self._observer.render_facts(fact for _, fact in facts))

    def _describe_sight_changes(self, before: _Observation, new_objects: Sequence[int]) -> Iterator[str]:
        """Yield lines about objects that went out of sight, or came back with changed facts."""
        observer, after = self._observer, self.observation
        visible, expected = {*after.visible}, {*before.visible, *new_objects}
        gone = [index for index in before.visible if index not in visible]
        back = [index for index in after.visible if index not in expected]
        if gone:
            self._last_seen.update(dict.fromkeys(gone, before))
            kept = [index for index in before.visible if index in visible]
            is_more = len(gone) > len(kept) > 0
            names = f"all but {observer.render_names(kept)}" if is_more else observer.render_names(gone)
            yield f"Gone out of sight: {names}."
        if back:
            yield f"In sight again: {observer.render_names(back)}."
        last_seen = {index: self._last_seen[index] for index in back if index in self._last_seen}
        for earlier in {id(each): each for each in last_seen.values()}.values():
            chosen = {index for index, observation in last_seen.items() if observation is earlier}
            changes = observer.find_changes_about(earlier, after, chosen)
            self.changes += changes
            yield from self._render_changes(changes)


def make_task_text(task: Task, wording: PromptAndAnswerWording, rules: GameRules) -> str:
    """Return the beginning of the first observation: the instruction, the goals and explanations."""
    templates, stated = PromptTemplates(variant=rules.prompts), wording.describe_goals(task)
    agent = task.scene.agent
    notes = [] if agent is None else [f"You are {wording.object_name(task, agent)}."]
    if rules.observe == "partial":
        notes.append("You do not see everything: an action may name only what is listed below or seen later.")
    paragraphs = {
        "goals": f"Goals:\n{stated}" if task.has_goals_in_prompts else "",
        "explained": "\n\n".join(explain_goal_notation("environment", [task], templates)),
        "conventions": "" if wording.conventions is None else wording.conventions(task),
        "notes": " ".join(notes),
    }
    values = {name: f"\n\n{text}" if text else "" for name, text in paragraphs.items()}
    values |= {"title": task.title, "instruction": task.instruction, "stated": stated}
    return templates.fill_template("environment_task.txt", values)


_AT_FIRST = "At first you are told what holds of what you see; nothing else does. Each turn you are told what"
_FEEDBACK: Mapping[Feedback, str] = {
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


def make_manual(benchmark: Benchmark, rules: GameRules) -> str:
    """Return the manual of a world: a text on the predicates and actions of the world."""
    egocentric = benchmark.domain.egocentric if rules.view == "scene" else ()
    names, told = " and ".join([predicate.name for predicate in egocentric]), _FEEDBACK[rules.feedback]
    told = f"{told} {names}: of yourself alone." if names else told
    wording = benchmark.observation_wording()
    values = {
        "told": told,
        "how_to_read": HOW_TO_READ,
        **make_domain_texts_by_placeholder(wording, benchmark.notation.short_texts),
    }
    return PromptTemplates(variant=rules.prompts).fill_template("environment.txt", values)
