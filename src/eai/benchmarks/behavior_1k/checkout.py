"""Read the activity definitions in a checkout of BEHAVIOR-1K's repository, and refuse damaged definitions."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

import eai.logic.formula as f
from eai.base.errors import InputError, prefix_errors_with_location
from eai.base.files import find_files_below
from eai.benchmarks.behavior_1k import predicates as p
from eai.benchmarks.behavior_1k.convert import CORRECTIONS, join_lines_of_definition
from eai.benchmarks.behavior_1k.kinds import get_lemma
from eai.benchmarks.behavior_1k.scene import map_categories_to_synsets
from eai.logic.traversal import get_bound_variables, walk_subformulas
from eai.pddl.bddl import parse_problem
from eai.pddl.files import read_text

FILE = "problem0.bddl"
"""Name of the file with the definition of an activity. The folder of the file has the activity's name."""

_GOAL_ARITIES = {predicate.name: predicate.arity for predicate in (*p.GOAL_STATES, *p.GOAL_RELATIONS)}
_IN_ROOM = "inroom"
_INITIAL_ARITIES = {**_GOAL_ARITIES, _IN_ROOM: 2, "insource": 2, "future": 1}
"""Mapping from each predicate that initial facts may use to its number of arguments."""


def read_activity_definitions(folder: Path) -> Mapping[str, str]:
    """Return the definitions below a folder, in one line each, by the name of the activity.

    Raises:
        InputError: there is no definition, two definitions have the same name, or a definition is damaged.
    """
    paths: dict[str, Path] = {}
    for path in find_files_below(folder, FILE):
        other = paths.setdefault(path.parent.name, path)
        if other != path:
            raise InputError(f"{path}: {other} defines the same activity; give a folder with one of them")
    if not paths:
        raise InputError(f"{folder}: expected activities as ACTIVITY/{FILE} in the folder or below")
    return {name: _read_activity_definition(name, paths[name]) for name in sorted(paths)}


def _read_activity_definition(activity_name: str, path: Path) -> str:
    original = read_text(path)
    text = join_lines_of_definition(original)
    wrong, corrected = CORRECTIONS.get(activity_name, ("", ""))
    is_corrected = bool(wrong) and wrong in text
    text = text.replace(wrong, corrected) if is_corrected else text
    with prefix_errors_with_location(path):
        if not is_corrected:
            parse_problem(original)  # errors in `text`, which has one line, could not name a line of the file
        for problem in _find_errors_in_activity_definition(text):
            raise InputError(problem)
    return text


def _find_errors_in_activity_definition(text: str) -> Iterator[str]:
    """Yield a description of each name in a definition that is unknown or used in a wrong way."""
    synsets, problem = map_categories_to_synsets(text), parse_problem(text)
    declared = {item.name for item in problem.objects}
    parts = list(walk_subformulas(problem.goal))
    bound = [str(variable.category) for part in parts for variable in get_bound_variables(part)]
    for category in [*(item.type for item in problem.objects), *bound]:
        if synsets.get(get_lemma(category)) != category:
            yield f"expected one synset of each noun as category, such as mug.n.04, found {category}"
    goals = [part for part in parts if isinstance(part, f.Atom)]
    for atom in (*problem.initial, *problem.denied):
        yield from _find_errors_in_activity_atom(":init", atom, _INITIAL_ARITIES, declared)
    for atom in goals:
        yield from _find_errors_in_activity_atom(":goal", atom, _GOAL_ARITIES, declared)


def _find_errors_in_activity_atom(
    section: str, atom: f.Atom, arities: Mapping[str, int], declared: Collection[str]
) -> Iterator[str]:
    name, expected = atom.predicate, arities.get(atom.predicate)
    if expected is None:
        yield f"{section} has the unknown predicate {name}"
    elif len(atom.arguments) != expected:
        yield f"{section} has {name} of {len(atom.arguments)} objects: expected {expected}"
    objects = [term.name for term in atom.arguments if isinstance(term, f.Constant)]
    for each in objects[:1] if name == _IN_ROOM else objects:
        if each not in declared:
            yield f"{section} has {name} of {each}, which :objects does not declare"
