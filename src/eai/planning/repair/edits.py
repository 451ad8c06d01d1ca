"""Edits of a plan: inserted, deleted and replaced steps.

`align_plans` converts one plan to another by fewest edits.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby, product
from math import inf
from typing import NamedTuple, TypeAlias

from eai.world.action import Action

PlanSteps: TypeAlias = Sequence["Action | None"]
"""Steps of a written plan; None stands for an unreadable step."""


class EditedPlanStep(NamedTuple):
    """An entry of an edited plan.

    Attributes:
        step: the number of the step in the original plan; -1 for an inserted step.
        action: the action; None if the step was deleted.
    """

    step: int
    action: Action | None

    @property
    def is_unchanged_step(self) -> bool:
        """Whether this entry of an edited plan is an unchanged step."""
        return self.step >= 0 and self.action is not None


EditedPlan: TypeAlias = tuple[EditedPlanStep, ...]

FirstChangedPosition: TypeAlias = int
"""Position of the first step of an edited plan that differs from the plan before the last edit."""


class PlanEdit(NamedTuple):
    """An edit of a plan.

    Attributes:
        step: the number, from 0, of the step before which the edit takes place.
        removed: the number of the deleted or replaced step; None if the edit only inserts.
        action: the inserted action; None if the edit only deletes.
    """

    step: int
    removed: int | None
    action: Action | None


def make_unedited_plan(plan: PlanSteps) -> EditedPlan:
    """Return a plan as an edited plan whose steps are all unchanged."""
    return tuple([EditedPlanStep(i, action) for i, action in enumerate(plan)])


def align_plans(plan: PlanSteps, other: Sequence[Action]) -> EditedPlan:
    """Return the edits that turn a plan into another plan, with fewest edits (Levenshtein 1966)."""
    rows = [[*range(len(other) + 1)]]
    for i, step in enumerate(plan, 1):
        row = [i]
        for j, action in enumerate(other):
            row.append(min(rows[-1][j] + (step != action), rows[-1][j + 1] + 1, row[j] + 1))
        rows.append(row)
    entries: list[EditedPlanStep] = []
    i, j = len(plan), len(other)
    while i or j:
        if i and j and plan[i - 1] == other[j - 1] and rows[i][j] == rows[i - 1][j - 1]:
            i, j = i - 1, j - 1
            entries.append(EditedPlanStep(i, other[j]))
            continue
        is_replacement = i and j and rows[i][j] == rows[i - 1][j - 1] + 1
        if i and (is_replacement or rows[i][j] == rows[i - 1][j] + 1):
            i -= 1
            entries.append(EditedPlanStep(i, None))
        if j and (is_replacement or entries[-1:] != [EditedPlanStep(i, None)]):
            j -= 1
            entries.append(EditedPlanStep(-1, other[j]))
    return tuple(reversed(entries))


def undo_one_edit(plan: EditedPlan, original: PlanSteps) -> Iterator[EditedPlan]:
    """Yield all plans in which one insertion of an edited plan is undone, or one deletion, or one of each.

    An insertion and a deletion can be one edit, a replacement.
    """
    yield from _undo_one_insertion(plan)
    start = 0
    for is_unchanged_step, entries in groupby(plan, key=lambda entry: entry.is_unchanged_step):
        segment_entries = [*entries]
        before, after = plan[:start], plan[start + len(segment_entries) :]
        start += len(segment_entries)
        inserted = [entry for entry in segment_entries if entry.step < 0]
        deleted = [] if is_unchanged_step else segment_entries[len(inserted) :]
        for i, position in product(range(len(deleted)), range(len(inserted), -1, -1)):
            restored = deleted[i]._replace(action=original[deleted[i].step])
            if restored.is_unchanged_step:
                changed = (
                    *inserted[:position],
                    *deleted[:i],
                    restored,
                    *inserted[position:],
                    *deleted[i + 1 :],
                )
                yield (*before, *changed, *after)
                yield from _undo_one_insertion((*before, *changed, *after))


def _undo_one_insertion(plan: EditedPlan) -> Iterator[EditedPlan]:
    yield from ((*plan[:i], *plan[i + 1 :]) for i, entry in enumerate(plan) if entry.step < 0)


class EditCost(NamedTuple):
    """The number of edits of an edited plan, by kind.

    A deletion and an insertion without an unchanged step between them are one edit, a replacement.

    Attributes:
        edits: the number of edits, replacements included.
        deletions: the number of edits that only delete a step.
        insertions: the number of edits that only insert a step.
    """

    edits: int
    deletions: int
    insertions: int

    def count_min_edits_after_more_insertions(self, insertion_count: int) -> int:
        """Return the minimum number of edits of the plan with ``insertion_count`` more insertions."""
        return self.edits + max(0, insertion_count - self.deletions)


def compute_edit_cost(plan: EditedPlan) -> EditCost:
    """Count the edits of an edited plan.

    A deletion and an insertion without an unchanged step between them are one edit, a replacement.
    """
    edits = deletions = insertions = deleted = inserted = 0
    for step, action in (*plan, _END):
        if step < 0:
            inserted += 1
        elif action is None:
            deleted += 1
        elif deleted or inserted:
            edits += max(deleted, inserted)
            deletions += max(0, deleted - inserted)
            insertions += max(0, inserted - deleted)
            deleted = inserted = 0
    return EditCost(edits, deletions, insertions)


def count_edits_or_infinity(plan: EditedPlan | None) -> float:
    """Return the number of edits of an edited plan; infinity for None."""
    return inf if plan is None else compute_edit_cost(plan).edits


def find_positions_deletable_without_extra_edit(plan: EditedPlan) -> Iterator[int]:
    """Yield the positions of unchanged steps whose deletion does not raise the number of edits.

    Between such a step and the previous unchanged step, the plan has more insertions than deletions. The
    deletion and a surplus insertion count as one edit, a replacement.
    """
    surplus = 0
    for position, entry in enumerate(plan):
        if entry.is_unchanged_step and surplus > 0:
            yield position
        surplus = 0 if entry.is_unchanged_step else surplus + (1 if entry.step < 0 else -1)


_END = EditedPlanStep(0, Action("", ()))
"""Sentinel: an unchanged step that is appended to a plan when its edits are counted.

