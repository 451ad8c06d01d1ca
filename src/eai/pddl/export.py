"""Export a declared domain with its problems as PDDL that any planner can read.

The checks of an operator become its precondition. Its ordered effects become conditional effects. Derived
predicates become axioms, categories become types and static predicates, and the agent becomes a constant.
Predicates that prompts must not mention are exported too, unless the caller leaves them out. So exported
operators change states exactly as the engine does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import eai.logic.formula as f
import eai.pddl.model as m
from eai.base.errors import DomainError, prefix_errors_with_location
from eai.logic.rewriting import rename_objects
from eai.pddl.execute import PddlState, PlanStep
from eai.pddl.glossary import (
    ConditionWriter,
    PddlExportNames,
    PddlNamesByOriginalName,
    conjoin,
    find_predicates_forbidden_in_prompts,
    remove_hidden_predicates,
)
from eai.pddl.ordered_effects import convert_to_simultaneous_effect
from eai.world.action import Action
from eai.world.derived import LookupPredicate
from eai.world.domain import Domain
from eai.world.frame import AGENT
from eai.world.listing import make_fact_lister
from eai.world.operator import Operator
from eai.world.relation import iterate_bits
from eai.world.state import Scene, State
from eai.world.vocabulary import make_parameter_names


def _list_object_names_in_formulas(scene: Scene) -> list[str]:
    """Return the names of the objects as formulas of the domain write them. The agent is written ``agent``.

    Another object whose name in the scene is ``agent`` gets a name that no formula contains.
    """
    keys = [f"{thing.name} " if thing.name == AGENT.name else thing.name for thing in scene.objects]
    if scene.agent is not None:
        keys[scene.agent] = AGENT.name
    return keys


def _get_precedes_predicate_name(glossary: PddlExportNames) -> str:
    """Return the PDDL predicate that compares two objects by their order in the scene."""
    return glossary.make_precedes_atom(f.Variable("x"), f.Variable("y")).predicate


def _export_problem(
    glossary: PddlExportNames,
    pddl_names: Sequence[str],
    header: m.PddlDomain,
    problem: ProblemToExport,
    goal: f.Formula,
) -> m.PddlProblem:
    """Return the problem of an exported domain: typed objects, the facts of a state, and added static facts.

    Args:
        glossary: the PDDL names of the export.
        pddl_names: the PDDL names of the objects of the scene, by index.
        header: the exported domain without operators.
        problem: the problem to be exported.
        goal: the goal in PDDL.
    """
    things, constants = problem.initial.scene.objects, {item.name for item in header.constants}
    kinds = [
        (pddl_names[i], glossary.types[things[i].category])
        for i in iterate_bits(problem.exported_objects_mask)
    ]
    objects = tuple([m.TypedName(word, kind) for word, kind in kinds if word not in constants])
    facts = tuple(
        [
            _export_atom(name, arguments, pddl_names)
            for name, arguments in _export_initial_facts(glossary, header, problem)
        ]
    )
    return m.PddlProblem(
        PddlNamesByOriginalName()[problem.name], header.name, objects, facts, denied=(), goal=goal
    )


def _export_atom(predicate: str, arguments: Sequence[int], pddl_names: Sequence[str]) -> f.Atom:
    return f.Atom(predicate, tuple([f.Constant(pddl_names[i]) for i in arguments]))


def _export_initial_facts(
    glossary: PddlExportNames, header: m.PddlDomain, problem: ProblemToExport
) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Yield the initial facts about the objects of a problem as atoms with PDDL names."""
    declared = {predicate.name for predicate in header.predicates}
    indices = list(iterate_bits(problem.exported_objects_mask))
    among = set(indices)
    for predicate, arguments in problem.initial.facts():
        name = glossary.predicates[predicate]
        if name in declared and among.issuperset(arguments):
            yield name, arguments
    for category, kind in glossary.category_predicates.items():
        yield from (
            (kind, (i,))
            for i in iterate_bits(problem.initial.scene.get_category_mask(category))
            if i in among
        )
    for name in glossary.without_formula:
        listed = make_fact_lister(glossary.vocabulary, name, allow_equal_arguments=True).list_facts(
            problem.initial, indices
        )
        yield from ((glossary.predicates[name], fact.arguments) for fact in listed)
    if glossary.uses_object_order:
        order = _get_precedes_predicate_name(glossary)
        yield from ((order, (i, j)) for place, i in enumerate(indices) for j in indices[place + 1 :])


REQUIREMENTS = (":adl", ":derived-predicates")


@dataclass(frozen=True, slots=True)
class ProblemToExport:
    """A problem of a declared domain that is to be exported as PDDL.

    Attributes:
        name: the name of the problem.
        initial: the initial state.
        goals: state formulas, and actions that must occur.
        objects: the objects of the problem as a bit mask; None for all objects of the initial state. The
            agent is always included, and facts about other objects are left out.
    """

    name: str
    initial: State
    goals: tuple[f.Formula, ...]
    objects: int | None = None

    @property
    def exported_objects_mask(self) -> int:
        """The objects of the problem and the agent, as a mask."""
        scene = self.initial.scene
        agent = 0 if scene.agent is None else 1 << scene.agent
        return scene.everything if self.objects is None else self.objects | agent


