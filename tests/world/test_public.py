"""`eai.world` hands on what a declaration of one's own needs."""

from __future__ import annotations

import ast
from pathlib import Path

import eai.world
from eai.world.conformance import check
from world import toy


def test_every_public_name_is_there() -> None:
    assert [name for name in eai.world.__all__ if not hasattr(eai.world, name)] == []
    assert eai.world.check is check


def test_the_toy_domain_needs_no_other_name() -> None:
    tree = ast.parse(Path(toy.__file__).read_text(encoding="utf-8"))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    assert [node.module for node in imports] == ["__future__", "eai.world"]
