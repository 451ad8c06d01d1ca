"""Read games of ALFWorld's download as planning tasks whose actions are text commands.

A file ``game.tw-pddl`` holds a domain and a problem in PDDL, and a grammar with a command for each action,
such as ``take {o} from {r}``. A command names only some parameters of its action. The game finds the other
parameters in the state, such as the agent's location. Here an action has only the parameters of its command.
Quantifiers in its condition and effect bind the other parameters.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import eai.logic.formula as f
import eai.pddl.model as m
from eai.abilities.answer_schema import Schema
from eai.abilities.notation.notation import Notation
from eai.abilities.notation.plan_form import WrittenStep
from eai.abilities.notation.plans import PddlPlanNotation
from eai.abilities.notation.step_line import CHARACTERS_AROUND_STEP
from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.base.files import read_content
from eai.benchmarks.benchmark import Benchmark, DataSet
from eai.logic.rewriting import map_terms, rename_objects, substitute_terms
from eai.logic.traversal import find_free_variables, find_object_names, map_subformulas
from eai.pddl.declaration import ConvertedPddlDomain, split_conjuncts
from eai.pddl.files import read_domain_text, read_problem_text
from eai.tasks.english import EnglishWords
from eai.tasks.source import TaskSet
from eai.tasks.task import Task, goal
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.state import Scene

FILE = "game.tw-pddl"
"""Name of the file with a game: its rules in PDDL, its task, and the grammar of its commands."""

_TEMPLATE = re.compile(r'\baction\s+(\w+)\s*\{\s*template\s*::\s*"([^"]*)"')
_PARAMETER_LIST = re.compile(r"\[\{(\w+)\.name \|[^\]]*\]")
"""Regular expression for a placeholder in a command's template, with its list of possible objects."""
_NUMBERED = re.compile(r"^(?:\d+[.):]|[->*])\s*")
_COMMAND_LIKE = re.compile(r"[a-z]+(?: +[a-z/]+)*(?: +\d+)(?: +[a-z/]+| +\d+)*")
"""Regular expression for a command: lower-case words with a number, such as ``go to fridge 1``."""
_MAX_WORDS_AROUND, _MAX_WORDS = 3, 6
"""Limits for lines that count as an attempt to write a command, in words.

The first limit is for the words on each side of a command, if words precede it. The second limit is for a
line that begins like a command but has no complete command.
"""
_BEFORE_NUMBER = re.compile(r"_(?=\d+$)")
_COMMA = re.compile(r"- (\w+),")
_PARAMETER = re.compile(r"\{(\w+)\}")
_INSTRUCTION = re.compile(r"Your task is to: (.*?)\.?\s*\"")
_AGENT = f.Constant("agent1")
"""Name of the agent, the same in all games."""
_CAN_CONTAIN = "cancontain"
"""Name of the predicate that states which kinds of receptacles may contain which kinds of objects."""
_GOAL_LABELS = {
    "inreceptacle": "transport",
    "holds": "transport",
    "isclean": "surface-treatment",
    "ishot": "thermal",
    "iscool": "thermal",
    "istoggled": "device-operation",
    "issliced": "cutting irreversible",
}
"""Labels (words for the kind of a task, see `eai.benchmarks.labels`) by the predicate of the task's goal."""