@dataclass(frozen=True, slots=True)
class ExportedProblem:
    """An exported domain and problem in PDDL. It converts states and actions to PDDL, and steps to actions.

    Attributes:
        domain: the domain.
        problem: the problem.
        unsupported: the parts of the domain and the problem that PDDL does not state exactly, each with the
            reason.
    """

    domain: m.PddlDomain
    problem: m.PddlProblem
    unsupported: tuple[str, ...]
    _operators: PddlNamesByOriginalName
    _predicates: PddlNamesByOriginalName
    _object_names: Sequence[str]

    def export_state(self, state: State) -> PddlState:
        """Return the true atoms of exported predicates in a state of the exported scene."""
        declared = {predicate.name for predicate in self.domain.predicates}
        facts = [(self._predicates[predicate], arguments) for predicate, arguments in state.facts()]
        return frozenset(
            [_export_atom(name, things, self._object_names) for name, things in facts if name in declared]
        )

    def to_pddl_step(self, action: Action) -> PlanStep:
        """Return a ground action of the declared domain as a step of a plan in PDDL."""
        return PlanStep(
            self._operators[action.operator], tuple([self._object_names[i] for i in action.arguments])
        )

    def to_action(self, step: PlanStep) -> Action:
        """Return a step of a plan in PDDL as a ground action of the declared domain.

        Raises:
            KeyError: the step has a name that was not exported.
        """
        index = {word: i for i, word in enumerate(self._object_names)}
        return Action(
            self._operators.find_original_name(step.action), tuple([index[name] for name in step.arguments])
        )


def export_domain_and_problem(
    domain: Domain,
    initial: State,
    goals: Sequence[f.Formula],
    *,
    objects: int | None = None,
) -> ExportedProblem:
    """Export a domain with one problem, given by the attributes of a `ProblemToExport`.

    Raises:
        DomainError: a goal is not about one state, or uses an undeclared name.
    """
    return export_problems(domain, (ProblemToExport("task", initial, tuple(goals), objects),))[0]


def export_problems(
    domain: Domain, problems: Sequence[ProblemToExport], *, with_invisible_predicates: bool = True
) -> tuple[ExportedProblem, ...]:
    """Export several problems that share one domain.

    The engine of this package skips a step that is not needed (an additional step), and continues the plan.
    In the exported PDDL, such a step is not applicable.

    Args:
        domain: the domain.
        problems: the problems.
        with_invisible_predicates: whether predicates that prompts and answers must not mention are exported
            too. Without them, preconditions require less, and effects that need these predicates do not
            happen.

    Raises:
        DomainError: a goal is not about one state, or uses an undeclared name.
    """
    glossary = PddlExportNames(domain.vocabulary)
    for problem in problems:
        glossary.add_types_of_objects(problem.initial.scene, problem.exported_objects_mask)
    hidden = (
        frozenset[str]()
        if with_invisible_predicates
        else find_predicates_forbidden_in_prompts(domain.vocabulary)
    )
    operators = PddlNamesByOriginalName(operator.name for operator in domain.operators)
    written = [_export_operator(each, operators, glossary, hidden) for each in domain.operators]
    things = [
        PddlNamesByOriginalName([*glossary.objects, *_list_object_names_in_formulas(problem.initial.scene)])
        for problem in problems
    ]
    goals = [
        _export_goal(glossary, names, problem, hidden)
        for names, problem in zip(things, problems, strict=True)
    ]
    header = _export_domain_header(glossary, domain.name, hidden, problems[0].initial.scene)
    actions = tuple([_add_effect_that_records_execution(action, glossary, operators) for action in written])
    exported = replace(header, actions=actions)
    unsupported = tuple(_find_unsupported_features(glossary))
    exported_problems = []
    for names, problem, goal in zip(things, problems, goals, strict=True):
        pddl_names = [names[key] for key in _list_object_names_in_formulas(problem.initial.scene)]
        exported_problem = _export_problem(glossary, pddl_names, header, problem, goal)
        exported_problems.append(
            ExportedProblem(
                exported, exported_problem, unsupported, operators, glossary.predicates, pddl_names
            )
        )
    return tuple(exported_problems)


def _find_unsupported_features(glossary: PddlExportNames) -> Iterator[str]:
    for name in glossary.without_formula:
        yield f"{name}: it is computed by a function and has no formula, so it keeps its initial value"
    for derived in map(glossary.vocabulary.derived_by_name.get, glossary.derived):
        if isinstance(derived, LookupPredicate) and derived.open_in_meaning:
            yield f"{derived.name}: its formula leaves open {derived.open_in_meaning}"


