"""The pack of BEHAVIOR-1K in the store: which archive it is made from, and how."""

from __future__ import annotations

from collections.abc import Mapping

from eai.data.dataset import open_pack
from eai.data.progress import Report, silent
from eai.data.source import Archive, Bundle, Pack
from eai.data.store import PackFile, Store

BDDL = Archive(
    name="bddl",
    version="3.6.0",
    filename="bddl-3.6.0.tar.gz",
    sha256="81d40ab7a32769828ecad3110c7db5e40e26cfb29b1158b3448a6ccb91e5d386",
    size=2_338_616,
)
"""BEHAVIOR-1K's definitions, annotations and rules (MIT)."""

NAME = "behavior_1k"


def _convert(files: Mapping[str, Bundle], report: Report) -> dict[str, bytes]:
    from eai.households.behavior_1k.convert import convert_activities

    return convert_activities(files[BDDL.name], report)


PACK = Pack(NAME, (BDDL,), _convert)


def open_activities(store: Store | None = None, *, report: Report = silent) -> PackFile:
    """Open the pack; when it is absent, fetch the archive and make it, which takes some 10 s.

    Raises:
        DataError: it cannot be obtained, or is damaged.
    """
    return open_pack(NAME, store, packs=(PACK,), report=report)
