"""The line format of task files: read a task from a line of JSON, and write a task as a line.

Goals are texts such as ``forall l: lamp. (lit(l))``, with declared names and names of objects
(`eai.tasks.goal_text`). An underscore stands for each character that names in formulas cannot contain.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, fields
from inspect import cleandoc
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, JsonValue, ValidationError

import eai.logic.formula as f
from eai.base.docstrings import read_docstring_entries
from eai.base.errors import InputError, prefix_errors_with_location
from eai.base.files import make_dict_refusing_repeated_keys
from eai.base.json_value import Json
from eai.logic.ltl_printer import format_ltl
from eai.logic.rewriting import rewrite_state_subformulas, standardize_variable_names
from eai.logic.signature import describe_wrong_arity
from eai.tasks.goal_text import make_goal_lexicon, read_goal
from eai.tasks.options import describe_validation_error
from eai.tasks.special import (
    AmbiguousTaskMark,
    HazardousTaskMark,
    PossiblyImpossibleTaskMark,
    SpecialTaskMark,
)
from eai.tasks.task import Goal, Task, goal
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.state import Scene, State

Names: TypeAlias = Annotated[list[str], Field(max_length=2)]
_NonEmptyText: TypeAlias = Annotated[str, Field(min_length=1)]
_Plan: TypeAlias = list[Annotated[list[str], Field(min_length=1)]]


def _add_descriptions(schema: dict[str, Any]) -> None:
    """Copy the descriptions of attributes from the docstring of `_TaskLine` into its JSON schema."""
    schema["description"] = cleandoc(_TaskLine.__doc__ or "").partition("\n\n")[0]
    for name, meaning in read_docstring_entries(_TaskLine.__doc__, "Attributes").items():
        schema["properties"][name]["description"] = meaning


class _TaskLine(BaseModel):
    """A task as one line of a task file.

    Attributes:
        id: The id in answers and records; unique.
        version: Version of this format.
        base: The benchmark whose world the task is in, by name, module:object or pddl:...
        title: The name that tasks of the same kind share; the id if empty.
        instruction: The task in natural language.
        objects: All objects: name -> category, in order; may be empty.
        agent: The acting object, if the domain has one.
        relevant: The objects that the task is about; all objects if missing.
        facts: The facts of the initial state: predicate -> list of objects, or, for predicates of 0 or 2
            objects, list of lists of objects.
        goals: Formulas about the final state or the whole execution, or actions to execute.
        plan: A plan that solves the task: one list per action, with the operator and its objects.
        hazards: The names of hazards, one for each of the last goals, which prevent them.
        untold: Whether prompts hide the goals about hazards.
        missing: If present, an answer may call the task impossible. Lists the missing facts that make it so;
            empty if there is a plan.
        fits: If present, prompts state the goals by the instruction alone, and an answer may ask what it
            means. Lists the objects that the instruction may mean; the meant object is first.
        about: Further information on the task, which the program does not read.
        shortest: The shortest known plan, as `eai check --references` finds it.
        reference: Actions that win a game in the standard setting, as `eai check --references` finds them.
    """

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, title="Task", json_schema_extra=_add_descriptions
    )

    id: _NonEmptyText
    version: Literal[1] = 1
    base: _NonEmptyText
    title: str = ""
    instruction: _NonEmptyText
    objects: dict[str, str]
    agent: str | None = None
    relevant: list[str] | None = None
    facts: dict[str, list[str | Names]]
    goals: Annotated[list[str], Field(min_length=1)]
    plan: _Plan = []
    hazards: list[str] = []
    untold: bool = False
    missing: list[str] | None = None
    fits: Annotated[list[str] | None, Field(min_length=1)] = None
    about: dict[str, JsonValue] = {}
    shortest: _Plan = []
    reference: _Plan = []


def make_task_line_schema() -> dict[str, JsonValue]:
    """Return the JSON Schema of a line of a task file."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **_TaskLine.model_json_schema()}


