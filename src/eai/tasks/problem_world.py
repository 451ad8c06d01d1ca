"""Read a domain and tasks from PDDL files, and read PDDL or BDDL problems about the world of a benchmark."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

import eai.logic.formula as f
from eai.base.errors import DomainError, InputError, read_items_or_raise_all
from eai.base.files import find_files_below
from eai.logic.rewriting import map_terms
from eai.logic.traversal import map_subformulas
from eai.pddl.declaration import ConvertedPddlDomain
from eai.pddl.export import export_domain_and_problem
from eai.pddl.files import (
    ProblemFile,
    begins_with_domain_definition,
    find_line_of_word,
    is_domain_file,
    read_domain_text,
    read_problem_file,
    read_text,
)
from eai.pddl.glossary import PddlExportNames, PddlNamesByOriginalName
from eai.pddl.model import OBJECT, PddlDomain, PddlPredicate, PddlProblem, TypedName
from eai.pddl.writer import write_formula
from eai.tasks.source import TaskSet
from eai.tasks.task import Task, goal
from eai.world.derived import is_a
from eai.world.domain import Domain
from eai.world.frame import AGENT
from eai.world.state import Fact, Scene, State, WorldObject

_SUFFIX = ".pddl"


def open_pddl_folder(folder: Path) -> tuple[Domain, TaskSet[Task]]:
    """Read the only domain file below a folder, and all other ``.pddl`` files below it as problems.

    Raises:
        InputError: not exactly one file begins with a domain, there is no problem, or a file cannot be read.
    """
    files = find_files_below(folder, f"*{_SUFFIX}")
    domains = [file for file in files if begins_with_domain_definition(file)]
    if len(domains) != 1:
        listed = f"{len(domains)} of them: {', '.join(map(str, domains))}" if domains else "none"
        raise InputError(f"{folder}: expected one file *{_SUFFIX} that defines a domain, found {listed}")
    problems = [file for file in files if file not in domains]
    if not problems:
        raise InputError(f"{folder}: expected problems in files *{_SUFFIX}, beside the domain {domains[0]}")
    return _open_domain_and_problems(domains[0], lambda: problems)


def open_pddl(domain_file: Path, problems: Path) -> tuple[Domain, TaskSet[Task]]:
    """Return the domain in a file, and its problems as tasks.

    The problems are in one file, or in all ``.pddl`` files of a folder, sorted by name. The id of a
    task is the name of its problem, or the name of its file if several problems share a name.

    Raises:
        InputError: a file cannot be read. The message names each file, the line and the expected text.
    """
    return _open_domain_and_problems(domain_file, lambda: _find_problem_files(domain_file, problems))


def _open_domain_and_problems(
    domain_file: Path, find_problem_files: Callable[[], Sequence[Path]]
) -> tuple[Domain, TaskSet[Task]]:
    text = read_text(domain_file)
    domain = read_domain_text(text, domain_file)
    try:
        declaration = ConvertedPddlDomain(domain)
    except DomainError as error:
        words = (f":action {action.name}" for action in domain.actions if f" {action.name}:" in str(error))
        word = next(words, None) or next(
            (f"( {p.name}" for p in domain.predicates if f" {p.name} " in str(error)), None
        )
        place = f"{domain_file}: line {find_line_of_word(text, word)}" if word else str(domain_file)
        raise InputError(f"{place}: {error}") from error
    declared = (domain_file, text)
    files = read_items_or_raise_all(
        find_problem_files(), lambda path: read_problem_file(path, domain, declared)
    )
    named = assign_task_names(files)
    tasks = {name: _make_problem_task(name, file, declaration) for name, file in named.items()}
    texts = [text, *(f"{name}\0{file.text}" for name, file in named.items())]
    digest = hashlib.sha256("\0".join(texts).encode()).hexdigest()
    return declaration.domain, TaskSet(tasks, tasks.__getitem__, digest)


def assign_task_names(files: Sequence[ProblemFile]) -> Mapping[str, ProblemFile]:
    """Return a mapping from the name of each problem's task to the problem's file.

    A task is named after its problem. If problems have equal names, their tasks are named after their files.

    Raises:
        InputError: two tasks would have the same name.
    """
    times = Counter(file.problem.name for file in files)
    named: dict[str, ProblemFile] = {}
    for file in files:
        name = file.problem.name if times[file.problem.name] == 1 else file.path.stem
        if name in named:
            raise InputError(
                f"{file.path}: the name {name!r} is taken by {named[name].path}; rename the file or its "
                "problem"
            )
        named[name] = file
    return named


def _find_problem_files(domain_file: Path, file_or_folder: Path) -> Sequence[Path]:
    if not file_or_folder.is_dir():
        return (file_or_folder,)
    inside = (path for path in file_or_folder.glob(f"*{_SUFFIX}") if path.is_file())
    paths = sorted(path for path in inside if path.resolve() != domain_file.resolve())
    paths = [path for path in paths if not is_domain_file(path)]
    if not paths:
        raise InputError(f"{file_or_folder}: expected problems in files *{_SUFFIX}")
    return paths


def _make_problem_task(name: str, file: ProblemFile, declaration: ConvertedPddlDomain) -> Task:
    initial, goals = declaration.convert_problem(file.problem)
    wanted = "; ".join(map(write_formula, goals))
    return Task(
        id=name,
        title=name,
        instruction=f"Reach a state in which all of this holds: {wanted}",
        initial=initial,
        goals=tuple(map(goal, dict.fromkeys(goals))),
        relevant=tuple(range(len(initial.scene.objects))),
    )


ConditionConverter: TypeAlias = Callable[[f.Formula], f.Formula]
"""Function that converts a condition of a problem to a formula with the names of the benchmark."""


DomainAndProblemReader: TypeAlias = tuple[
    PddlDomain, Callable[[PddlProblem], tuple[State, ConditionConverter]]
]
"""A pair: a PDDL domain with the names that problems use, and a function that reads a problem.

