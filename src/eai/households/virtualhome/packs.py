"""The packs that VirtualHome reads."""

from __future__ import annotations

from eai.benchmark.packs import Pack
from eai.households.packs import EAI_EVAL, PUBLISHED
from eai.households.virtualhome.benchmark import check_tasks
from eai.households.virtualhome.convert import convert_tasks
from eai.households.virtualhome.records import PACK

PACKS = (Pack(PACK, (EAI_EVAL,), convert_tasks, check_tasks), *PUBLISHED)
"""Registered by an entry point."""