def open_alfworld_games(reference: str) -> Benchmark:
    """Return the benchmark of all games below a folder, except games that ALFWorld marks as unsolvable.

    The id of a task is the path of its game in the folder, with dots instead of slashes.

    Raises:
        InputError: The folder has no game, a game cannot be read, or two games have different domains or
            commands, or the same id.
    """
    folder = Path(reference)
    games = {path: _read_game_file(path) for path in sorted(folder.rglob(FILE))}
    games = {path: game for path, game in games.items() if game.get("solvable") is not False}
    if not games:
        raise InputError(f"{folder}: expected a folder with games, each in a file {FILE}")
    first = next(iter(games))
    templates = _TEMPLATE.findall(games[first]["grammar"])
    for path, game in games.items():
        has_other_domain = game["pddl_domain"] != games[first]["pddl_domain"]
        if has_other_domain or _TEMPLATE.findall(game["grammar"]) != templates:
            difference = "domains" if has_other_domain else "commands"
            raise InputError(
                f"{path}: this game and {first} have different {difference}; give each its own folder"
            )
    source, commands = _make_domain_with_action_for_each_command(
        _read_game_domain(games[first]["pddl_domain"], first), games[first]["grammar"]
    )
    declaration = ConvertedPddlDomain(source)
    ids: dict[str, Path] = {}
    for path in games:
        task_id = ".".join(path.parent.relative_to(folder).parts) or folder.name
        if ids.setdefault(task_id, path) != path:
            raise InputError(f"the games {ids[task_id]} and {path} have the same id, {task_id}: rename one")
    digest = hashlib.sha256("\0".join([json.dumps(games[path]) for path in games]).encode()).hexdigest()

    def build_task(task_id: str) -> Task:
        return _build_task(task_id, ids[task_id], games[ids[task_id]], source, declaration)

    plans = _TextCommandPlanNotation(commands)
    tasks = TaskSet(ids, build_task, digest)
    return Benchmark(
        "alfworld",
        declaration.domain,
        lambda source: tasks,
        Notation(
            plans,
            formats={Ability.ACTION_SEQUENCING: plans.explain(declaration.domain)},
            english=EnglishWords(role="a household robot"),
        ),
        DataSet("ALFWorld", labels=_GOAL_LABELS),
    )


def _read_game_file(path: Path) -> Mapping[str, Any]:
    """Return the JSON object in the file of a game. It must have a domain, a problem and a grammar."""
    try:
        game: Mapping[str, Any] = json.loads(read_content(path))
    except ValueError as error:
        raise InputError(f"{path}: expected JSON ({error})") from error
    for key in ("pddl_domain", "pddl_problem", "grammar"):
        if not isinstance(game, dict) or not isinstance(game.get(key), str):
            raise InputError(f"{path}: expected a JSON object with the member {key!r}, a string")
    return game


def _read_game_domain(text: str, path: Path) -> m.PddlDomain:
    """Read the domain of a game as TextWorld does, with its misreading of commas.

    In ``?l - location, ?r - receptacle`` TextWorld reads the comma as part of the type's name. No object has
    such a type, so conditions on objects of this type never hold. One of the two ways to `examine` an object
    has such a condition. Only the other way works, which needs the object in the hand.
    """
    empty = {f"{name.lower()}_comma" for name in _COMMA.findall(text)}
    text = _COMMA.sub(r"- \1_comma ", text).replace("(:types", f"(:types {' '.join(sorted(empty))} ", 1)
    domain = read_domain_text(text, path)
    types = tuple([pddl_type for pddl_type in domain.types if pddl_type.name not in empty])
    actions = [
        replace(action, precondition=_drop_alternatives_of_empty_types(action.precondition, empty))
        for action in domain.actions
    ]
    return replace(domain, types=types, actions=tuple(actions))


def _drop_alternatives_of_empty_types(formula: f.Formula, empty: Collection[str]) -> f.Formula:
    """Return a condition without the operands of ``or`` that require an object of an empty type.

    Args:
        formula: the condition.
        empty: the names of types that no object has.
    """
    match formula:
        case f.Exists(variable) if variable.category in empty:
            return f.FALSE
        case f.Or(operands):
            alternatives = [_drop_alternatives_of_empty_types(operand, empty) for operand in operands]
            return f.Or(tuple([alternative for alternative in alternatives if alternative != f.FALSE]))
        case _:
            return map_subformulas(formula, lambda inner: _drop_alternatives_of_empty_types(inner, empty))


