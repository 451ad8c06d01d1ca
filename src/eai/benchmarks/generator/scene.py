"""Make closed scenes: some objects of a task's scene, with their containers and supports.

An object may be put into a shut container before a task begins, so that the agent has to open it.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Collection, Iterable, Iterator, MutableMapping, Sequence
from itertools import chain, count
from typing import TypeVar

import eai.logic.formula as f
from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import TaskObject
from eai.benchmarks.generator.measures import find_predicates_showing_or_hiding_contents
from eai.benchmarks.generator.usual_goals import LiteralPattern, UsualGoalsOfDataSet, UsualGoalsOfTaskTitle
from eai.logic.traversal import find_predicates
from eai.planning.effect_schema import make_effect_schemas
from eai.planning.planner import Planner, PlanningGoal
from eai.planning.search import Limits, SearchEndReason
from eai.tasks.task import Task
from eai.world.derived import find_stored_dependencies
from eai.world.domain import Domain
from eai.world.execution import execute_plan
from eai.world.relation import iterate_bits, make_mask
from eai.world.state import Fact, Scene, State, WorldObject

_LIMITS = Limits(100, thorough=False)
"""Limits of the search for a plan that puts an object into a container and shuts the container."""


def make_function_listing_ways_to_hide_objects(
    domain: Domain, usual_goals: UsualGoalsOfDataSet
) -> Callable[[Task], list[LiteralPattern]]:
    """Return a function that lists ways to hide objects of a task, as patterns such as a cup in a cupboard.

    A pattern is listed if all of this holds:

    - Tasks of the data set usually put such an object into such a container.
    - Plans of the data set pick up such objects, and open such containers.
    - Tasks with the title of the given task have a usual goal about such an object, other than this pattern.
    """
    decisive = find_stored_dependencies(find_predicates(domain.visible or f.TRUE), domain.vocabulary)
    names = {lid.predicate for lid in find_predicates_showing_or_hiding_contents(domain)}
    opening = {
        operator.name
        for operator in domain.operators
        if any(schema.atom.predicate in names for schema in make_effect_schemas(operator))
    }
    opened = {category for operator, _, category in usual_goals.uses if operator in opening}
    usual = chain(*(known for theme in usual_goals.themes.values() for known in theme.patterns.values()))
    places = [
        pattern
        for pattern in dict.fromkeys(usual)
        if pattern.truth and len(pattern.categories) == 2 and pattern.predicate in decisive
        if pattern.categories[0] in usual_goals.taken_categories and pattern.categories[1] in opened
    ]

    def find_object_hiding_patterns(task: Task) -> list[LiteralPattern]:
        here, theme = {thing.category for thing in task.scene.objects}, usual_goals.themes[task.title]
        fitting = [place for place in places if here.issuperset(place.categories)]
        return [
            place for place in fitting if _do_other_goals_mention_placed_object(place, theme, usual_goals)
        ]

    return find_object_hiding_patterns


def _do_other_goals_mention_placed_object(
    placement: LiteralPattern, goals_of_title: UsualGoalsOfTaskTitle, usual_goals: UsualGoalsOfDataSet
) -> bool:
    thing = placement.categories[0]
    wanted = [
        p for patterns in goals_of_title.patterns.values() for p in patterns if p.categories[:1] == (thing,)
    ]
    usual = [p for p in wanted if p.truth and usual_goals.used_categories.issuperset(p.categories[1:])]
    asked = (*usual, *chain(*goals_of_title.agent_goal_counts))
    return any(thing in pattern.categories for pattern in asked if pattern != placement)


def hide_object(
    planner: Planner, state: State, relation: str, hidden_object: str, container: str
) -> State | None:
    """Return a state in which a plan has put an object into a shut container, or None if no plan is found.

    The plan may contain any action of the planner's domain.
    """
    index, agent = state.scene.index, state.scene.agent
    objects = [index[hidden_object], index[container], *([] if agent is None else [agent])]
    wanted: list[f.Formula] = [f.Atom(relation, (f.Constant(hidden_object), f.Constant(container)))]
    for lid in sorted(set(find_predicates_showing_or_hiding_contents(planner.domain))):
        shown = f.Atom(lid.predicate, (f.Constant(container),))
        wanted.append(f.Not(shown) if lid.reveals else shown)
    for number in range(1, len(wanted) + 1):
        search = planner.find_plan(state, PlanningGoal(tuple(wanted[:number])), objects, _LIMITS)
        if search.end is not SearchEndReason.SOLVED:
            return None
        state = execute_plan(planner.domain, state, search.plan).final_state
    return state


K = TypeVar("K")

MIN_OBJECTS = 16
"""Minimum number of objects in a generated scene. A smaller scene of the data set keeps all its objects."""


def make_state_with_subset_of_objects(
    task: Task,
    usual_goals: UsualGoalsOfDataSet,
    rng: random.Random,
    max_objects: int,
    *,
    leaves_room_for_other_tasks: bool = False,
    only_relevant: bool = False,
    required_objects: Sequence[int] = (),
    min_objects: int = MIN_OBJECTS,
) -> State:
    """Return a state with some objects of a task: relevant objects, and objects for further goals.

    If an object is kept, the objects that contain or support it are kept too, and so are its parts and its
    whole. A relation that actions can change is kept only if it states a place, or is about the agent. If
    each of two objects is the place of the other, both facts are left out.

    Args:
        task: the task.
        usual_goals: the usual goals, places of objects and actions.
        rng: the random generator.
        max_objects: maximum number of objects.
        leaves_room_for_other_tasks: whether to leave a third of the room to objects of other tasks
            (`add_objects_of_other_tasks`), and to choose objects by random usual goals.
        only_relevant: whether to leave out objects that are not relevant, to make room for the objects that
            `compose_scene_from_tasks` adds.
        required_objects: indices of objects that the scene must contain.
        min_objects: minimum number of objects, if the task has so many. It does not apply if
            `leaves_room_for_other_tasks` is true.
    """
    state = task.initial
    everything = range(len(state.scene.objects))
    size = (
        max_objects * 2 // 3
        if leaves_room_for_other_tasks
        else rng.randint(min(min_objects, max_objects), max_objects)
    )
    chosen: set[int] = (
        set() if state.scene.agent is None else _find_attached_objects(state.scene.agent, state, usual_goals)
    )
    for index in required_objects:
        chosen |= _find_attached_objects(index, state, usual_goals)
    usual = usual_goals.taken_categories | usual_goals.used_categories
    others = [i for i in everything if not usual or state.scene.objects[i].category in usual]
    usually = list_in_random_order(task.relevant, rng)
    usually += () if only_relevant else _order_by_category(others, state.scene, rng)
    for index in (
        _draw_objects_for_random_usual_goals(usual_goals, state.scene, rng)
        if leaves_room_for_other_tasks
        else usually
    ):
        if len(chosen) >= size:
            break
        wider = chosen | _find_attached_objects(index, state, usual_goals)
        if len(wider) <= max_objects:
            chosen = wider
    static = {predicate.name for predicate in state.scene.vocabulary.predicates if predicate.static}

    def is_fact_kept_in_reduced_scene(fact: Fact) -> bool:
        predicate, arguments = fact
        if len(arguments) != 2 or predicate in static:
            return True
        if predicate in usual_goals.place_relations:
            return not state.has(predicate, *reversed(arguments))
        return state.scene.agent in arguments

    return restrict_state(state, sorted(chosen), is_fact_kept_in_reduced_scene)


def add_objects_of_other_tasks(
    reduced_state: State,
    tasks: Sequence[Task],
    usual_goals: UsualGoalsOfDataSet,
    rng: random.Random,
    max_objects: int,
    origins: MutableMapping[str, TaskObject] | None = None,
) -> State:
    """Return the scene with additional portable objects of other tasks (guests).

    A guest keeps its states. It gets the place of a random object of the scene (its host). In its own task,
    the guest must be in a place like the host's, such as on a table: relations and categories are equal. If
    `origins` is given, it gets the name of each guest, and the object from which the guest was made.
    """
    objects, facts = list(reduced_state.scene.objects), list(reduced_state.facts())
    here = {thing.category for thing in objects}
    wanted = {
        pattern.categories[0]
        for (_, truth), known in usual_goals.patterns.items()
        for pattern in known
        if truth and len(pattern.categories) == 2 and pattern.categories[1] in here
    }
    taken = [i for i, thing in enumerate(objects) if thing.category in usual_goals.taken_categories]
    hosts = group_pairs(
        (describe_place_by_relation_and_category(i, reduced_state, usual_goals), i) for i in taken
    )
    for _ in range(_DRAWS_PER_GUEST * (max_objects - len(objects))):
        if len(objects) >= max_objects:
            break
        home = rng.choice(tasks)
        if not home.relevant:
            continue
        guest = rng.choice(home.relevant)
        thing = home.scene.objects[guest]
        standing = describe_place_by_relation_and_category(guest, home.initial, usual_goals)
        if (
            thing.category in wanted & usual_goals.taken_categories - usual_goals.part_categories
            and standing in hosts
            and standing
        ):
            host = rng.choice(hosts[standing])
            facts += _append_similar_object(
                objects, thing, find_states_of_object(guest, home.initial), host, reduced_state, usual_goals
            )
            if origins is not None:
                origins[objects[-1].name] = home, guest
    return Scene(reduced_state.scene.vocabulary, objects, reduced_state.scene.agent).state(facts)


def add_portable_objects_similar_to_existing(
    state: State,
    usual_goals: UsualGoalsOfDataSet,
    rng: random.Random,
    max_objects: int,
    categories: Collection[str],
    origins: MutableMapping[str, TaskObject] | None = None,
) -> State:
    """Return the scene with up to five more portable objects, each like a random object of the scene.

    A new object has the category, the states and the place of that object. Only objects of `categories` are
    chosen, and only if some task has several objects of the category. `origins` maps names of objects to the
    objects of tasks from which they were made. A new object gets the entry of the object that it is like.
    """
    objects, facts = list(state.scene.objects), list(state.facts())
    usual = usual_goals.countable_categories & usual_goals.taken_categories & frozenset(categories)
    hosts = [
        i
        for i, thing in enumerate(objects)
        if thing.category in usual and describe_place_by_relation_and_category(i, state, usual_goals)
    ]
    number = rng.randint(1, _MAX_SIMILAR_OBJECTS)
    for _ in range(min(number, max_objects - len(objects)) if hosts else 0):
        host = rng.choice(hosts)
        facts += _append_similar_object(
            objects, objects[host], find_states_of_object(host, state), host, state, usual_goals
        )
        if origins is not None and objects[host].name in origins:
            origins[objects[-1].name] = origins[objects[host].name]
    return Scene(state.scene.vocabulary, objects, state.scene.agent).state(facts)


def add_copy_of_object(
    state: State, usual_goals: UsualGoalsOfDataSet, original_object: int, object_with_wanted_place: int
) -> State:
    """Return the state with a copy of `original_object`, in the place of `object_with_wanted_place`.

    The copy has the states and static relations of the original, such as its size.
    """
    scene, objects, facts = state.scene, list(state.scene.objects), list(state.facts())
    more = _append_similar_object(
        objects,
        objects[original_object],
        find_states_of_object(original_object, state),
        object_with_wanted_place,
        state,
        usual_goals,
    )
    known = set(facts)
    for name, arguments in facts:
        stored = scene.vocabulary.find_stored_predicate(name)
        is_fixed = stored is not None and stored.static
        model = original_object if is_fixed else object_with_wanted_place
        if len(arguments) == 2 and model in arguments and (is_fixed or (name, arguments[::-1]) in known):
            more.append(Fact(name, tuple([len(scene.objects) if i == model else i for i in arguments])))
    return Scene(scene.vocabulary, objects, scene.agent).state([*facts, *more])


def has_no_contents(object_index: int, state: State, usual_goals: UsualGoalsOfDataSet) -> bool:
    """Whether no object is in or on the given object.

    Symmetric relations, such as being beside the object, do not count.
    """
    relations = map(state.relation, usual_goals.place_relations)
    return not any(relation.column(object_index) & ~relation.row(object_index) for relation in relations)


def _append_similar_object(
    objects: list[WorldObject],
    original: WorldObject,
    states: Iterable[str],
    object_with_wanted_place: int,
    state: State,
    usual_goals: UsualGoalsOfDataSet,
) -> list[Fact]:
    """Append an object like `original` to `objects`, and return its facts.

    The object has the given states, and the place of the object `object_with_wanted_place`.
    """
    another = len(objects)
    objects.append(WorldObject(make_free_name(original.name, objects), original.category))
    places = [
        (name, target)
        for name in usual_goals.place_relations
        for target in iterate_bits(state.relation(name).row(object_with_wanted_place))
    ]
    own = [Fact(name, (another,)) for name in states]
    return [*own, *(Fact(name, (another, target)) for name, target in places)]


_MAX_SIMILAR_OBJECTS = 5
"""Maximum number of objects added to a scene so that a category has several objects."""

_DRAWS_PER_GUEST = 30
"""Maximum number of random draws from the objects of other tasks, for each object that a scene may still get.

