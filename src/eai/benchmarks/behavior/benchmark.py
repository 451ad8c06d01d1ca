"""BEHAVIOR as a benchmark, and how its official prompts state goals that a model interpreted itself.

The published pipeline passes on what an answer says, not what it means, one entry a line
(``generate_goal_subgoal_.pipeline_prompts.py``, ``bddl_to_tl.py``, revision 66a407d). Three of its ways show
only in answers of another form: names that are no object's are spelt by a rule made for names of
objects, so that ``next_to`` is ``next.to``; a bare word in the place of a condition is taken apart into
letters, so that ``["not", "dusty", "bed.n.01_1"]`` is ``not d(u, s, t, y)``; and a condition stated twice
stands there twice. Entries of which it makes nothing, where it stops, are left out here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial

from eai.abilities.notation.goals import unwrap_parts
from eai.abilities.notation.notation import Notation
from eai.abilities.protocol import Ability
from eai.abilities.verdict import Unreadable
from eai.base.grouping import group_pairs
from eai.benchmarks.behavior.activities import open_activities, problem_text
from eai.benchmarks.behavior.domain import as_meant
from eai.benchmarks.behavior.notation import PLANS, BehaviorGoals, BehaviorSubgoals
from eai.benchmarks.behavior.predicates import GOAL_RELATIONS, GOAL_STATES, part_of
from eai.benchmarks.behavior.tasks import open_tasks as open_behavior_tasks
from eai.benchmarks.benchmark import Benchmark, DataSet, formats_of
from eai.benchmarks.errata import errata_of
from eai.benchmarks.published import official_prompts, open_behavior
from eai.benchmarks.reference_wheel import published_task
from eai.benchmarks.registry import TITLES
from eai.tasks.english import english_of
from eai.tasks.prompts.prompt import Belief, GoalSection
from eai.tasks.source import once_per_store
from eai.tasks.task import Task
from eai.tasks.wording import ObjectName, Wording, declared_name

_NOTATION = BehaviorGoals()


def _for_plans(belief: Belief) -> str:
    """Each entry as a flat list, objects by name: ``['not', 'open', 'jar_0']``."""
    spelling = _names(belief)
    entries = [[spelling.get(word, word) for word in _words(entry)] for entry in _entries(belief)]
    return "\n".join([str(words) for words in entries if words])


def _for_subgoals(belief: Belief) -> str:
    """Each entry as a formula: ``forall(jar_n_01, (not open(jar_n_01)))``."""
    names = _names(belief)
    categories = {thing.category for thing in belief.task.scene.objects}

    def spelling(word: str) -> str:
        return word.replace(".", "_") if word in categories else _numbered(names.get(word, word))

    formulas = [_formula(entry, spelling, nested=False) for entry in _entries(belief)]
    return "\n".join([formula for formula in formulas if formula is not None])


GOAL_SECTIONS: Mapping[Ability, GoalSection] = {
    Ability.ACTION_SEQUENCING: GoalSection(
        "target environment state:\n", "\n\n\ninteractable objects", _for_plans
    ),
    Ability.SUBGOAL_DECOMPOSITION: GoalSection("## Goal States\n", "\n\n## Output", _for_subgoals),
}
"""Where the official prompts state the goals."""


def _entries(belief: Belief) -> Iterator[object]:
    """The entries of an answer, states first; none of an answer that cannot be read."""
    entries = _NOTATION.entries(belief.answer)
    return iter(() if isinstance(entries, Unreadable) else [_unwrapped(entry) for _, entry in entries])


def _names(belief: Belief) -> Mapping[str, str]:
    """The name of the object that an instance is."""
    things = belief.task.scene.objects
    return {
        instance: thing.name for instance, thing in zip(_NOTATION.names(belief.task), things, strict=True)
    }


def _unwrapped(entry: object) -> object:
    """The entry without lists around a single list."""
    match entry:
        case [[*_] as inner]:
            return _unwrapped(inner)
        case [*parts]:
            return [_unwrapped(part) for part in parts]
        case _:
            return entry


def _words(entry: object) -> Iterator[str]:
    match entry:
        case str(word):
            yield word
        case [*parts]:
            for part in parts:
                yield from _words(part)


def _numbered(name: str) -> str:
    """A name as names of objects are written, ``carton.n.02_2`` as ``carton_n_02.2``."""
    if "toggled" in name:
        return "toggledon"
    return ".".join(name.replace(".", "_").rsplit("_", 1)) if "_" in name else name


def _formula(entry: object, spelling: Callable[[str], str], *, nested: bool) -> str | None:
    """An entry as a formula, in brackets where it stands below a connective; None where it is none."""
    match entry:
        case ["not", operand, *_]:
            inner = _formula(operand, spelling, nested=True)
            return None if inner is None else _bracketed(f"not {inner}", nested)
        case ["and" | "or" as word, first, *others]:
            texts = [_formula(part, spelling, nested=True) for part in unwrap_parts((first, *others))]
            known = [text for text in texts if text is not None]
            return _bracketed(f" {word} ".join(known), nested) if len(known) == len(texts) else None
        case ["forall" | "exists" | "forn" | "forpairs" | "fornpairs" as word, *head, body]:
            inner = _formula(body, spelling, nested=True)
            bound = [spelling(each[-1]) for part in head if (each := [*_words(part)])]
            return None if inner is None else f"{word}({', '.join([*bound, inner])})"
        case ["not" | "and" | "or", *_]:
            return None
        case [str(predicate), *names] if all(isinstance(name, str) for name in names):
            return f"{spelling(predicate)}({', '.join([spelling(str(name)) for name in names])})"
        case str(word) if word:
            letters = spelling(word)
            return f"{letters[0]}({', '.join(letters[1:])})"
        case _:
            return None


def _bracketed(text: str, nested: bool) -> str:
    return f"({text})" if nested else text


_GOAL_PREDICATES = (*(state.name for state in GOAL_STATES), *(each.name for each in GOAL_RELATIONS))
_HANDS = {"in_right_hand": "holds_rh", "in_left_hand": "holds_lh"}


NAME = "behavior"


def wording(ability: Ability) -> Wording:
    """The words for an ability: subgoals also speak of hands, goal interpretation names instances."""
    if ability is Ability.GOAL_INTERPRETATION:
        return Wording(as_meant(), _GOAL_PREDICATES, {}, _instance_name)
    predicates, written_as, names = _GOAL_PREDICATES, dict[str, str](), declared_name
    if ability is Ability.SUBGOAL_DECOMPOSITION:
        predicates, names = (*_GOAL_PREDICATES, *_HANDS), _dotted_name
        written_as = {**_HANDS, "toggled_on": "toggledon"}
    halves = partial(_describe_halves, names)
    return Wording(as_meant(), predicates, written_as, names, conventions=halves, unchanging=(part_of.name,))


def _describe_halves(name: ObjectName, task: Task) -> str:
    """Return a line for each object that can be sliced, with its halves."""
    halves = group_pairs((whole, part) for part, whole in task.initial.relation(part_of.name).pairs())
    return "\n".join(
        f"SLICE makes {' and '.join([name(task, part) for part in parts])} of {name(task, whole)}."
        for whole, parts in halves.items()
    )


def _dotted_name(task: Task, index: int) -> str:
    """``rag_51`` as subgoals write it: ``rag.51``."""
    return ".".join(declared_name(task, index).rsplit("_", 1))


def _instance_name(task: Task, index: int) -> str:
    """The name of an object in its problem file: ``rag.n.01_1``."""
    return _NOTATION.names(task)[index]


open_tasks = once_per_store(open_behavior_tasks)
"""Opens the 100 tasks."""

open_operators = once_per_store(open_behavior)
"""Opens the 100 tasks of transition modeling."""


def behavior() -> Benchmark:
    """The benchmark."""
    return Benchmark(
        NAME,
        as_meant(),
        open_tasks,
        Notation(
            PLANS,
            BehaviorGoals(),
            BehaviorSubgoals(),
            formats=formats_of("eai.benchmarks.behavior"),
            wordings=wording,
            also_observed=("in_left_hand", "in_right_hand", "robot_on"),
            english=english_of("eai.benchmarks.behavior"),
        ),
        DataSet(
            TITLES[NAME],
            errata_of(NAME),
            official_prompts(NAME),
            goal_sections=GOAL_SECTIONS,
            task_id_of=published_task,
            own_tasks={Ability.TRANSITION_MODELING: open_operators},
            problem_of=problem_text,
            open_bddl=lambda source: open_activities(open_tasks(source)),
            planner_seconds=200,
        ),
    )
