from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest

from eai.base.errors import InputError
from eai.tasks.prompts.prompt import (
    Image,
    Prompt,
    PromptFiles,
    _ZlibCompressedPromptMapping,
    make_memory_saving_prompt_mapping,
    read_prompt_file,
    read_system_message_file,
)


def test_digest_covers_both_messages_and_where_they_meet() -> None:
    assert Prompt("question").sha256 == hashlib.sha256(b"question").hexdigest()
    assert len({Prompt("bc", "a").sha256, Prompt("c", "ab").sha256, Prompt("abc").sha256}) == 3
    assert Prompt("q", stop=("}",)).sha256 == Prompt("q").sha256


def test_files_have_the_shape_of_the_reference(tmp_path: Path) -> None:
    prompts = {"27_2": Prompt("ask ünder", "be brief"), "1_1": Prompt("?", "be brief")}
    files = PromptFiles.from_prompts(prompts)
    assert json.loads(files.prompts) == [
        {"identifier": "27_2", "llm_prompt": "ask ünder"},
        {"identifier": "1_1", "llm_prompt": "?"},
    ]
    (tmp_path / "p.json").write_bytes(files.prompts)
    assert read_prompt_file(tmp_path / "p.json") == {"27_2": "ask ünder", "1_1": "?"}
    assert files.system is not None
    (tmp_path / "s.json").write_bytes(files.system)
    assert read_system_message_file(tmp_path / "s.json") == "be brief"
    assert PromptFiles.from_prompts({"1_1": Prompt("?")}).system is None


@pytest.mark.parametrize(
    "content", ["", "{}", '[{"identifier": "1"}]', '[{"identifier": 1, "llm_prompt": "?"}]']
)
def test_another_shape_is_refused_by_name(tmp_path: Path, content: str) -> None:
    file = tmp_path / "p.json"
    file.write_text(content)
    with pytest.raises(InputError, match=r"p\.json: expected a list"):
        read_prompt_file(file)
    with pytest.raises(InputError, match=r"p\.json: expected .*system_prompt") as caught:
        read_system_message_file(file)
    assert "\n" not in str(caught.value)


def test_packed_prompts_are_the_prompts_in_less_memory() -> None:
    rules = "\n".join(f"rule {number}" for number in range(1000))
    prompts = {str(number): Prompt(f"{rules}\ntask {number}", "be brief") for number in range(100)}
    prompts["odd"] = Prompt(
        "lone \udc80", stop=("}",), turns=(("a", "b"),), images=(Image("image/png", b"1"),)
    )
    packed = make_memory_saving_prompt_mapping(prompts.items())
    assert packed == prompts
    assert list(packed) == list(prompts)
    assert isinstance(packed, _ZlibCompressedPromptMapping)
    assert sum(len(text) for text, _ in packed._packed.values()) < 2 * len(rules)
    assert make_memory_saving_prompt_mapping({"0": Prompt(""), "1": Prompt("?")}.items()) == {
        "0": Prompt(""),
        "1": Prompt("?"),
    }