It closes the last group of insertions and deletions.
"""


def list_plan_edits(plan: EditedPlan) -> tuple[PlanEdit, ...]:
    """Return the edits of an edited plan. Deletions and insertions between unchanged steps are paired."""
    edits: list[PlanEdit] = []
    inserted: list[Action | None] = []
    deleted: list[int] = []
    for step, action in (
        *plan,
        EditedPlanStep(max((entry.step for entry in plan), default=-1) + 1, _END.action),
    ):
        if step < 0:
            inserted.append(action)
        elif action is None:
            deleted.append(step)
        else:
            pairs = min(len(inserted), len(deleted))
            edits += [PlanEdit(g, g, a) for g, a in zip(deleted, inserted, strict=False)]
            edits += [PlanEdit(g, g, None) for g in deleted[pairs:]] + [
                PlanEdit(step, None, a) for a in inserted[pairs:]
            ]
            inserted, deleted = [], []
    return tuple(edits)


def put_insertions_before_deletions(plan: EditedPlan) -> EditedPlan:
    """Return an edited plan in which, between unchanged steps, inserted steps come before deleted steps."""
    entries_in_order: list[EditedPlanStep] = []
    for is_unchanged_step, entries in groupby(plan, key=lambda entry: entry.is_unchanged_step):
        segment = [*entries]
        entries_in_order += (
            segment if is_unchanged_step else sorted(segment, key=lambda entry: entry.step >= 0)
        )
    return tuple(entries_in_order)


def insert_or_delete_step(
    plan: EditedPlan, position: int, inserted: Action | None
) -> tuple[EditedPlan, FirstChangedPosition]:
    """Return a plan after one more edit, and the index of the first entry that the edit changed.

    The edit inserts a step before the entry at ``position``. If ``inserted`` is None, it deletes the step of
    this entry: the entry stays, but loses its action. Between two unchanged steps, entries of inserted steps
    come before entries of deleted steps.
    """
    start = position
    while start and plan[start - 1].step >= 0 and plan[start - 1].action is None:
        start -= 1
    if inserted is not None:
        return (*plan[:start], EditedPlanStep(-1, inserted), *plan[start:]), start
    end = position + 1
    while end < len(plan) and plan[end].step < 0:
        end += 1
    deleted = plan[position]._replace(action=None)
    return (*plan[:start], *plan[position + 1 : end], *plan[start:position], deleted, *plan[end:]), start