The function returns the problem's initial state, and a converter of the problem's conditions.
"""


def make_domain_without_operators(
    name: str, types: Mapping[str, str], constants: Mapping[str, str], arities: Mapping[str, int]
) -> PddlDomain:
    """Return a PDDL domain without operators.

    Args:
        name: name of the domain.
        types: mapping from types to their supertypes.
        constants: mapping from constants to their types.
        arities: mapping from predicates to their numbers of arguments.
    """
    return PddlDomain(
        name=name,
        requirements=(),
        types=tuple([TypedName(*item) for item in types.items()]),
        constants=tuple([TypedName(*item) for item in constants.items()]),
        predicates=tuple([_make_predicate(name, arity) for name, arity in arities.items()]),
        actions=(),
    )


def _make_predicate(name: str, arity: int) -> PddlPredicate:
    return PddlPredicate(name, tuple([f.Variable(f"x{place}") for place in range(arity)]))


@dataclass(frozen=True)
class _ProblemToStateConverter:
    """Converts problems about the world of a declared domain.

    Problems may spell the declared names differently.

    Attributes:
        domain: the declaration of the domain.
        header: the domain in PDDL without operators: its types, constants and predicates, as problems spell
            them.
        predicates: mapping from the spelling of a predicate to its declared name.
        object_category_by_predicate: for each predicate that states the category of an object, the category.
        operator_by_predicate: for each predicate that states the execution of an operator, the operator.
        order_predicate: the predicate that compares two objects by their order; may be empty.
        categories: mapping from types of problems to categories.
        names: mapping from spelling and category of an object to its declared name; other objects keep their
            spelling.
        agent: the acting object, which problems need not declare.
    """

    domain: Domain
    header: PddlDomain
    predicates: Mapping[str, str]
    object_category_by_predicate: Mapping[str, str]
    operator_by_predicate: Mapping[str, str]
    order_predicate: str
    categories: Mapping[str, str]
    names: Mapping[tuple[str, str], str]
    agent: WorldObject | None

    def read_problem(self, problem: PddlProblem) -> tuple[State, ConditionConverter]:
        """Return a problem's initial state, and a function that renames conditions of the problem.

        The function returns a condition with the names that the benchmark declares.
        """
        spelt = {item.name: self._to_object(item) for item in (*self.header.constants, *problem.objects)}
        scene = Scene(
            self.domain.vocabulary,
            list(spelt.values()),
            None if self.agent is None else list(spelt).index(AGENT.name),
        )
        index = {word: i for i, word in enumerate(spelt)}
        stored = ((self.predicates.get(atom.predicate, ""), atom.arguments) for atom in problem.initial)
        facts = [
            Fact(name, tuple([index[term.name] for term in arguments]))
            for name, arguments in stored
            if self.domain.vocabulary.find_stored_predicate(name) is not None
        ]
        names = {word: thing.name for word, thing in spelt.items()}
        return scene.state(facts), lambda formula: self._to_declared_names(formula, names)

    def _to_object(self, item: TypedName) -> WorldObject:
        if item.name == AGENT.name and self.agent is not None:
            return self.agent
        category = self.categories.get(item.type, item.type)
        return WorldObject(self.names.get((item.name, category), item.name), category)

    def _to_declared_names(self, formula: f.Formula, names: Mapping[str, str]) -> f.Formula:
        """Return a condition with names that the benchmark declares, in place of the problem's names."""

        def replace_problem_name_by_benchmark_name(term: f.Term) -> f.Term:
            return f.Constant(names[term.name]) if isinstance(term, f.Constant) else term

        match formula:
            case f.Atom(name, (argument,)) if name in self.object_category_by_predicate:
                return is_a(
                    replace_problem_name_by_benchmark_name(argument), self.object_category_by_predicate[name]
                )
            case f.Atom(name) if name in self.operator_by_predicate:
                return f.Occurs(self.operator_by_predicate[name], ())
            case f.Atom(name) if name == self.order_predicate:
                return f.TRUE
            case f.Atom(name, arguments):
                return f.Atom(
                    self.predicates.get(name, name),
                    tuple(map(replace_problem_name_by_benchmark_name, arguments)),
                )
            case f.Equals():
                return map_terms(formula, replace_problem_name_by_benchmark_name)
            case f.ForAll(variable, body) | f.Exists(variable, body) | f.Exactly(_, variable, body):
                return replace(
                    formula,
                    variable=self._replace_type_by_category(variable),
                    body=self._to_declared_names(body, names),
                )
            case f.ForPairs(first, second, body):
                first, second = self._replace_type_by_category(first), self._replace_type_by_category(second)
                return replace(formula, first=first, second=second, body=self._to_declared_names(body, names))
            case _:
                return map_subformulas(formula, lambda part: self._to_declared_names(part, names))

    def _replace_type_by_category(self, variable: f.Variable) -> f.Variable:
        """Return a quantified variable with a category of the benchmark in place of its type in the problem.

        A variable of the root type ``object`` gets no category.
        """
        category = variable.category or OBJECT
        return f.Variable(variable.name, self.categories.get(category))


