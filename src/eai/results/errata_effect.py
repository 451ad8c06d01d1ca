"""What errata of the data did to the numbers of a run, as its records say it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from eai.abilities.record import Record
from eai.abilities.verdict import Json


@dataclass(frozen=True, slots=True)
class ErrataEffect:
    """How many tasks of a run errata left out or corrected.

    Attributes:
        version: of the errata.
        tasks: tasks with a record.
        scored: those of them that rates are of.
        left_out: ids of those that errata left out of all rates.
        corrected: ids of those that were scored with a correction.
    """

    version: str
    tasks: int
    scored: int
    left_out: tuple[str, ...]
    corrected: tuple[str, ...]

    @property
    def remark(self) -> str:
        """One sentence for the reader of the numbers: what was done, and how to have it otherwise."""
        others = self.tasks - self.scored - len(self.left_out)
        more = f", {others} not scored for other reasons" if others else ""
        return (
            f"Errata {self.version}: of {self.tasks} tasks {len(self.left_out)} left out, "
            f"{len(self.corrected)} corrected{more}; {self.scored} scored. "
            "--errata none takes the data as published."
        )

    def to_json(self) -> dict[str, Json]:
        """The effect as ``summary.json`` has it."""
        return {
            "version": self.version,
            "tasks": self.tasks,
            "scored": self.scored,
            "left_out": list(self.left_out),
            "corrected": list(self.corrected),
        }


def errata_effect(records: Sequence[Record]) -> ErrataEffect | None:
    """The effect on a run; None if no errata were used."""
    versions = dict.fromkeys(record.errata.version for record in records if record.errata is not None)
    if not versions:
        return None
    touched = [record for record in records if record.errata is not None and record.errata.entries]
    return ErrataEffect(
        version=", ".join(versions),
        tasks=len(records),
        scored=sum(record.verdict.excluded is None for record in records),
        left_out=tuple(record.task_id for record in touched if record.verdict.excluded is not None),
        corrected=tuple(record.task_id for record in touched if record.verdict.excluded is None),
    )
