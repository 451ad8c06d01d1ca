"""The benchmark of `envs.switches` with a defect: reading a plan with the word BOOM raises an exception."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from agents.switches import SWITCHES, tasks
from eai import use_tasks
from eai.abilities.notation.notation import Notation
from eai.abilities.notation.plans import JsonPlanNotation, WrittenPlan
from eai.abilities.verdict import Unreadable

BOOM = "BOOM!"

NAME = "raising:RAISING"


class _RaisingPlans(JsonPlanNotation):
    def read(self, text: str, actions: Collection[str] = ()) -> WrittenPlan | Unreadable:
        if "BOOM" in text:
            raise OverflowError("cannot convert float infinity to integer")
        return super().read(text)


RAISING = replace(
    SWITCHES, name="raising", open_tasks=use_tasks(*tasks()), notation=Notation(_RaisingPlans())
)