def _build_task(
    task_id: str, path: Path, game: Mapping[str, Any], source: m.PddlDomain, declaration: ConvertedPddlDomain
) -> Task:
    problem = read_problem_text(game["pddl_problem"], path, source).problem
    names = _map_identifiers_to_numbered_names(problem)
    relevant = {
        name for atom in problem.initial if atom.predicate != _CAN_CONTAIN for name in find_object_names(atom)
    }
    relevant = {names[name] for name in relevant.union(find_object_names(problem.goal))}
    initial, goals = declaration.convert_problem(_rename_problem(problem, names))
    instruction = _INSTRUCTION.search(game["grammar"])
    return Task(
        id=task_id,
        title=path.parent.parent.name.partition("-")[0],
        instruction=f"{instruction[1].strip()}." if instruction else "",
        initial=initial,
        goals=tuple(map(goal, dict.fromkeys(goals))),
        relevant=tuple([index for index, item in enumerate(initial.scene.objects) if item.name in relevant]),
    )


def _map_identifiers_to_numbered_names(problem: m.PddlProblem) -> Mapping[str, str]:
    """Return a mapping from each object's identifier to ALFWorld's numbered name, such as ``apple_1``.

    The last identifier of a kind, in alphabetical order, gets number 1. An object that is in no fact keeps
    its identifier.
    """
    numbered = Counter[str]()
    names = {item.name: item.name for item in problem.objects}
    for name in sorted({name for atom in problem.initial for name in find_object_names(atom)}, reverse=True):
        kind, mark, _ = name.partition("_bar_")
        if mark:
            kind += "basin" * ("basin" in name)
            numbered[kind] += 1
            names[name] = f"{kind}_{numbered[kind]}"
    return names


def _rename_problem(problem: m.PddlProblem, names: Mapping[str, str]) -> m.PddlProblem:
    initial = [map_terms(atom, lambda term: f.Constant(names[term.name])) for atom in problem.initial]
    objects = tuple([m.TypedName(names[item.name], item.type) for item in problem.objects])
    goal_of = rename_objects(problem.goal, names)
    return replace(problem, objects=objects, initial=tuple(initial), denied=(), goal=goal_of)


def _make_domain_with_action_for_each_command(
    source: m.PddlDomain, grammar: str
) -> tuple[m.PddlDomain, Mapping[str, str]]:
    """Return the domain with one action for each command of a grammar, and a mapping from action to command.

    Actions and commands are texts: the name of the action, and the template of the command.
    """
    templates = {
        name.lower(): _PARAMETER_LIST.sub(r"{\1}", text) for name, text in _TEMPLATE.findall(grammar)
    }
    by_command: dict[str, list[m.PddlAction]] = {}
    for action in source.actions:
        template = templates.get(action.name)
        if template is None:
            raise InputError(
                f"domain {source.name}: the game's grammar has no command for the action {action.name}; "
                "expected a template of a command for each action of the domain"
            )
        projected = _quantify_parameters_except(action, _PARAMETER.findall(template))
        by_command.setdefault(_PARAMETER.sub("{}", template), []).append(projected)
    actions = {template: _merge_actions(template, actions) for template, actions in by_command.items()}
    commands = {action.name: template for template, action in actions.items()}
    return replace(source, actions=tuple(actions.values())), commands


def _merge_actions(command: str, actions: Sequence[m.PddlAction]) -> m.PddlAction:
    """Merge all actions that share a command into one action, which is named after the command's verb."""
    if len(actions) == 1:
        return actions[0]
    parameters = tuple([f.Variable(f"what{i or ''}") for i in range(len(actions[0].parameters))])
    conditions, effects = [], []
    for action in actions:
        old = [f.Variable(parameter.name) for parameter in action.parameters]
        values: dict[f.Term, f.Term] = dict(zip(old, parameters, strict=True))
        conditions.append(substitute_terms(action.precondition, values))
        effects.append(m.WhenEffect(conditions[-1], _substitute_in_effect(action.effect, values)))
    return m.PddlAction(command.split()[0], parameters, f.Or(tuple(conditions)), m.AndEffect(tuple(effects)))