Most drawn objects do not fit. Either no usual goal (`UsualGoalsOfDataSet`) relates them to an object of the
scene, or no object of the scene has a place like theirs, such as on a table.
"""


def describe_place_by_relation_and_category(
    object_index: int, state: State, usual_goals: UsualGoalsOfDataSet
) -> frozenset[tuple[str, str]]:
    """Return pairs: a relation that places the object, and the category of the object at that place.

    The result is empty for an object that has parts or is a part of another object.
    """
    if any(
        state.relation(name).row(object_index) | state.relation(name).column(object_index)
        for name in usual_goals.part_relations
    ):
        return frozenset()
    things = state.scene.objects
    return frozenset(
        (name, things[target].category)
        for name in usual_goals.place_relations
        for target in iterate_bits(state.relation(name).row(object_index))
    )


def find_states_of_object(index: int, state: State) -> Iterator[str]:
    """Yield the names of the predicates of one argument that hold for an object."""
    unary = (predicate.name for predicate in state.scene.vocabulary.predicates if predicate.arity == 1)
    return (name for name in unary if state.has(name, index))


def make_free_name(name: str, objects: Sequence[WorldObject]) -> str:
    """Return the given name if it is free, or else the name with another number at its end.

    The name is free if no object has this name, and no name of an object ends in the same number.
    """
    taken = {number[0] for other in objects if (number := re.search(r"\d+$", other.name))}
    stem = re.sub(r"\d+$", "", name)
    stem = f"{stem}_" if stem == name else stem
    if name not in {other.name for other in objects} and name.removeprefix(stem) not in taken:
        return name
    return next(f"{stem}{number}" for number in count(len(objects)) if str(number) not in taken)


def list_in_random_order(indices: Sequence[K], rng: random.Random) -> list[K]:
    """Return the items in random order."""
    return rng.sample(indices, len(indices))


def _order_by_category(indices: Sequence[int], scene: Scene, rng: random.Random) -> Iterator[int]:
    """Yield objects in random order: one object of each category, then a second of each, and so on."""
    ranked: dict[str, int] = {}
    order = []
    for index in list_in_random_order(indices, rng):
        category = scene.objects[index].category
        ranked[category] = ranked.get(category, -1) + 1
        order.append((ranked[category], rng.random(), index))
    return (index for _, _, index in sorted(order))


def _draw_objects_for_random_usual_goals(
    usual_goals: UsualGoalsOfDataSet, scene: Scene, rng: random.Random
) -> Iterator[int]:
    """Yield objects that random usual goals need. Objects can repeat.

    A usual goal names categories of objects. Each category gives a random object of the scene. Goals with a
    category that the scene lacks are skipped.
    """
    for pattern in list_in_random_order(
        [p for (_, truth), known in usual_goals.patterns.items() if truth for p in known], rng
    ):
        members = [list(iterate_bits(scene.get_category_mask(category))) for category in pattern.categories]
        if all(members):
            yield from map(rng.choice, members)


def _find_attached_objects(object_index: int, state: State, usual_goals: UsualGoalsOfDataSet) -> set[int]:
    """Return the indices of an object and of all objects that are directly or indirectly attached to it.

    Attached to an object are its containers and supports, its parts and its whole.
    """
    attached, pending = set(), [object_index]
    while pending:
        current = pending.pop()
        if current in attached:
            continue
        attached.add(current)
        for name in usual_goals.place_relations:
            pending += iterate_bits(state.relation(name).row(current))
        for name in usual_goals.part_relations:
            pending += iterate_bits(state.relation(name).row(current) | state.relation(name).column(current))
    return attached


def restrict_state(
    state: State, kept: Sequence[int], should_keep_fact: Callable[[Fact], bool] | None = None
) -> State:
    """Return a state with only some of the objects, which get new indices, and with the facts about them.

    Args:
        state: the state.
        kept: the kept objects, in order; they must include the agent.
        should_keep_fact: tells whether to keep a fact about these objects; None to keep all facts.
    """
    scene, number = state.scene, {index: i for i, index in enumerate(kept)}
    agent = None if scene.agent is None else number[scene.agent]
    return Scene(scene.vocabulary, [scene.objects[i] for i in kept], agent).state(
        Fact(fact.predicate, tuple([number[i] for i in fact.arguments]))
        for fact in state.facts(make_mask(kept))
        if should_keep_fact is None or should_keep_fact(fact)
    )