def make_bddl_domain_and_reader(domain: Domain, tasks: Iterable[Task]) -> DomainAndProblemReader:
    """Return a domain's names, in lower case as BDDL spells them, and a reader of BDDL problems."""
    vocabulary = domain.vocabulary
    names = [predicate.name for predicate in vocabulary.predicates] + list(vocabulary.derived_by_name)
    declared = _make_problem_to_state_converter(
        domain, tasks, str.lower, {name.lower(): name for name in names}
    )
    return declared.header, declared.read_problem


def make_pddl_domain_and_reader(domain: Domain, tasks: Iterable[Task]) -> DomainAndProblemReader:
    """Return a domain's names, as `eai.pddl.export` writes them, and a reader of PDDL problems."""
    glossary = PddlExportNames(domain.vocabulary)
    spelt = {written: name for name, written in glossary.predicates.items()}
    tasks = list(tasks)
    declared = _make_problem_to_state_converter(
        domain, tasks, lambda name: PddlNamesByOriginalName()[name], spelt
    )
    named = [
        export_domain_and_problem(domain, task.initial, (), objects=0).domain.constants for task in tasks[:1]
    ]
    constants = dict.fromkeys([*declared.header.constants, *(item for items in named for item in items)])
    object_category_by_predicate = {
        glossary.register_category_predicate(name): name for name in declared.categories.values()
    }
    operator_by_predicate = {
        glossary.register_execution_predicate(operator.name): operator.name for operator in domain.operators
    }
    order_predicate = glossary.make_precedes_atom(f.Variable("x"), f.Variable("y")).predicate
    arities = {
        **dict.fromkeys(object_category_by_predicate, 1),
        **dict.fromkeys(operator_by_predicate, 0),
        order_predicate: 2,
    }
    predicates = (*declared.header.predicates, *make_domain_without_operators("", {}, {}, arities).predicates)
    header = replace(declared.header, constants=tuple(constants), predicates=predicates)
    return header, replace(
        declared,
        header=header,
        object_category_by_predicate=object_category_by_predicate,
        operator_by_predicate=operator_by_predicate,
        order_predicate=order_predicate,
    ).read_problem


def _make_problem_to_state_converter(
    domain: Domain,
    tasks: Iterable[Task],
    spell_name: Callable[[str], str],
    predicate_by_spelling: Mapping[str, str],
) -> _ProblemToStateConverter:
    """Return a converter of PDDL or BDDL problems to states and conditions of a domain.

    The tasks provide the objects and their categories.
    """
    scenes = [task.scene for task in tasks]
    things = dict.fromkeys([thing for scene in scenes for thing in scene.objects])
    kinds = dict.fromkeys(
        kind for thing in things for kind in domain.vocabulary.list_kind_with_ancestors(thing.category)
    )
    categories = {spell_name(kind): kind for kind in kinds}
    types = [(word, domain.vocabulary.parents.get(kind)) for word, kind in categories.items()]
    agents = [scene.objects[scene.agent] for scene in scenes if scene.agent is not None]
    agent = agents[0] if agents else None
    constants = {AGENT.name: spell_name(agent.category)} if agent is not None else {}
    arities = {word: domain.vocabulary.find_arity(name) or 0 for word, name in predicate_by_spelling.items()}
    return _ProblemToStateConverter(
        domain,
        make_domain_without_operators(
            spell_name(domain.name),
            {word: OBJECT if parent is None else spell_name(parent) for word, parent in types},
            constants,
            arities,
        ),
        predicate_by_spelling,
        {},
        {},
        "",
        categories,
        {(spell_name(thing.name), thing.category): thing.name for thing in things},
        agent,
    )
