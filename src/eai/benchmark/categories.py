"""Task categorisation (paper, "Task Categorization"): which two kinds of predicate is a task about?

A task is a document whose words are the predicates of its operators, each once an operator. A category's
weight in a task is the sum, over the words in it, of the inverse document frequency ``ln(tasks / tasks with
the predicate)``; the two heaviest categories are the task's. Computed over the tasks that are evaluated,
this is the data set's own assignment, task by task, if the one operator with a hyphen in its name
(BEHAVIOR's ``slice-carvingknife``, in 3 tasks) is left out, as the data set's own extraction of operators
did; with it 92 of BEHAVIOR's 100 tasks agree (the paper's table of sizes swaps the rows of object
affordance and object orientation).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence

from eai.abilities.transition_modeling.task import Category, TransitionTask
from eai.logic.formula import Atom, Formula
from eai.logic.traversal import walk
from eai.pddl.model import PddlAction, effect_atoms, effect_conditions

PER_TASK = 2
"""How many categories a task has."""


def categorise(tasks: Mapping[str, TransitionTask]) -> dict[str, tuple[Category, ...]]:
    """Task id -> its two categories, the heavier first; equal weights keep the order of mention."""
    documents = {task_id: _predicates(task) for task_id, task in tasks.items()}
    frequency = Counter(predicate for words in documents.values() for predicate in set(words))
    rarity = {predicate: math.log(len(documents) / count) for predicate, count in frequency.items()}
    return {
        task_id: _heaviest(documents[task_id], rarity, task.domain.categories)
        for task_id, task in tasks.items()
    }


def _heaviest(
    words: Sequence[str], rarity: Mapping[str, float], categories: Mapping[str, Category]
) -> tuple[Category, ...]:
    weights: dict[Category, float] = {}
    for word in words:
        category = categories.get(word)
        if category is not None:
            weights[category] = weights.get(category, 0.0) + rarity[word]
    return tuple(sorted(weights, key=lambda category: -round(weights[category], 9))[:PER_TASK])


def _predicates(task: TransitionTask) -> list[str]:
    return [word for name, action in task.gold.items() if name.isidentifier() for word in _words(action)]


def _words(action: PddlAction) -> list[str]:
    """The predicates of an operator, each once, by name."""
    conditions: list[Formula] = [action.precondition, *effect_conditions(action.effect)]
    atoms = [part for condition in conditions for part in walk(condition) if isinstance(part, Atom)]
    return sorted({atom.predicate for atom in (*atoms, *effect_atoms(action.effect))})
