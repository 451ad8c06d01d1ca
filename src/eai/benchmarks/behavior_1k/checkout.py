"""Read the activity definitions in a checkout of BEHAVIOR-1K's repository, and refuse damaged definitions."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path

import eai.logic.formula as f
from eai.base.errors import InputError
from eai.base.files import find_files_below, read_content
from eai.benchmarks.behavior_1k import predicates as p
from eai.benchmarks.behavior_1k.convert import CORRECTIONS, join_lines_of_definition
from eai.benchmarks.behavior_1k.kinds import get_lemma
from eai.benchmarks.behavior_1k.scene import map_categories_to_synsets
from eai.logic.traversal import get_bound_variables, walk_subformulas
from eai.pddl.bddl import parse_problem

FILE = "problem0.bddl"
"""Name of the file with the definition of an activity. The folder of the file has the activity's name."""

_GOAL_ARITIES = {predicate.name: predicate.arity for predicate in (*p.GOAL_STATES, *p.GOAL_RELATIONS)}
_IN_ROOM = "inroom"
_INITIAL_ARITIES = {**_GOAL_ARITIES, _IN_ROOM: 2, "insource": 2, "future": 1}
"""Number of arguments of each predicate that initial facts may have."""


def read_definitions(folder: Path) -> Mapping[str, str]:
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
    return {name: _read_definition(name, paths[name]) for name in sorted(paths)}


def _read_definition(name: str, path: Path) -> str:
    try:
        original = read_content(path).decode()
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: expected a text in UTF-8 ({error})") from error
    text = join_lines_of_definition(original)
    wrong, corrected = CORRECTIONS.get(name, ("", ""))
    is_corrected = bool(wrong) and wrong in text
    text = text.replace(wrong, corrected) if is_corrected else text
    try:
        if not is_corrected:
            parse_problem(original)  # its error has the line of the file
        problems = list(_find_damage(text))
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    if problems:
        raise InputError(f"{path}: {problems[0]}")
    return text


def _find_damage(text: str) -> Iterator[str]:
    """Yield a description of each name in a definition that is unknown or used in a wrong way."""
    synsets, problem = map_categories_to_synsets(text), parse_problem(text)
    declared = {item.name for item in problem.objects}
    parts = list(walk_subformulas(problem.goal))
    variables = [variable for part in parts for variable in get_bound_variables(part)]
    categories = [
        *(item.type for item in problem.objects),
        *(str(variable.category) for variable in variables),
    ]
    for category in categories:
        if synsets.get(get_lemma(category)) != category:
            yield f"expected one synset of each noun as category, such as mug.n.04, found {category}"
    initial = [*problem.initial, *problem.denied]
    yield from _find_damaged_atoms(":init", initial, _INITIAL_ARITIES, declared)
    goals = [part for part in parts if isinstance(part, f.Atom)]
    yield from _find_damaged_atoms(":goal", goals, _GOAL_ARITIES, declared)


def _find_damaged_atoms(
    section: str, atoms: Sequence[f.Atom], arities: Mapping[str, int], declared: Collection[str]
) -> Iterator[str]:
    for atom in atoms:
        names = [term.name for term in atom.arguments if isinstance(term, f.Constant)]
        objects = names[:1] if atom.predicate == _IN_ROOM else names
        if atom.predicate not in arities:
            yield f"{section} has the unknown predicate {atom.predicate}"
        elif len(atom.arguments) != arities[atom.predicate]:
            expected = arities[atom.predicate]
            yield f"{section} has {atom.predicate} of {len(atom.arguments)} objects: expected {expected}"
        yield from (
            f"{section} has {atom.predicate} of {name}, which :objects does not declare"
            for name in objects
            if name not in declared
        )