def _substitute_in_effect(effect: m.PddlEffect, values: Mapping[f.Term, f.Term]) -> m.PddlEffect:
    def substitute_arguments(atom: f.Atom) -> f.Atom:
        return f.Atom(atom.predicate, tuple([values.get(term, term) for term in atom.arguments]))

    return m.map_effect(effect, lambda condition: substitute_terms(condition, values), substitute_arguments)


def _quantify_parameters_except(action: m.PddlAction, kept_parameters: Sequence[str]) -> m.PddlAction:
    """Return an action that keeps only some parameters; quantifiers bind its other parameters.

    If quantifiers bind two locations, these must differ from each other: TextWorld offers no action from a
    location to itself, because such an action changes nothing.
    """
    typed = {parameter.name: parameter for parameter in action.parameters}
    agents: dict[f.Term, f.Term] = {f.Variable(n): _AGENT for n, v in typed.items() if v.category == "agent"}
    bound = {
        name: v for name, v in typed.items() if name not in kept_parameters and f.Variable(name) not in agents
    }
    needed = [*split_conjuncts(substitute_terms(action.precondition, agents))]
    locations = [f.Variable(name) for name, variable in bound.items() if variable.category == "location"]
    needed += [f.Not(f.Equals(location, locations[-1])) for location in locations[:-1]]
    groups = [_ConditionsSharingQuantifiedParameters(frozenset(), ())]
    for condition in needed:
        groups = _add_condition_and_merge_groups(groups, condition, bound)
    conditions = [group.join_conditions_under_exists(bound) for group in groups]
    changes = _substitute_in_effect(action.effect, agents)
    effects = [
        _wrap_effect_in_forall_and_when(change, groups, bound)
        for change in (changes.parts if isinstance(changes, m.AndEffect) else [changes])
    ]
    parameters = tuple([typed[name] for name in kept_parameters])
    return m.PddlAction(action.name, parameters, f.And(tuple(conditions)), m.AndEffect(tuple(effects)))


class _ConditionsSharingQuantifiedParameters(NamedTuple):
    """Conditions of an action that share parameters bound by quantifiers, and these parameters' names."""

    names: frozenset[str]
    parts: tuple[f.Formula, ...]

    def join_conditions_under_exists(self, variable_by_parameter_name: Mapping[str, f.Variable]) -> f.Formula:
        """Return a formula: there are values of the bound parameters that meet all conditions."""
        formula: f.Formula = f.And(self.parts)
        for name in sorted(self.names):
            formula = f.Exists(variable_by_parameter_name[name], formula)
        return formula


def _add_condition_and_merge_groups(
    groups: Sequence[_ConditionsSharingQuantifiedParameters],
    condition: f.Formula,
    bound_parameters: Collection[str],
) -> list[_ConditionsSharingQuantifiedParameters]:
    """Return groups of conditions after adding a condition.

    All groups that share a parameter with the new condition are merged into one group.
    """
    names = find_free_variables(condition).intersection(bound_parameters)
    joined = [group for group in groups if group.names & names or group.names == names]
    parts = [part for group in joined for part in group.parts]
    new_group = _ConditionsSharingQuantifiedParameters(
        names.union(*[group.names for group in joined]), (*parts, condition)
    )
    return [*[group for group in groups if group not in joined], new_group]


def _wrap_effect_in_forall_and_when(
    effect: m.PddlEffect,
    condition_groups: Iterable[_ConditionsSharingQuantifiedParameters],
    bound_parameters: Mapping[str, f.Variable],
) -> m.PddlEffect:
    """Return an effect in which quantifiers bind the parameters that were removed from its action.

    The effect happens for all values of these parameters that meet the conditions.

    Args:
        effect: the effect of an action.
        condition_groups: the conditions of the action on removed parameters. Conditions that share a removed
            parameter are in one group.
        bound_parameters: the removed parameters, by name.
    """
    names = m.find_effect_variables(effect)
    for group in condition_groups:
        if group.names & names:
            effect = m.WhenEffect(f.And(group.parts), effect)
            for name in sorted(group.names):
                effect = m.ForAllEffect(bound_parameters[name], effect)
    return effect


