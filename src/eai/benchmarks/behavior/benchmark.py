"""The benchmark BEHAVIOR, and the goal section of its official prompts for goals that a model stated.

For these prompts, a published program copies the goals from a model's answer to goal interpretation, one goal
a line (``generate_goal_subgoal_.pipeline_prompts.py``, ``bddl_to_tl.py``, revision 66a407d). The program does
not interpret the goals, and neither does this module. If the form of the answer is wrong, the copied lines
therefore differ from the answer:

- Names of predicates are spelt like names of objects: ``next_to`` becomes ``next.to``.
- A word in place of a condition is split into letters: ``["not", "dusty", "bed.n.01_1"]`` becomes ``not d(u,
  s, t, y)``.
- A condition that is stated twice appears twice.

Goals at which the program stops with an error are left out here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial

from eai.abilities.notation.goals import drop_list_around_operands
from eai.abilities.notation.notation import Notation
from eai.abilities.protocol import Ability
from eai.abilities.verdict import Unreadable
from eai.base.grouping import group_pairs
from eai.benchmarks.behavior.activities import make_activity_problem_reader, write_task_problem
from eai.benchmarks.behavior.domain import make_domain_with_checks_in_paper_order
from eai.benchmarks.behavior.notation import PLANS, BehaviorGoalNotation, BehaviorSubgoalNotation
from eai.benchmarks.behavior.predicates import GOAL_RELATIONS, GOAL_STATES, part_of
from eai.benchmarks.behavior.tasks import compare_object_sizes_across_tasks, get_category_of_3d_model
from eai.benchmarks.behavior.tasks import open_tasks as open_behavior_tasks
from eai.benchmarks.benchmark import Benchmark, DataSet, read_answer_formats, read_texts_for_short_prompts
from eai.benchmarks.errata import load_errata
from eai.benchmarks.published import make_reader_of_published_prompts, open_behavior_transition_tasks
from eai.benchmarks.reference_wheel import find_task_id
from eai.benchmarks.registry import TITLES
from eai.tasks.english import read_english_words
from eai.tasks.prompts.prompt import BelievedTask, GoalSection
from eai.tasks.source import cache_opened_tasks_per_data_folder
from eai.tasks.task import Task
from eai.tasks.wording import ObjectName, PromptAndAnswerWording, get_declared_object_name

_NOTATION = BehaviorGoalNotation()


def _format_goals_in_model_answer_as_lists(believed_task: BelievedTask) -> str:
    """Return each goal of an answer as a flat list with objects by name: ``['not', 'open', 'jar_0']``."""
    spelling = _map_instance_to_object_names(believed_task)
    entries = [
        [spelling.get(word, word) for word in _yield_nested_words(entry)]
        for entry in _read_goals_in_model_answer(believed_task)
    ]
    return "\n".join([str(words) for words in entries if words])


def _format_goals_in_model_answer_as_formulas(believed_task: BelievedTask) -> str:
    """Return each goal of an answer as a formula: ``forall(jar_n_01, (not open(jar_n_01)))``."""
    names = _map_instance_to_object_names(believed_task)
    categories = {obj.category for obj in believed_task.task.scene.objects}

    def spell_as_in_subgoals(word: str) -> str:
        if word in categories:
            return word.replace(".", "_")
        return _spell_object_for_subgoal_prompt(names.get(word, word))

    formulas = [
        _format_formula(entry, spell_as_in_subgoals, nested=False)
        for entry in _read_goals_in_model_answer(believed_task)
    ]
    return "\n".join([formula for formula in formulas if formula is not None])


GOAL_SECTIONS: Mapping[Ability, GoalSection] = {
    Ability.ACTION_SEQUENCING: GoalSection(
        "target environment state:\n", "\n\n\ninteractable objects", _format_goals_in_model_answer_as_lists
    ),
    Ability.SUBGOAL_DECOMPOSITION: GoalSection(
        "## Goal States\n", "\n\n## Output", _format_goals_in_model_answer_as_formulas
    ),
}
"""Ability -> section of the official prompts that states the goals."""


def _read_goals_in_model_answer(believed_task: BelievedTask) -> Iterator[object]:
    """Yield the goals in an answer. Goals about states come first. An unreadable answer gives no goals."""
    entries = _NOTATION.read_entries(believed_task.answer)
    return iter(
        () if isinstance(entries, Unreadable) else [_remove_needless_brackets(entry) for _, entry in entries]
    )


def _map_instance_to_object_names(believed_task: BelievedTask) -> Mapping[str, str]:
    objects = believed_task.task.scene.objects
    return {
        instance: obj.name
        for instance, obj in zip(_NOTATION.list_object_names(believed_task.task), objects, strict=True)
    }


def _remove_needless_brackets(goal: object) -> object:
    """Return a goal without superfluous brackets: a list whose only item is a list becomes this item."""
    match goal:
        case [[*_] as inner]:
            return _remove_needless_brackets(inner)
        case [*items]:
            return [_remove_needless_brackets(item) for item in items]
        case _:
            return goal


def _yield_nested_words(entry: object) -> Iterator[str]:
    match entry:
        case str(word):
            yield word
        case [*items]:
            for item in items:
                yield from _yield_nested_words(item)


def _spell_object_for_subgoal_prompt(name: str) -> str:
    """Return a name as subgoal prompts spell objects: ``carton_n_02.2`` for ``carton.n.02_2``."""
    if "toggled" in name:
        return "toggledon"
    return ".".join(name.replace(".", "_").rsplit("_", 1)) if "_" in name else name


def _format_formula(entry: object, spelling: Callable[[str], str], *, nested: bool) -> str | None:
    """Return a goal as a formula, or None if it is not a condition. Operands of a connective get brackets."""
    match entry:
        case ["not", operand, *_]:
            inner = _format_formula(operand, spelling, nested=True)
            return None if inner is None else _put_in_brackets(f"not {inner}", nested)
        case ["and" | "or" as word, first, *others]:
            texts = [
                _format_formula(operand_entry, spelling, nested=True)
                for operand_entry in drop_list_around_operands((first, *others))
            ]
            readable = [text for text in texts if text is not None]
            if len(readable) == len(texts):
                return _put_in_brackets(f" {word} ".join(readable), nested)
            return None
        case ["forall" | "exists" | "forn" | "forpairs" | "fornpairs" as word, *head, body]:
            inner = _format_formula(body, spelling, nested=True)
            bound = [spelling(words[-1]) for item in head if (words := [*_yield_nested_words(item)])]
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


def _put_in_brackets(text: str, nested: bool) -> str:
    return f"({text})" if nested else text


_GOAL_PREDICATES = (*(state.name for state in GOAL_STATES), *(relation.name for relation in GOAL_RELATIONS))
_HANDS = {"in_right_hand": "holds_rh", "in_left_hand": "holds_lh"}


NAME = "behavior"


def make_wording(ability: Ability) -> PromptAndAnswerWording:
    """Return the words by which prompts of an ability name objects and predicates.

    Prompts of subgoal decomposition also state which hand holds an object. Prompts of goal interpretation
    name objects as problem files do.
    """
    if ability is Ability.GOAL_INTERPRETATION:
        return PromptAndAnswerWording(
            make_domain_with_checks_in_paper_order(), _GOAL_PREDICATES, {}, _get_instance_name
        )
    predicates, written_as, names = _GOAL_PREDICATES, dict[str, str](), get_declared_object_name
    if ability is Ability.SUBGOAL_DECOMPOSITION:
        predicates, names = (*_GOAL_PREDICATES, *_HANDS), _get_object_name_in_subgoals
        written_as = {**_HANDS, "toggled_on": "toggledon"}
    halves = partial(_describe_halves_made_by_slicing, names)
    return PromptAndAnswerWording(
        make_domain_with_checks_in_paper_order(),
        predicates,
        written_as,
        names,
        conventions=halves,
        hands=tuple(_HANDS),
        unchanging=(part_of.name,),
    )


def _describe_halves_made_by_slicing(name_of: ObjectName, task: Task) -> str:
    halves = group_pairs((whole, half) for half, whole in task.initial.relation(part_of.name).pairs())
    return "\n".join(
        f"SLICE makes {' and '.join([name_of(task, i) for i in half_indices])} of {name_of(task, whole)}."
        for whole, half_indices in halves.items()
    )


def _get_object_name_in_subgoals(task: Task, index: int) -> str:
    """Return an object's name in subgoals: ``rag.51`` for ``rag_51``."""
    return ".".join(get_declared_object_name(task, index).rsplit("_", 1))


