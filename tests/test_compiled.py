"""What a compiled wheel needs of the code; that both builds say the same is shown by all tests run on it."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[1]
WITHOUT_INSTANCES = {"Enum", "IntEnum", "NamedTuple", "Protocol"}
"""Bases whose classes compiling leaves as they are, so that anybody may derive from them."""
AT_ONCE = {"all", "any", "dict", "frozenset", "list", "max", "min", "set", "sorted", "sum", "tuple"}
AT_ONCE |= {"extend", "fromkeys", "join", "next"}
"""What takes all that an iterator has, or is compiled as a loop that ends as early as the iterator would."""
FOR_HEIRS = "mypyc_attr(allow_interpreted_subclasses=True)"
"""What marks a compiled class from which plain Python may derive."""


@cache
def hook() -> dict[str, list[str]]:
    wheel = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]
    found: dict[str, list[str]] = wheel["hooks"]["mypyc"]
    return found


@cache
def compiled() -> frozenset[Path]:
    chosen = {path for pattern in hook()["include"] for path in ROOT.glob(pattern)}
    return frozenset(chosen - {path for pattern in hook()["exclude"] for path in ROOT.glob(pattern)})


def module_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT / "src").with_suffix("").parts)


@pytest.mark.parametrize("kind", ["include", "exclude"])
def test_what_is_compiled_is_named_by_what_there_is(kind: str) -> None:
    assert [pattern for pattern in hook()[kind] if not list(ROOT.glob(pattern))] == []


def test_a_checkout_is_not_compiled() -> None:
    assert hook()["enable-by-default"] is False
    assert list((ROOT / "src").rglob("*.so")) == []


def test_nobody_derives_from_a_compiled_class_who_is_not_compiled() -> None:
    made = {
        f"{module_of(path)}.{node.name}"
        for path in compiled()
        for node in ast.parse(path.read_text()).body
        if isinstance(node, ast.ClassDef) and not WITHOUT_INSTANCES & {*map(ast.unparse, node.bases)}
        if FOR_HEIRS not in map(ast.unparse, node.decorator_list)
    }
    sources = {*ROOT.glob("src/**/*.py"), *ROOT.glob("tests/**/*.py"), *ROOT.glob("examples/**/*.py")}
    heirs = [
        f"{path.relative_to(ROOT)}: {heir} derives from {base}"
        for path in sorted(sources - compiled())
        for heir, base in bases(path)
        if base in made
    ]
    assert heirs == []


def test_what_heirs_may_set_is_looked_up_in_their_class() -> None:
    """Compiled, any other attribute is read from its place in the object, where an heir's own is not."""
    assert [
        f"{path.relative_to(ROOT)}:{part.lineno}"
        for path in sorted(compiled())
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ClassDef) and FOR_HEIRS in map(ast.unparse, node.decorator_list)
        for part in node.body
        if isinstance(part, ast.Assign)
        or (isinstance(part, ast.AnnAssign) and "ClassVar" not in ast.unparse(part.annotation))
    ] == []


def test_no_named_tuple_holds_just_any_object() -> None:
    """Compiled, its class would look for the annotation `object` in its module: an alias says it as well."""
    assert [
        f"{path.relative_to(ROOT)}:{part.lineno}"
        for path in sorted(compiled())
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ClassDef) and "NamedTuple" in map(ast.unparse, node.bases)
        for part in node.body
        if isinstance(part, ast.AnnAssign) and ast.unparse(part.annotation) == "object"
    ] == []


def test_no_function_returns_a_float_where_it_might_return_an_integer() -> None:
    """Compiled, ``float`` makes a float of every integer, which records would write otherwise."""
    assert [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path in sorted(compiled())
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.FunctionDef) and node.returns and ast.unparse(node.returns) == "float"
    ] == []


def bases(path: Path) -> Iterator[tuple[str, str]]:
    """The classes of a file, each with one that it derives from, by the module that this is from."""
    tree = ast.parse(path.read_text())
    names = {
        alias.asname or alias.name: f"{node.module}.{alias.name}"
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            for base in node.bases:
                yield node.name, names.get(ast.unparse(base), "")


def test_frozen_classes_are_copied_and_pickled_as_what_makes_them() -> None:
    """Compiled, their attributes would be set one by one, which they forbid."""
    assert [
        f"{path.relative_to(ROOT)}: {node.name}"
        for path in sorted(compiled())
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ClassDef)
        and any("frozen=True" in ast.unparse(d) for d in node.decorator_list)
        if not {"Frozen", "_Connectives"} & {*map(ast.unparse, node.bases)}
    ] == []


def test_compiled_classes_make_nothing_on_demand() -> None:
    """A compiled object has no dictionary that could keep it."""
    assert [path for path in sorted(compiled()) if "cached_property" in path.read_text()] == []


def test_nothing_is_yielded_while_an_exception_is_handled() -> None:
    """A compiled generator that is left there leaves the exception with its thread."""
    handlers = [
        (path, node)
        for path in sorted(compiled())
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ExceptHandler)
    ]
    assert [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path, node in handlers
        if any(isinstance(inner, ast.Yield | ast.YieldFrom) for inner in ast.walk(node))
    ] == []


def test_generator_expressions_are_used_up_where_they_stand() -> None:
    """Compiled, one is a list: what else takes it would wait for all of it."""
    assert [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path in sorted(compiled())
        for outer in ast.walk(ast.parse(path.read_text()))
        for node in ast.iter_child_nodes(outer)
        if isinstance(node, ast.GeneratorExp)
        and not isinstance(outer, ast.Starred)
        and not (isinstance(outer, ast.Call) and ast.unparse(outer.func).split(".")[-1] in AT_ONCE)
    ] == []


def test_no_function_is_decorated_within_another() -> None:
    """Compiled, it is not found by a lambda beside it."""
    assert [
        f"{path.relative_to(ROOT)}:{inner.lineno}"
        for path in sorted(compiled())
        for outer in ast.walk(ast.parse(path.read_text()))
        if isinstance(outer, ast.FunctionDef)
        for inner in ast.walk(outer)
        if isinstance(inner, ast.FunctionDef) and inner is not outer and inner.decorator_list
    ] == []
