from __future__ import annotations

import errno
import json
import os
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.base.errors import DataError
from eai.base.store import DataPackStore, default_folder

MEMBERS = {"tasks.jsonl": b"one\ntwo\n" * 40, "more/of.json": b'{"a": [1, 2]}', "empty": b""}


def test_a_written_pack_is_read_back(store: DataPackStore) -> None:
    store.write_pack("pack", {"x==1": "digest"}, MEMBERS)
    pack = store.open_pack("pack")
    assert {name: pack.read_member(name) for name in MEMBERS} == MEMBERS
    assert pack.read_json("more/of.json") == {"a": [1, 2]}
    assert pack.archives == {"x==1": "digest"}
    assert [path.name for path in store.folder.iterdir()] == ["pack.1.zip"]


def test_equal_content_gives_equal_bytes_and_an_equal_digest(store: DataPackStore) -> None:
    first = store.write_pack("a", {}, MEMBERS)
    second = store.write_pack("b", {}, dict(reversed(MEMBERS.items())))
    changed = store.write_pack("c", {}, {**MEMBERS, "empty": b"."})
    again = store.write_pack("d", {}, MEMBERS)
    assert first.path.read_bytes() == again.path.read_bytes()
    assert first.sha256 == second.sha256 != changed.sha256


def test_the_environment_variable_chooses_the_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("EAI_DATA_DIR", str(tmp_path))
    assert default_folder() == DataPackStore().folder == tmp_path
    monkeypatch.delenv("EAI_DATA_DIR")
    assert "eai" in default_folder().parts


def test_the_error_for_an_absent_pack_says_what_to_do(store: DataPackStore) -> None:
    with pytest.raises(DataError, match=r"eai data fetch.*EAI_DATA_DIR"):
        store.open_pack("pack")


def test_the_error_for_an_absent_member_says_what_to_do(store: DataPackStore) -> None:
    store.write_pack("pack", {}, MEMBERS)
    with pytest.raises(DataError, match="no member other; run `eai data fetch --force`"):
        store.open_pack("pack").read_member("other")


@given(data=st.data())
def test_damage_is_never_read_as_data(data: st.DataObject) -> None:
    """A changed, cut or overwritten file gives each member as written, or a one-line DataError."""
    with TemporaryDirectory() as folder:
        store = DataPackStore(Path(folder))
        path = store.write_pack("pack", {"x==1": "digest"}, MEMBERS).path
        content = bytearray(path.read_bytes())
        place = data.draw(st.integers(0, len(content) - 1))
        match data.draw(st.sampled_from(["flip", "cut", "zero"])):
            case "flip":
                content[place] ^= data.draw(st.integers(1, 255))
            case "cut":
                del content[place:]
            case _:
                content[place : place + 64] = bytes(len(content[place : place + 64]))
        path.write_bytes(content)
        try:
            pack = store.open_pack("pack")
            found = {name: pack.read_member(name) for name in pack.members}
        except DataError as error:
            message = str(error)
        else:
            assert found == MEMBERS
            return
    assert "eai data fetch --force" in message
    assert "\n" not in message


@pytest.mark.parametrize(
    "wrong", [{"schema": 2}, {"sha256": "0" * 64}, {"members": {"other": "0" * 64}}, {"members": 3}]
)
def test_a_manifest_that_contradicts_itself_is_an_error(
    store: DataPackStore, wrong: dict[str, object]
) -> None:
    path = store.write_pack("pack", {}, MEMBERS).path
    with zipfile.ZipFile(path) as archive:
        manifest = json.loads(archive.read("manifest.json"))
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("manifest.json", json.dumps({**manifest, **wrong}))
    with pytest.raises(DataError, match=r"is damaged \(.*manifest.*--force"):
        store.open_pack("pack")


def test_a_full_disk_leaves_the_old_pack(store: DataPackStore, monkeypatch: pytest.MonkeyPatch) -> None:
    store.write_pack("pack", {}, MEMBERS)

    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(DataError, match=r"No space left on device.*EAI_DATA_DIR"):
        store.write_pack("pack", {}, {"a": b"new"})
    assert store.open_pack("pack").read_member("tasks.jsonl") == MEMBERS["tasks.jsonl"]
    assert [path.name for path in store.folder.iterdir()] == ["pack.1.zip"]


def test_only_partial_files_of_writers_are_removed(store: DataPackStore) -> None:
    store.write_pack("pack", {}, MEMBERS)
    (store.folder / ".pack.1.zip.77.partial").write_bytes(b"half")
    store.remove_partial_packs()
    assert [path.name for path in store.folder.iterdir()] == ["pack.1.zip"]
