"""`eai.world` exports the names that a declaration needs."""

from __future__ import annotations

import ast
from pathlib import Path

import eai.world
from eai.world.conformance import check_domain
from world import toy


def test_every_public_name_can_be_imported() -> None:
    assert [name for name in eai.world.__all__ if not hasattr(eai.world, name)] == []
    assert eai.world.check_domain is check_domain


def test_the_toy_domain_uses_public_names_only() -> None:
    tree = ast.parse(Path(toy.__file__).read_text(encoding="utf-8"))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    assert [node.module for node in imports] == ["__future__", "eai.world"]