def _export_goal(
    glossary: PddlExportNames,
    object_names: PddlNamesByOriginalName,
    problem: ProblemToExport,
    hidden: frozenset[str],
) -> f.Formula:
    scene = problem.initial.scene
    about = ConditionWriter(glossary, object_names=object_names, scene=scene)
    agent = {} if scene.agent is None else {scene.objects[scene.agent].name: AGENT.name}
    goals = [rename_objects(goal, agent) for goal in problem.goals]
    return conjoin(
        [about.convert_formula_to_pddl(remove_hidden_predicates(goal, hidden), {}) for goal in goals]
    )


def _export_operator(
    operator: Operator,
    operator_names: PddlNamesByOriginalName,
    glossary: PddlExportNames,
    hidden: frozenset[str],
) -> m.PddlAction:
    """Return the exported operator, without the effect of `_add_effect_that_records_execution`."""
    conditions = ConditionWriter(glossary)
    scope = conditions.map_parameters_to_pddl_variables(operator.parameters)
    asked = [check.condition for check in operator.checks]
    if operator.alternatives:
        asked.append(_make_precondition_from_alternatives(operator))
    with prefix_errors_with_location(f"operator {operator.name}", DomainError):
        precondition = conjoin(
            [
                conditions.convert_formula_to_pddl(remove_hidden_predicates(condition, hidden), scope)
                for condition in asked
            ]
        )
        effect = convert_to_simultaneous_effect(operator, conditions, scope, hidden)
    return m.PddlAction(operator_names[operator.name], tuple(scope.values()), precondition, effect)


def _make_precondition_from_alternatives(operator: Operator) -> f.Formula:
    """Return the condition that one alternative of an operator succeeds, or that no alternative is tried.

    An alternative is a way to act. It is tried if its own condition holds, and succeeds if its checks hold,
    too.
    """
    succeeds = [f.And(attempt.conditions) for attempt in operator.alternatives]
    return f.Or((f.And(tuple([f.Not(attempt.condition) for attempt in operator.alternatives])), *succeeds))


def _add_effect_that_records_execution(
    action: m.PddlAction, glossary: PddlExportNames, operator_names: PddlNamesByOriginalName
) -> m.PddlAction:
    """Add an effect to an operator if a goal requires its execution. The effect states the execution."""
    done = glossary.execution_predicates.get(operator_names.find_original_name(action.name))
    if done is None:
        return action
    parts = action.effect.parts if isinstance(action.effect, m.AndEffect) else (action.effect,)
    return replace(action, effect=m.AndEffect((*parts, m.Add(f.Atom(done, ())))))


def _export_domain_header(
    glossary: PddlExportNames, name: str, hidden: frozenset[str], scene: Scene
) -> m.PddlDomain:
    """Return the exported domain without operators: all used predicates, types and constants."""
    axioms, constants = tuple(_export_axioms(glossary)), tuple(_export_constants(glossary, scene))
    stored = [p for p in glossary.vocabulary.predicates if p.name not in hidden]
    names = [each.name for each in stored] + [*glossary.derived, *glossary.without_formula]
    arities = {glossary.predicates[each]: glossary.vocabulary.find_arity(each) or 0 for each in names}
    arities |= dict.fromkeys(glossary.category_predicates.values(), 1) | dict.fromkeys(
        glossary.execution_predicates.values(), 0
    )
    if glossary.uses_object_order:
        arities[_get_precedes_predicate_name(glossary)] = 2
    return m.PddlDomain(
        name=PddlNamesByOriginalName()[name],
        requirements=REQUIREMENTS if axioms else REQUIREMENTS[:1],
        types=tuple(_export_types(glossary)),
        constants=constants,
        predicates=tuple(
            [
                m.PddlPredicate(each, tuple(map(f.Variable, make_parameter_names(n))))
                for each, n in arities.items()
            ]
        ),
        actions=(),
        axioms=axioms,
    )


def _export_types(glossary: PddlExportNames) -> Iterator[m.TypedName]:
    """Yield the types with their parents; the root type replaces a parent to which no object belongs."""
    for kind, written in glossary.types.items():
        parent = glossary.vocabulary.parents.get(kind, "")
        yield m.TypedName(written, glossary.types.get(parent, m.OBJECT))


def _export_constants(glossary: PddlExportNames, scene: Scene) -> Iterator[m.TypedName]:
    """Yield the objects that the domain names, with their types. Their types are equal in all scenes."""
    things = dict(zip(_list_object_names_in_formulas(scene), scene.objects, strict=True))
    for name, written in glossary.objects.items():
        yield m.TypedName(written, glossary.types[things[name].category] if name in things else m.OBJECT)


def _export_axioms(glossary: PddlExportNames) -> Iterator[m.PddlAxiom]:
    """Yield an axiom for each used derived predicate, even if only another axiom uses it."""
    names_done: set[str] = set()
    while rest := [
        derived_predicate
        for derived_predicate in glossary.derived.values()
        if derived_predicate.name not in names_done
    ]:
        for derived in rest:
            names_done.add(derived.name)
            conditions = ConditionWriter(glossary)
            scope = conditions.map_parameters_to_pddl_variables(derived.parameters)
            condition = conditions.convert_formula_to_pddl(derived.definition, scope)
            yield m.PddlAxiom(glossary.predicates[derived.name], tuple(scope.values()), condition)
