"""Scenes of BEHAVIOR's tasks for the reference package, which needs a simulator even to score text.

Stand-in objects with our recorded states replace the simulator (`behavior_reference_child`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from eai.benchmarks.behavior.evidence import GroundRelation, load_unpublished_facts
from eai.benchmarks.behavior.tasks import (
    BehaviorTask,
    collect_initial_relations,
    yield_initial_states_of_objects,
)
from eai.extensions.reference.behavior_quirks import list_dnf_terms_that_eai_eval_tries
from eai.logic.formula import Atom, Formula, Not
from eai.logic.traversal import walk_subformulas

ALSO_IMPORTED = ("networkx", "pyyaml")
"""Packages that the reference package imports for BEHAVIOR without declaring them."""


def described(task: BehaviorTask, relations: Sequence[GroundRelation] | None = None) -> dict[str, Any]:
    """Return the scene of a task, with its own or other initial relations."""
    record, evidence = task.record, load_unpublished_facts()
    relations = collect_initial_relations(record, evidence) if relations is None else relations
    true = set(yield_initial_states_of_objects(record, evidence))
    instances = {thing.name: thing.instance for thing in record.objects}
    objects = []
    for thing in record.objects:
        marks = [
            m for m, a in (("Slicer", "slicer"), ("CleaningTool", "cleaningTool")) if a in thing.abilities
        ]
        states = {
            spelt(state): (state, thing.name) in true for state in thing.possible_states
        } | dict.fromkeys(marks, True)
        mine = [(predicate, target) for predicate, source, target in relations if source == thing.name]
        volume = evidence.volumes.get_volume(record.scene, thing.name, thing.model)
        for name in (thing.name, *thing.names_of_sliced_halves):
            part = name != thing.name
            related = (
                {}
                if part
                else {each: [target for predicate, target in mine if predicate == each] for each, _ in mine}
            )
            size = volume * evidence.volumes.ratio_of_half if part else volume
            objects.append(
                {
                    "name": name,
                    "floor": thing.is_floor,
                    "volume": size,
                    "states": states,
                    "relations": related,
                }
            )
    goals = [
        {
            "terms": [
                part.predicate for part in walk_subformulas(goal.formula) if hasattr(part, "predicate")
            ],
            "options": [
                [listed(literal, instances) for literal in option]
                for option in list_dnf_terms_that_eai_eval_tries(goal.formula, task.scene.names_of_category)
            ],
        }
        for goal in task.goals
    ]
    return {
        "activity": record.activity,
        "objects": objects,
        "scope": [[thing.instance, [thing.name, *thing.names_of_sliced_halves]] for thing in record.objects],
        "initial": [
            *map(words, record.problem.initial),
            *(["not", *words(fact)] for fact in record.problem.denied),
        ],
        "goals": goals,
    }


def words(fact: Atom) -> list[str]:
    """Return the words of an initial fact in the form of bddl's terms."""
    return [fact.predicate, *(term.name for term in fact.arguments)]


def spelt(state: str) -> str:
    """Return the simulator's class name of a state."""
    return "".join(word.capitalize() for word in state.split("_"))


def listed(literal: Formula, instances: dict[str, str]) -> list[Any]:
    """Return a literal in bddl's form of ground options."""
    if isinstance(literal, Not):
        return ["not", listed(literal.operand, instances)]
    return [literal.predicate, *(instances[term.name] for term in literal.arguments)]  # type: ignore[union-attr]
