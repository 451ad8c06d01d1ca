"""Folders of the repository, and modules outside packages, such as tools."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).resolve().parents[1]
"""Folder of the repository."""

TESTS = ROOT / "tests"
"""Folder of the tests, which is on the path of modules."""


def module_at(path: str) -> ModuleType:
    """Return the module of a file of the repository, executed anew."""
    name = f"by_path_{Path(path).stem}"
    spec = importlib.util.spec_from_file_location(name, ROOT / path)
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
