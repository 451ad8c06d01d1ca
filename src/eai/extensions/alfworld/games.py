"""Games of ALFWorld, as its own download holds them: a planning domain whose actions are commands.

A file ``game.tw-pddl`` holds a domain and a problem in PDDL, and a grammar: for each action a command, such
as ``take {o} from {r}``. A command names some of the action's parameters; the others are found in the state,
as where the agent is. Here conditions and effects bind them: an action has the objects of its command.
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
from eai.abilities.notation.notation import Notation
from eai.abilities.notation.plan_form import WrittenStep
from eai.abilities.notation.plans import PddlPlans
from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.base.files import read_content
from eai.benchmarks.benchmark import Benchmark, DataSet
from eai.logic.rewriting import map_terms, rename_objects, substitute
from eai.logic.traversal import free_variables, map_parts, object_names
from eai.pddl.declaration import DeclaredDomain, conjuncts
from eai.pddl.files import domain_in, problem_in
from eai.tasks.english import English
from eai.tasks.source import TaskSet
from eai.tasks.task import Task, goal
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.state import Scene

FILE = "game.tw-pddl"
"""The name of the file of a game."""

_TEMPLATE = re.compile(r'\baction\s+(\w+)\s*\{\s*template\s*::\s*"([^"]*)"')
_LISTED = re.compile(r"\[\{(\w+)\.name \|[^\]]*\]")
"""A place of a template that names a parameter and tells where it is to be looked for."""
_NUMBERED = re.compile(r"^(?:\d+[.):]|[->*])\s*")
_COMMAND_LIKE = re.compile(r"[a-z]+(?: [a-z/]+)*(?: \d+)(?: [a-z/]+| \d+)*")
"""Small letters and numbers alone, with at least one numbered object."""
_BEFORE_NUMBER = re.compile(r"_(?=\d+$)")
_COMMA = re.compile(r"- (\w+),")
_PLACE = re.compile(r"\{(\w+)\}")
_ASKED = re.compile(r"Your task is to: (.*?)\.?\s*\"")
_AGENT = f.Constant("agent1")
"""The agent, whom every game has."""
_KINDS = "cancontain"
"""The predicate of what may be put where by its kind, of all kinds there are."""


def open_games(place: str) -> Benchmark:
    """Open the benchmark of the games below a folder, without those that ALFWorld itself found unsolvable.

    The id of a task is the path of its game in the folder, with dots for slashes.

    Raises:
        InputError: there is no game, a game cannot be read, or two games are of different domains.
    """
    folder = Path(place)
    games = {path: _read(path) for path in sorted(folder.rglob(FILE))}
    games = {path: game for path, game in games.items() if game.get("solvable") is not False}
    if not games:
        raise InputError(f"{folder}: expected games in files {FILE}")
    first = next(iter(games))
    for path, game in games.items():
        if game["pddl_domain"] != games[first]["pddl_domain"]:
            raise InputError(f"{path}: expected the domain of {first}")
    source, commands = _commanded(_domain(games[first]["pddl_domain"], first), games[first]["grammar"])
    declaration = DeclaredDomain(source)
    ids = {".".join(path.parent.relative_to(folder).parts) or folder.name: path for path in games}
    digest = hashlib.sha256("\0".join([json.dumps(games[path]) for path in games]).encode()).hexdigest()

    def build(task_id: str) -> Task:
        return _task(task_id, ids[task_id], games[ids[task_id]], source, declaration)

    plans = _CommandPlans(commands)
    tasks = TaskSet(ids, build, digest)
    return Benchmark(
        "alfworld",
        declaration.domain,
        lambda source: tasks,
        Notation(
            plans,
            formats={Ability.ACTION_SEQUENCING: plans.explained(declaration.domain)},
            english=English(role="a household robot"),
        ),
        DataSet("ALFWorld"),
    )


def _read(path: Path) -> Mapping[str, Any]:
    """The object in the file of a game."""
    try:
        game: Mapping[str, Any] = json.loads(read_content(path))
    except ValueError as error:
        raise InputError(f"{path}: expected JSON ({error})") from error
    for key in ("pddl_domain", "pddl_problem", "grammar"):
        if not isinstance(game, dict) or not isinstance(game.get(key), str):
            raise InputError(f"{path}: expected an object with the text {key!r}")
    return game


def _domain(text: str, path: Path) -> m.PddlDomain:
    """The domain of a game. To TextWorld the comma in ``?l - location, ?r - receptacle`` is part of the type.

    There is nothing of such a type, so that no condition about it holds: an object is examined in the hand.
    """
    empty = {f"{name.lower()}_comma" for name in _COMMA.findall(text)}
    text = _COMMA.sub(r"- \1_comma ", text).replace("(:types", f"(:types {' '.join(sorted(empty))} ", 1)
    domain = domain_in(text, path)
    types = tuple([each for each in domain.types if each.name not in empty])
    actions = [replace(each, precondition=_without(each.precondition, empty)) for each in domain.actions]
    return replace(domain, types=types, actions=tuple(actions))


def _without(formula: f.Formula, empty: Collection[str]) -> f.Formula:
    """A condition without alternatives that are about what there is not."""
    match formula:
        case f.Exists(variable) if variable.category in empty:
            return f.FALSE
        case f.Or(operands):
            parts = [_without(each, empty) for each in operands]
            return f.Or(tuple([each for each in parts if each != f.FALSE]))
        case _:
            return map_parts(formula, lambda part: _without(part, empty))


def _task(
    task_id: str, path: Path, game: Mapping[str, Any], source: m.PddlDomain, declaration: DeclaredDomain
) -> Task:
    problem = problem_in(game["pddl_problem"], path, source).problem
    names = _names(problem)
    said = {name for atom in problem.initial if atom.predicate != _KINDS for name in object_names(atom)}
    said = {names[name] for name in said.union(object_names(problem.goal))}
    initial, goals = declaration.problem(_renamed(problem, names))
    asked = _ASKED.search(game["grammar"])
    return Task(
        id=task_id,
        title=path.parent.parent.name.partition("-")[0],
        instruction=f"{asked[1].strip()}." if asked else "",
        initial=initial,
        goals=tuple(map(goal, dict.fromkeys(goals))),
        relevant=tuple([i for i, each in enumerate(initial.scene.objects) if each.name in said]),
    )


def _names(problem: m.PddlProblem) -> Mapping[str, str]:
    """The names of objects, as ALFWorld makes them of identifiers: ``apple_1``.

    The last of a kind by identifier is the first by number. What no fact is about has no number.
    """
    numbered = Counter[str]()
    names = {item.name: item.name for item in problem.objects}
    for name in sorted({name for atom in problem.initial for name in object_names(atom)}, reverse=True):
        kind, mark, _ = name.partition("_bar_")
        if mark:
            kind += "basin" * ("basin" in name)
            numbered[kind] += 1
            names[name] = f"{kind}_{numbered[kind]}"
    return names


def _renamed(problem: m.PddlProblem, names: Mapping[str, str]) -> m.PddlProblem:
    initial = [map_terms(atom, lambda term: f.Constant(names[term.name])) for atom in problem.initial]
    things = tuple([m.TypedName(names[item.name], item.type) for item in problem.objects])
    goal_of = rename_objects(problem.goal, names)
    return replace(problem, objects=things, initial=tuple(initial), denied=(), goal=goal_of)


def _commanded(source: m.PddlDomain, grammar: str) -> tuple[m.PddlDomain, Mapping[str, str]]:
    """A domain with the commands of a grammar as its actions, and the command of each."""
    templates = {name.lower(): _LISTED.sub(r"{\1}", text) for name, text in _TEMPLATE.findall(grammar)}
    alike: dict[str, list[m.PddlAction]] = {}
    for action in source.actions:
        template = templates.get(action.name)
        if template is None:
            raise InputError(f"domain {source.name}: expected a command for the action {action.name}")
        projected = _projected(action, _PLACE.findall(template))
        alike.setdefault(_PLACE.sub("{}", template), []).append(projected)
    actions = {template: _either(template, actions) for template, actions in alike.items()}
    commands = {action.name: template for template, action in actions.items()}
    return replace(source, actions=tuple(actions.values())), commands


def _either(template: str, actions: Sequence[m.PddlAction]) -> m.PddlAction:
    """The action that a command means: any of those that it fits, called by its verb if these are several."""
    if len(actions) == 1:
        return actions[0]
    parameters = tuple([f.Variable(f"what{i or ''}") for i in range(len(actions[0].parameters))])
    conditions, effects = [], []
    for each in actions:
        old = [f.Variable(parameter.name) for parameter in each.parameters]
        values: dict[f.Term, f.Term] = dict(zip(old, parameters, strict=True))
        conditions.append(substitute(each.precondition, values))
        effects.append(m.WhenEffect(conditions[-1], _substituted(each.effect, values)))
    return m.PddlAction(template.split()[0], parameters, f.Or(tuple(conditions)), m.Both(tuple(effects)))


def _substituted(effect: m.PddlEffect, values: Mapping[f.Term, f.Term]) -> m.PddlEffect:
    def atom(each: f.Atom) -> f.Atom:
        return f.Atom(each.predicate, tuple([values.get(term, term) for term in each.arguments]))

    return m.map_effect(effect, lambda condition: substitute(condition, values), atom)


def _projected(action: m.PddlAction, kept: Sequence[str]) -> m.PddlAction:
    """An action with some of its parameters; the others are bound where conditions and effects name them.

    An action from one place to another needs two: TextWorld offers no action that changes nothing.
    """
    typed = {each.name: each for each in action.parameters}
    agents: dict[f.Term, f.Term] = {f.Variable(n): _AGENT for n, v in typed.items() if v.category == "agent"}
    bound = {name: v for name, v in typed.items() if name not in kept and f.Variable(name) not in agents}
    needed = [*conjuncts(substitute(action.precondition, agents))]
    places = [f.Variable(name) for name, each in bound.items() if each.category == "location"]
    needed += [f.Not(f.Equals(place, places[-1])) for place in places[:-1]]
    groups = [_Group(frozenset(), ())]
    for condition in needed:
        groups = _joined(groups, condition, bound)
    conditions = [each.condition(bound) for each in groups]
    changes = _substituted(action.effect, agents)
    effects = [
        _wherever(part, groups, bound)
        for part in (changes.parts if isinstance(changes, m.Both) else [changes])
    ]
    parameters = tuple([typed[name] for name in kept])
    return m.PddlAction(action.name, parameters, f.And(tuple(conditions)), m.Both(tuple(effects)))


class _Group(NamedTuple):
    """Conditions that share bound parameters, and these."""

    names: frozenset[str]
    parts: tuple[f.Formula, ...]

    def condition(self, bound: Mapping[str, f.Variable]) -> f.Formula:
        """Some values of the parameters meet all conditions."""
        formula: f.Formula = f.And(self.parts)
        for name in sorted(self.names):
            formula = f.Exists(bound[name], formula)
        return formula


def _joined(groups: Sequence[_Group], condition: f.Formula, bound: Collection[str]) -> list[_Group]:
    """The groups with one more condition, which joins those of its parameters."""
    names = free_variables(condition).intersection(bound)
    joined = [each for each in groups if each.names & names or each.names == names]
    parts = [part for each in joined for part in each.parts]
    one = _Group(names.union(*[each.names for each in joined]), (*parts, condition))
    return [*[each for each in groups if each not in joined], one]


def _wherever(part: m.PddlEffect, groups: Iterable[_Group], bound: Mapping[str, f.Variable]) -> m.PddlEffect:
    """A part of an effect for all values of its bound parameters that meet their conditions."""
    names = m.effect_variables(part)
    for each in groups:
        if each.names & names:
            part = m.WhenEffect(f.And(each.parts), part)
            for name in sorted(each.names):
                part = m.Each(bound[name], part)
    return part


class _CommandPlans(PddlPlans):
    """Plans as commands in English, one a line, beside those of `PddlPlans`: ``take apple 1 from fridge 1``.

    The number of an object is set off by a space, and by ``_`` in its name.

    Args:
        templates: the command of each operator, with ``{}`` where its arguments stand, in order.
    """

    def __init__(self, templates: Mapping[str, str]) -> None:
        self.templates = templates
        self._patterns = {
            name: re.compile(re.escape(text).replace(r"\{\}", r"(\w+(?: \d+)?)"), re.IGNORECASE)
            for name, text in templates.items()
        }

    def step(self, line: str) -> WrittenStep | None:
        """The step of the first operator whose command the line is, which may be numbered."""
        command = _NUMBERED.sub("", line).rstrip(".")
        for name, pattern in self._patterns.items():
            if (match := pattern.fullmatch(command)) is not None:
                return WrittenStep(name, tuple([word.replace(" ", "_") for word in match.groups()]))
        return super().step(line)

    def looks_like_step(self, line: str) -> bool:
        """Whether a line has the form of a command, as in ``put apple 1 in/on fridge 1`` of older games."""
        return _COMMAND_LIKE.fullmatch(_NUMBERED.sub("", line)) is not None

    def command(self, operator: str, names: Sequence[str]) -> str:
        """An action as its command."""
        return self.templates[operator].format(*[_BEFORE_NUMBER.sub(" ", name) for name in names])

    def write(self, plan: Iterable[Action], scene: Scene) -> tuple[str, ...]:
        """Each step as its command."""
        objects = scene.objects
        return tuple(
            [self.command(each.operator, [objects[i].name for i in each.arguments]) for each in plan]
        )

    def join(self, parts: Iterable[str]) -> str:
        """One command a line."""
        return "\n".join(parts)

    def explained(self, domain: Domain) -> str:
        """How a plan is written, in words."""
        names = {
            each.name: [parameter.name.upper() for parameter in each.parameters] for each in domain.operators
        }
        listed = [f"{name}: {self.command(name, places)}" for name, places in names.items()]
        return "\n".join(
            ["Write one command a line, and nothing else. The commands of the actions are:", *listed]
        )

    def schema(self, domain: Domain, words: Sequence[str] | None) -> None:
        """No form is enforced, as the answer is no JSON."""
