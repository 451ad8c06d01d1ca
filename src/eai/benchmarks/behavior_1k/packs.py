"""The data package (pack) of BEHAVIOR-1K, which is fetched and installed on first use."""

from __future__ import annotations

from eai.base.source import PackageArchive
from eai.benchmarks.behavior_1k.convert import convert_tasks
from eai.benchmarks.behavior_1k.kinds import PACK
from eai.benchmarks.packs import DataPack

BDDL = PackageArchive(
    name="bddl",
    version="3.6.0",
    filename="bddl-3.6.0.tar.gz",
    sha256="81d40ab7a32769828ecad3110c7db5e40e26cfb29b1158b3448a6ccb91e5d386",
    size=2_338_616,
)
"""Archive with definitions, annotations and rules of BEHAVIOR-1K (license: MIT)."""

PACKS = (DataPack(PACK, (BDDL,), convert_tasks),)
"""The pack (data package) of BEHAVIOR-1K. An entry point registers it."""
