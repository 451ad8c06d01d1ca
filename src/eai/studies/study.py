"""Studies as values: what they are called, and the options that a run of one takes."""

from __future__ import annotations

from dataclasses import dataclass

from eai.abilities.options import Options


@dataclass(frozen=True, slots=True)
class Study:
    """A variation around a benchmark and an ability.

    Attributes:
        name: the name of its section in a run's specification.
        title: a few words on what varies, and for which questions.
        options: what can be chosen; the defaults are those of a run without the study.
    """

    name: str
    title: str
    options: type[Options]