def read_task_line(text: str | bytes) -> _TaskLine:
    """Return the parsed line of a task file, with members of the right types.

    Raises:
        InputError: the line is not JSON, or a member of its object is wrong. The message names the member and
            the expected value.
    """
    try:
        value = json.loads(text, strict=False, object_pairs_hook=make_dict_refusing_repeated_keys)
        if not isinstance(value, dict):
            raise InputError('expected a task as a JSON object with the string "id"')
        return _TaskLine.model_validate(value)
    except json.JSONDecodeError as error:
        raise InputError(f"column {error.colno}: expected JSON ({error.msg})") from error
    except (UnicodeDecodeError, RecursionError) as error:
        raise InputError(f"expected JSON in UTF-8 ({error})") from error
    except ValidationError as error:
        raise InputError(describe_validation_error(error, _TaskLine.model_fields)) from error


def make_task_from_line(line: _TaskLine, domain: Domain) -> Task:
    """Return the task that a parsed line describes.

    Raises:
        InputError: a name in the line is not declared. The message gives the JSON member and expected names.
    """
    index_by_name = {name: index for index, name in enumerate(line.objects)}
    agent = None if line.agent is None else _find_object_index(line.agent, index_by_name, "agent")
    if agent is None and any(operator.mentions_agent for operator in domain.compiled_operators.values()):
        raise InputError(f"agent: expected the object that acts, because actions of {domain.name} mention it")
    scene = Scene(domain.vocabulary, line.objects, agent)
    relevant = line.objects if line.relevant is None else line.relevant
    goals = tuple(map(goal, _read_goals(line, domain, scene)))
    return Task(
        id=line.id,
        title=line.title or line.id,
        instruction=line.instruction,
        initial=_read_initial_state(line, scene),
        goals=goals,
        relevant=tuple(
            [_find_object_index(name, scene.index, "relevant") for name in dict.fromkeys(relevant)]
        ),
        script=tuple(_read_plan("plan", line.plan, domain, scene)),
        special=_read_special_task_mark(line, goals, scene),
        shortest_plan=tuple(_read_plan("shortest", line.shortest, domain, scene)),
        reference_plan=tuple(_read_plan("reference", line.reference, domain, scene)),
    )


def _read_special_task_mark(line: _TaskLine, goals: Sequence[Goal], scene: Scene) -> SpecialTaskMark | None:
    number = len(line.hazards)
    if not all(goal.is_temporal for goal in goals[len(goals) - number :]) or number >= len(goals):
        raise InputError(
            f"hazards: expected the last {number} of `goals` to be about the whole execution, one for each "
            "hazard, after at least one other goal"
        )
    if line.untold and not number:
        raise InputError("`untold` is true, so `hazards` must list the hazards that the question leaves out")
    special: list[SpecialTaskMark] = [HazardousTaskMark(tuple(line.hazards), line.untold)] if number else []
    special += [] if line.missing is None else [PossiblyImpossibleTaskMark(tuple(line.missing))]
    special += [] if line.fits is None else [AmbiguousTaskMark(tuple(line.fits))]
    for name in line.fits or ():
        _find_object_index(name, scene.index, "fits")
    if len(special) > 1:
        names = [fields(value)[0].name for value in special]
        raise InputError(f"{' and '.join(names)}: expected only one of these members")
    return special[0] if special else None


def _read_initial_state(line: _TaskLine, scene: Scene) -> State:
    stated = [(name, entry) for name, entries in line.facts.items() for entry in entries]
    with prefix_errors_with_location("facts"):
        return scene.state((name, [entry] if isinstance(entry, str) else entry) for name, entry in stated)


def _find_object_index(name: str, index_by_name: Mapping[str, int], location: str) -> int:
    if name not in index_by_name:
        raise InputError(f"{location}: expected the name of an object of the task, found {name!r}")
    return index_by_name[name]


def _read_goals(line: _TaskLine, domain: Domain, scene: Scene) -> Iterable[f.Formula]:
    """Return the goals of a line without duplicates."""
    numbers: dict[f.Formula, int] = {}
    for number, text in enumerate(line.goals):
        with prefix_errors_with_location(f"goals.{number}"):
            first = numbers.setdefault(read_goal(text, domain, scene), number)
            if line.hazards and first < number:
                raise InputError(
                    f"repeats goals.{first}, but `hazards` names one hazard for each of the last goals"
                )
    return numbers