class _TextCommandPlanNotation(PddlPlanNotation):
    """Notation of plans with one English command a line, such as ``take apple 1 from fridge 1``.

    Plans in the form of `PddlPlanNotation` are also read. A space before the number in a command
    corresponds to ``_`` in the object's name.

    Args:
        templates: The command of each operator, with ``{}`` for each argument in order.
    """

    def __init__(self, templates: Mapping[str, str]) -> None:
        self.templates = templates
        self._patterns = {
            name: re.compile(re.escape(text).replace(r"\{\}", r"(\w+(?: \d+)?)"), re.IGNORECASE)
            for name, text in templates.items()
        }
        with_objects = [text for text in templates.values() if "{}" in text]
        parts = [re.escape(text).replace(r"\{\}", r"\w+ +\d+") for text in with_objects]
        self._command = re.compile("|".join(parts) or r"(?!)", re.IGNORECASE)
        heads = {text.partition("{}")[0].strip() for text in with_objects}
        self._head = re.compile(rf"(?:{'|'.join(map(re.escape, sorted(heads)))})\s", re.IGNORECASE)

    def read_step(self, line: str) -> WrittenStep | None:
        """Return the step of the first operator whose command matches a line.

        A number may precede the command, as in a numbered list.
        """
        command = " ".join(_NUMBERED.sub("", line).rstrip(".").split())
        for name, pattern in self._patterns.items():
            if (match := pattern.fullmatch(command)) is not None:
                return WrittenStep(name, tuple([word.replace(" ", "_") for word in match.groups()]))
        return super().read_step(line)

    def looks_like_step(self, line: str) -> bool:
        """Whether a line has the form of a command, begins with a command, or adds few words to a command.

        Commands of older games, such as ``put apple 1 in/on fridge 1``, are included.
        """
        words = _NUMBERED.sub("", line).strip(CHARACTERS_AROUND_STEP)
        command = self._command.search(words)
        if command is not None:
            others = words[: command.start()].split(), words[command.end() :].split()
            return not others[0] or max(map(len, others)) <= _MAX_WORDS_AROUND
        is_short = len(words.split()) <= _MAX_WORDS
        return _COMMAND_LIKE.fullmatch(words) is not None or (
            is_short and self._head.match(words) is not None
        )

    def write_command(self, operator: str, names: Sequence[str]) -> str:
        """Return an action as a line that the text game reads, such as ``take apple 1 from fridge 1``."""
        return self.templates[operator].format(*[_BEFORE_NUMBER.sub(" ", name) for name in names])

    def write(self, plan: Iterable[Action], scene: Scene) -> tuple[str, ...]:
        """Return the commands of a plan's steps."""
        objects = scene.objects
        return tuple(
            [
                self.write_command(action.operator, [objects[i].name for i in action.arguments])
                for action in plan
            ]
        )

    def join(self, answer_parts: Iterable[str]) -> str:
        """Return the commands of a plan as a text, one command a line."""
        return "\n".join(answer_parts)

    def explain(self, domain: Domain) -> str:
        """Return the part of a prompt that explains how to write a plan."""
        parameters = {
            operator.name: [parameter.name.upper() for parameter in operator.parameters]
            for operator in domain.operators
        }
        commands = [f"{name}: {self.write_command(name, names)}" for name, names in parameters.items()]
        return "\n".join(
            ["Write one command a line, and nothing else. The commands of the actions are:", *commands]
        )

    def make_json_schema_of_answer(self, domain: Domain, words: Sequence[str] | None) -> Schema | None:
        """Return no JSON Schema, because the answer is not JSON."""
