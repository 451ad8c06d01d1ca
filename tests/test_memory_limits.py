"""Tests that a test with too much memory fails, and that its message has the number of bytes."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = """
import mmap, subprocess, sys
import memory_limits

memory_limits.limit_writable_memory()

def test_small():
    bytearray(20 << 20)

def test_large():
    bytearray(600 << 20)

def test_huge():
    mmap.mmap(-1, 6 << 30, mmap.MAP_PRIVATE)

def test_huge_child():
    command = "import mmap; mmap.mmap(-1, 6 << 30, mmap.MAP_PRIVATE)"
    subprocess.run([sys.executable, "-c", command], check=True)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="memory is limited on Linux only")
def test_tests_that_take_too_much_fail(tmp_path: Path) -> None:
    (tmp_path / "test_memory.py").write_text(TESTS)
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "memory_limits", "-p", "no:cacheprovider"]
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parent)}
    ended = subprocess.run(
        command, capture_output=True, text=True, check=False, cwd=tmp_path, env=environment
    )
    assert "3 failed, 1 passed" in ended.stdout
    assert re.search(r"the test takes \d+ MiB of memory, more than 500 MiB", ended.stdout)
    assert "E       OSError: [Errno 12] Cannot allocate memory" in ended.stdout
