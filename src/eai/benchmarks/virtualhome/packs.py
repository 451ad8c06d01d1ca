"""The data packages (packs) of VirtualHome, which are fetched and installed on first use."""

from __future__ import annotations

from eai.benchmarks.packs import DataPack
from eai.benchmarks.reference_wheel import EAI_EVAL, PUBLISHED
from eai.benchmarks.virtualhome.benchmark import list_unexpected_counts
from eai.benchmarks.virtualhome.convert import convert_tasks
from eai.benchmarks.virtualhome.records import PACK

PACKS = (DataPack(PACK, (EAI_EVAL,), convert_tasks, list_unexpected_counts), *PUBLISHED)
"""All packs (data packages) of VirtualHome. An entry point registers them."""