def _get_instance_name(task: Task, index: int) -> str:
    """Return an object's name in its problem file: ``rag.n.01_1``."""
    return _NOTATION.list_object_names(task)[index]


open_tasks = cache_opened_tasks_per_data_folder(open_behavior_tasks)
"""Returns the 100 tasks of BEHAVIOR."""

open_operators = cache_opened_tasks_per_data_folder(open_behavior_transition_tasks)
"""Returns BEHAVIOR's 100 tasks of transition modeling."""


GOAL_LABELS: Mapping[str, str] = {
    "inside": "transport",
    "ontop": "transport",
    "onfloor": "transport",
    "under": "transport relational-goal",
    "nextto": "transport relational-goal",
    "touching": "transport relational-goal",
    "open": "articulated",
    "toggled_on": "device-operation",
    "cooked": "thermal irreversible",
    "frozen": "thermal",
    "dusty": "surface-treatment",
    "stained": "surface-treatment",
    "sliced": "cutting irreversible",
}
"""Goal predicate -> labels of tasks with such a goal, such as ``transport`` (`eai.benchmarks.labels`)."""


def behavior() -> Benchmark:
    """Return the benchmark BEHAVIOR."""
    return Benchmark(
        NAME,
        make_domain_with_checks_in_paper_order(),
        open_tasks,
        Notation(
            PLANS,
            BehaviorGoalNotation(),
            BehaviorSubgoalNotation(),
            formats=read_answer_formats("eai.benchmarks.behavior"),
            short_texts=read_texts_for_short_prompts("eai.benchmarks.behavior"),
            wordings=make_wording,
            also_observed=("in_left_hand", "in_right_hand", "robot_on"),
            english=read_english_words("eai.benchmarks.behavior"),
        ),
        DataSet(
            TITLES[NAME],
            load_errata(NAME),
            make_reader_of_published_prompts(NAME),
            goal_sections=GOAL_SECTIONS,
            task_id_of=find_task_id,
            own_tasks={Ability.TRANSITION_MODELING: open_operators},
            problem_of=write_task_problem,
            open_bddl=lambda source: make_activity_problem_reader(open_tasks(source)),
            planner_seconds=200,
            labels=GOAL_LABELS,
            compare_objects=compare_object_sizes_across_tasks,
            model_of=get_category_of_3d_model,
        ),
    )
