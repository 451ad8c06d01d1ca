"""Read goals from texts such as ``forall l: lamp. (lit(l))``, check names, and make tasks with goals."""

from __future__ import annotations

from dataclasses import replace

import eai.logic.formula as f
from eai.base.errors import InputError, did_you_mean, prefix_errors_with_location
from eai.logic.ltl import read_formula
from eai.logic.ltl_printer import format_ltl
from eai.logic.rewriting import rename_objects, rewrite_state_subformulas, standardize_variable_names
from eai.logic.signature import describe_wrong_arity
from eai.logic.traversal import (
    find_free_variables,
    find_object_names,
    get_bound_variables,
    is_state_formula,
    walk_subformulas,
)
from eai.tasks.lexicon import FormulaNameLexicon, make_lexicon_of_declared_names
from eai.tasks.task import Task, goal
from eai.world.domain import Domain
from eai.world.frame import AGENT
from eai.world.state import Scene, State


def make_goal_lexicon(domain: Domain, scene: Scene) -> FormulaNameLexicon:
    """Return the names that goals about a scene may use. Actions may be named without their objects."""
    lexicon = make_lexicon_of_declared_names(domain, scene)
    signature = replace(lexicon.signature, actions=dict.fromkeys(lexicon.signature.actions), parsed={})
    return replace(lexicon, signature=signature)


def read_goal(text: str, domain: Domain, scene: Scene) -> f.Formula:
    """Return the goal that a text states.

    Raises:
        InputError: the text cannot be parsed, or names something that the scene lacks. The message names the
            expected text.
    """
    lexicon = make_goal_lexicon(domain, scene)
    signature = lexicon.signature
    stated, misuses = read_formula(text, signature)
    for misuse in misuses:
        is_object = misuse.kind == "unknown_object"
        known = lexicon.objects if is_object else {**signature.predicates, **signature.actions}
        raise InputError(str(misuse) + did_you_mean(misuse.name, known))
    formula = rewrite_state_subformulas(stated, lexicon.replace_lexicon_names_by_domain_names)
    _check_goal_actions(formula, domain)
    check_goal_names(formula, scene)
    return formula


def _check_goal_actions(formula: f.Formula, domain: Domain | None) -> None:
    """Raise InputError if a goal about one state joins actions with conditions, or if an action is unknown.

    An action with a wrong number of objects is refused, too.
    """
    actions = [part for part in walk_subformulas(formula) if isinstance(part, f.Occurs)]
    is_about_one_state = is_state_formula(formula)
    if is_about_one_state and actions and not _is_disjunction_of_action_names(formula):
        raise InputError(
            "a goal with actions may only join actions by 'or', without objects and other conditions"
        )
    if domain is None:
        return
    for action in actions:
        name, actual = action.action, len(action.arguments)
        wanted = domain.operator_arities.get(name)
        if wanted is None:
            raise InputError(f"action {name} is not declared{did_you_mean(name, domain.operator_arities)}")
        if wanted != actual and not is_about_one_state:
            raise InputError(describe_wrong_arity(name, wanted, "object", actual))


def check_goal_names(formula: f.Formula, scene: Scene) -> None:
    """Check that a goal names only objects of a scene and predicates of the scene's vocabulary.

    Raises:
        InputError: a name is unknown. The message suggests a similar name.
    """
    kinds = scene.object_mask_by_kind
    for part in walk_subformulas(formula):
        if isinstance(part, f.Atom):
            scene.vocabulary.require_arity(part.predicate, len(part.arguments))
        for variable in get_bound_variables(part):
            kind = variable.category
            if kind is not None and kind not in kinds:
                raise InputError(f"the scene has no object of the category {kind}{did_you_mean(kind, kinds)}")
    for name in find_object_names(formula):
        if name != AGENT.name or scene.agent is None:
            scene.find_object_index(name)
    for name in sorted(find_free_variables(formula)):
        raise InputError(
            f"variable {name} is not bound; add a quantifier, as in 'exists {name}: lamp. (lit({name}))'"
        )


def _is_disjunction_of_action_names(formula: f.Formula) -> bool:
    """Whether a formula is one action without objects, or a disjunction of such actions."""
    parts = f.get_operands(formula, f.Or)
    return all(isinstance(part, f.Occurs) and not part.arguments for part in parts)


def make_task(
    task_id: str,
    instruction: str,
    initial: State,
    *goals: f.Formula | str,
    title: str = "",
    domain: Domain | None = None,
) -> Task:
    """Return a task about all objects of its scene.

    Args:
        task_id: id of the task, with which answers name it.
        instruction: the task in natural language.
        initial: the state in which a plan starts.
        goals: formulas, or texts such as ``forall l: lamp. (lit(l))``.
        title: name that similar tasks share; if empty, the task's id is its title.
        domain: the domain of the task; needed if a text names actions, and to check actions of formulas.

    Raises:
        InputError: the id is empty or not a text; or a goal is neither a text nor a formula, cannot be
            parsed, or names something unknown. The message names the expected text.
    """
    if not isinstance(task_id, str) or not task_id:
        raise InputError(f"expected the id of a task as a text, found {task_id!r}")
    scene = initial.scene
    agent_name = {} if scene.agent is None else {AGENT.name: scene.objects[scene.agent].name}
    formulas = []
    for number, stated in enumerate(goals, 1):
        with prefix_errors_with_location(f"task {task_id}, goal {number}"):
            if isinstance(stated, str):
                formulas.append(read_goal(stated, domain or Domain("", scene.vocabulary, ()), scene))
            elif not isinstance(stated, f.Formula):
                raise InputError(f"expected a text or a formula, found {type(stated).__name__}")
            else:
                _check_goal_actions(stated, domain)
                check_goal_names(stated, scene)
                formulas.append(rename_objects(stated, agent_name))
    everything = tuple(range(len(scene.objects)))
    return Task(task_id, title or task_id, instruction, initial, tuple(map(goal, formulas)), everything)


def write_goal(formula: f.Formula) -> str:
    """Return the text of a goal, as `read_goal` reads it.

    An action whose objects may be any objects is written as its name alone.
    """
    match formula:
        case f.Occurs(action, ()):
            return action
        case f.Or(operands) if operands and all(isinstance(operand, f.Occurs) for operand in operands):
            return " or ".join(map(write_goal, operands))
        case _:
            return format_ltl(standardize_variable_names(formula))
