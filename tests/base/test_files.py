"""Users' files: ends of lines, files in folders, and files on a full disk."""

from __future__ import annotations

import errno
import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from eai.base.errors import InputError
from eai.base.files import (
    LOCK_FILE,
    escape_unprintable,
    find_files_below,
    lock_run_folder,
    number_lines,
    parse_json,
    read_content,
    write_files_atomically,
)


def test_only_a_line_feed_ends_a_line() -> None:
    content = "a\u2028b\u2029c\u0085d\x0ce\x1ef\r\n\n \t\ng".encode()
    assert [(number, line.decode()) for number, line in number_lines(content)] == [
        (1, "a\u2028b\u2029c\u0085d\x0ce\x1ef\r"),
        (4, "g"),
    ]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_in_a_folder_is_not_listed_as_a_file(tmp_path: Path) -> None:
    (tmp_path / "b").mkdir()
    for name in ("b/z.json", "a.json", "a.txt", "b/c.yaml"):
        (tmp_path / name).touch()
    os.mkfifo(tmp_path / "pipe.json")
    found = find_files_below(tmp_path, "*.json", "*.txt")
    assert [file.relative_to(tmp_path).as_posix() for file in found] == ["a.json", "a.txt", "b/z.json"]


def test_files_are_written_whole_or_not_at_all(tmp_path: Path) -> None:
    old, new = tmp_path / "old.json", tmp_path / "new" / "n.json"
    old.write_text("before")

    def pieces() -> Iterator[str]:
        yield "one"
        raise OSError(28, "No space left on device")

    with pytest.raises(InputError, match=r"old\.json: cannot be written \(No space left on device\)"):
        write_files_atomically({new: "all of it", old: pieces()})
    assert old.read_text() == "before"
    assert [file for file in tmp_path.rglob("*") if file.is_file()] == [old]
    write_files_atomically({new: "all \ud800", old: (part for part in ("of", " it"))})
    assert (new.read_text(), old.read_text()) == ("all \\ud800", "of it")


FULL = """
import resource, signal, sys
from pathlib import Path
from eai.base.files import write_files_atomically
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
try:
    write_files_atomically({Path(sys.argv[1]) / "records.jsonl": ("x" * 1000 for _ in range(100))})
except Exception as error:
    print(f"{type(error).__name__}: {error}")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs a limit on files")
def test_a_full_disk_leaves_the_old_file(tmp_path: Path) -> None:
    (tmp_path / "records.jsonl").write_text("before")
    done = subprocess.run([sys.executable, "-c", FULL, tmp_path], capture_output=True, text=True, check=True)
    assert done.stdout == f"InputError: {tmp_path}/records.jsonl: cannot be written (File too large)\n"
    assert [file.read_text() for file in tmp_path.iterdir()] == ["before"]


def test_writing_keeps_a_link_a_link_and_a_device_a_device(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "file")
    write_files_atomically({tmp_path / "link": "x", Path(os.devnull): "y"})
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "file").read_text() == "x"
    assert not Path(os.devnull).is_file()


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("gpt-4o, größe ✓\n\tx", "gpt-4o, größe ✓\n\tx"),
        ("\x1b[2Jm", r"\x1b[2Jm"),
        ("m\x9b31m\r\x07\x7f", r"m\x9b31m\r\x07\x7f"),
        ("m\u202egnp\u2028.\udcff", r"m\u202egnp\u2028.\udcff"),
    ],
)
def test_an_escaped_text_cannot_control_a_terminal(text: str, shown: str) -> None:
    assert escape_unprintable(text) == shown


def test_links_to_folders_are_followed_once(tmp_path: Path) -> None:
    for name in ("kept", "elsewhere"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.json").write_text("")
    (tmp_path / "kept" / "linked").symlink_to(tmp_path / "elsewhere", target_is_directory=True)
    (tmp_path / "elsewhere" / "round").symlink_to(tmp_path / "kept", target_is_directory=True)
    found = find_files_below(tmp_path / "kept", "*.json")
    assert [file.relative_to(tmp_path / "kept").as_posix() for file in found] == ["a.json", "linked/a.json"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_named_pipe_and_a_device_are_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path, kind in ((tmp_path / "pipe", "a named pipe"), (Path("/dev/zero"), "a device")):
        with pytest.raises(InputError, match=f"{path}: is {kind}; give a file, or give /dev/stdin"):
            read_content(path)
    with socket.socket(socket.AF_UNIX) as opened:
        opened.bind(str(tmp_path / "s"))
        with pytest.raises(InputError, match="is a socket"):
            read_content(tmp_path / "s")


@pytest.mark.skipif(not Path("/dev/fd").exists(), reason="this system does not name descriptors")
def test_a_pipe_that_the_shell_has_opened_is_read() -> None:
    reading, writing = os.pipe()
    os.write(writing, b"content")
    os.close(writing)
    assert read_content(Path(f"/dev/fd/{reading}")) == b"content"
    os.close(reading)


@pytest.fixture
def without_locks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the file system of a test one that cannot lock files."""
    fcntl = pytest.importorskip("fcntl")

    def flock(file: object, operation: int) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", flock)


@pytest.mark.usefixtures("without_locks")
def test_a_second_run_in_a_folder_is_refused_on_a_file_system_without_locks(tmp_path: Path) -> None:
    held = tmp_path / "run" / f"{LOCK_FILE}.held"
    with lock_run_folder(tmp_path / "run"):
        assert held.is_file()
        message = f"is writing to this folder; .*; if no process is running there, delete {held}"
        with pytest.raises(InputError, match=message), lock_run_folder(tmp_path / "run"):
            pass
    assert not held.exists()
    with lock_run_folder(tmp_path / "run"):
        pass


def test_locking_an_unwritable_folder_is_an_error_that_names_it(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with (
        pytest.raises(InputError, match="file/run: cannot be written"),
        lock_run_folder(tmp_path / "file" / "run"),
    ):
        pass


def test_a_repeated_member_is_found_among_many(tmp_path: Path) -> None:
    """Each member used to be compared with all earlier ones, which took minutes."""
    members = ", ".join([*(f'"{number}": 1' for number in range(100_000)), '"99999": 2'])
    with pytest.raises(InputError, match="the member '99999' occurs twice in a JSON object"):
        parse_json(tmp_path / "a.json", f"{{{members}}}".encode())
