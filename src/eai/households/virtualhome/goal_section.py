"""How VirtualHome's official prompts state the goals of a task.

The order of relations is that of the goals. In 21 of the published prompts of subgoal decomposition it is
that of a Python set.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from eai.abilities.goal_test import alternatives
from eai.abilities.protocol import Ability
from eai.abilities.task import GoalKind
from eai.households.virtualhome.tasks import PREDICATE_OF_RELATION
from eai.logic.formula import Atom, Formula
from eai.prompts.believed import Belief, GoalSection

_LINE = "-----------------"
_HEADING_OF_ACTIONS = (
    "[Actions Must Include]: Actions are listed in the execution order, each line is one action to satisfy. "
    'If "A or B or ..." is presented in one line, then only one of them needs to be satisfied.'
)
_RELATIONS = {predicate: name for name, predicate in PREDICATE_OF_RELATION.items()}


def _for_plans(belief: Belief) -> str:
    """Objects by class, relations as scene graphs name them; every line of actions stands there twice."""
    task = belief.task
    classes = {thing.name: thing.category for thing in task.scene.objects}
    actions = [alternatives(goal) for goal in task.goals_of(GoalKind.ACTION)]
    required = ["There is no action requirement."]
    if actions:
        lines = [line for each in actions for line in (" or ".join(each), "|".join(each))]
        required = ["The following action(s) should be included:", *lines, _LINE]
    return "\n".join(
        [
            *(_sentence(goal.formula, classes) for goal in task.goals_of(GoalKind.STATE)),
            _LINE,
            "\n\nEdge goals are:",
            *(_sentence(goal.formula, classes) for goal in task.goals_of(GoalKind.RELATION)),
            _LINE,
            "\n\nAction goals are:",
            *required,
        ]
    )


def _for_subgoals(belief: Belief) -> str:
    """Objects by class and id, predicates as the vocabulary has them, and whether there are any actions."""
    task = belief.task
    lasting = [goal.formula for goal in task.goals if goal.kind is not GoalKind.ACTION]
    actions = [" or ".join(alternatives(goal)) for goal in task.goals_of(GoalKind.ACTION)]
    return "\n".join(
        [
            "[States]",
            *_or_none(f"{each.predicate}({', '.join(_names(each))})" for each in map(_atom, lasting)),
            _HEADING_OF_ACTIONS,
            *_or_none(actions),
            "\n## Necessity to Use Actions",
            "Yes" if actions else "No",
        ]
    )


GOAL_SECTIONS: Mapping[Ability, GoalSection] = {
    Ability.ACTION_SEQUENCING: GoalSection("Node goals are:\n", "\n\n\nPlease output the list", _for_plans),
    Ability.SUBGOAL_DECOMPOSITION: GoalSection("## Goal States\n", "\n\n## Output", _for_subgoals),
}
"""Where the official prompts state the goals."""


def _sentence(formula: Formula, classes: Mapping[str, str]) -> str:
    """``soap is ON to washing_machine``; a name that is no object's stays."""
    atom = _atom(formula)
    name, *others = [classes.get(each, each) for each in _names(atom)]
    said = f"{name} is {_RELATIONS.get(atom.predicate, atom.predicate)}"
    return " to ".join([said, *others])


def _atom(formula: Formula) -> Atom:
    if not isinstance(formula, Atom):
        raise TypeError(f"{formula} is no state and no relation")
    return formula


def _names(atom: Atom) -> list[str]:
    return [term.name for term in atom.arguments]


def _or_none(lines: Iterable[str]) -> list[str]:
    return list(lines) or ["None"]
