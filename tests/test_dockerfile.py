"""Tests of the Dockerfile without a Docker daemon: the copied files suffice to install the package."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parent.parent
RECIPE = (ROOT / "Dockerfile").read_text(encoding="utf-8")
COPIES = [line.split()[1:] for line in RECIPE.splitlines() if line.startswith("COPY ")]


def test_what_is_copied_is_not_kept_out() -> None:
    let_in = {line[1:] for line in (ROOT / ".dockerignore").read_text().splitlines() if line.startswith("!")}
    assert {source for *sources, _ in COPIES for source in sources} == let_in


def test_what_is_copied_is_enough_to_build_the_package(tmp_path: Path) -> None:
    for *sources, target in COPIES:
        for source in sources:
            place = tmp_path / target.lstrip("/")
            if (ROOT / source).is_dir():
                shutil.copytree(ROOT / source, place, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                place.mkdir(exist_ok=True)
                shutil.copy(ROOT / source, place)
    build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", tmp_path]
    subprocess.run([*build, tmp_path / "src"], check=True)
    (wheel,) = tmp_path.glob("*.whl")
    packed = set(zipfile.ZipFile(wheel).namelist())
    files = [file for file in (ROOT / "src").rglob("*") if file.is_file() and "__pycache__" not in file.parts]
    assert [f for f in files if f.relative_to(ROOT / "src").as_posix() not in packed] == []


def test_the_extras_are_there() -> None:
    match = re.search(r"pip install --no-cache-dir '/src\[(?P<extras>[a-z,]+)\]'", RECIPE)
    assert match is not None
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert set(match["extras"].split(",")) <= project["optional-dependencies"].keys()


def test_it_runs_as_nobody_special_and_holds_no_data() -> None:
    assert RECIPE.index("USER eai") < RECIPE.index("ENTRYPOINT")
    assert "EAI_DATA_DIR=/data" in RECIPE
    assert "data fetch" not in "".join(line for line in RECIPE.splitlines() if line.startswith("RUN"))