def _read_plan(member: str, plan: _Plan, domain: Domain, scene: Scene) -> Iterator[Action]:
    for number, (operator, *names) in enumerate(plan):
        place = f"{member}.{number}"
        arity = domain.operator_arities.get(operator)
        if arity is None:
            raise InputError(f"{place}: expected an operator of the domain, found {operator!r}")
        if arity != len(names):
            raise InputError(f"{place}: {describe_wrong_arity(operator, arity, 'object', len(names))}")
        yield Action(operator, tuple([_find_object_index(name, scene.index, place) for name in names]))


def write_task_line(
    task: Task, benchmark_name: str, domain: Domain, remarks: Mapping[str, Json] | None = None
) -> str:
    """Return a task as one line of text, without a line break at its end. Equal tasks give equal text.

    A plan with a step that the domain does not declare is left out, because a task file cannot state it.

    Args:
        task: the task.
        benchmark_name: name of the benchmark whose world the task uses (`find_benchmark`).
        domain: the declaration of this benchmark.
        remarks: further information on the task, which programs ignore.
    """
    scene = task.scene
    names = [thing.name for thing in scene.objects]
    everything = tuple(range(len(names)))
    values: dict[str, object] = {"id": task.id, "version": 1, "base": benchmark_name}
    values |= {} if task.title == task.id else {"title": task.title}
    values["instruction"] = task.instruction
    values["objects"] = {thing.name: thing.category for thing in scene.objects}
    values |= {} if scene.agent is None else {"agent": names[scene.agent]}
    values |= {} if task.relevant == everything else {"relevant": [names[i] for i in task.relevant]}
    values["facts"] = group_facts_by_predicate(task.initial)
    values["goals"] = write_goals([goal.formula for goal in task.goals], domain, scene)
    plan = convert_plan_to_word_lists(task)
    sound = all(domain.operator_arities.get(operator) == len(objects) for operator, *objects in plan)
    values |= {"plan": plan} if plan and sound else {}
    special = {} if task.special is None else asdict(task.special)
    values |= {name: value for name, value in special.items() if value is not False}
    values |= {"about": remarks} if remarks else {}
    values |= get_recorded_plan_fields(task)
    return json.dumps(values, ensure_ascii=False, separators=(",", ":"))


def convert_plan_to_word_lists(task: Task) -> list[list[str]]:
    """Return the plan of a task in the format of task files."""
    return _list_actions(task.script, task.scene)


def get_recorded_plan_fields(task: Task) -> dict[str, list[list[str]]]:
    """Return the fields ``shortest`` and ``reference`` of a task's line in a task file.

    ``shortest`` is the shortest known plan. ``reference`` has actions with which an agent wins the game
    of the task. Unknown plans are left out.
    """
    plans = {"shortest": task.shortest_plan, "reference": task.reference_plan}
    return {member: _list_actions(plan, task.scene) for member, plan in plans.items() if plan}


def _list_actions(actions: Iterable[Action], scene: Scene) -> list[list[str]]:
    names = [thing.name for thing in scene.objects]
    return [[action.operator, *(names[i] for i in action.arguments)] for action in actions]


def group_facts_by_predicate(state: State) -> dict[str, list[str | Sequence[str]]]:
    """Return the facts of a state in the format of task files."""
    listed: dict[str, list[str | Sequence[str]]] = {}
    for predicate, arguments in state.facts():
        names = [state.scene.objects[i].name for i in arguments]
        listed.setdefault(predicate, []).append(names[0] if len(names) == 1 else names)
    return listed


def write_goals(formulas: Iterable[f.Formula], domain: Domain, scene: Scene) -> list[str]:
    """Return goals as texts in the format of task files."""
    lexicon = make_goal_lexicon(domain, scene)
    renamed = [standardize_variable_names(formula) for formula in formulas]
    return [
        format_ltl(rewrite_state_subformulas(formula, lexicon.replace_domain_names_by_lexicon_names))
        for formula in renamed
    ]
