"""Tests of the finder of unclear texts and of the check of commit subjects."""

from __future__ import annotations

from pathlib import Path

import pytest

from by_path import ROOT, module_at
from eai.base.files import read_toml

FINDER = module_at("tools/plain_english.py")
SUBJECTS = module_at("tools/commit_subjects.py")
DATA = read_toml(FINDER.DATA)
HABITS = [(strength, habit) for strength in ("strong", "weak") for habit in DATA[strength]]


@pytest.mark.parametrize(("strength", "habit"), HABITS, ids=[habit["name"] for _, habit in HABITS])
def test_a_habit_is_noticed_in_its_example(strength: str, habit: dict[str, str]) -> None:
    habits = FINDER.read_habits()
    assert habit["name"] in habits.names_in(habit["example"])
    if strength == "strong":
        assert habits.is_marked(habit["example"])


@pytest.mark.parametrize(
    "text",
    [
        "Return edits of which every repair contains at least one.",
        "What is left.",
        "How often choices are drawn, where it matters.",
    ],
)
def test_a_text_with_a_strong_habit_or_two_weak_ones_is_marked(text: str) -> None:
    assert FINDER.read_habits().is_marked(text)


@pytest.mark.parametrize(
    "text",
    [
        "Return the plan, or None if there is no plan.",
        "Maximum number of cached steps.",
        "Return `what it is of` as code.",
        "One weak habit alone.",
    ],
)
def test_a_plain_text_is_not_marked(text: str) -> None:
    assert not FINDER.read_habits().is_marked(text)


def test_docstrings_attribute_docstrings_and_long_comments_are_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FINDER, "ROOT", tmp_path)
    folder = tmp_path / "src" / "eai" / "world"
    folder.mkdir(parents=True)
    path = folder / "scene.py"
    path.write_text(
        '"""A module."""\n\nLIMIT = 3\n"""A limit."""\n\n\n'
        'def draw():\n    """Draw."""\n    # another thread may draw too\n'
    )
    texts = list(FINDER.find_texts(path))
    assert [(text.owner, text.content) for text in texts] == [
        ("module", "A module."),
        ("LIMIT", "A limit."),
        ("draw", "Draw."),
        ("#", "another thread may draw too"),
    ]
    assert {FINDER.get_folder(text.path) for text in texts} == {"src/eai/world"}


def test_exceptions_are_few_exist_and_are_marked() -> None:
    exceptions = FINDER.read_habits().exceptions
    assert len(exceptions) <= FINDER.MAX_EXCEPTIONS
    assert all(exceptions.values())
    for path, owner, beginning in exceptions:
        contents = [text.content for text in FINDER.find_texts(ROOT / path) if text.owner == owner]
        marked = [content for content in contents if FINDER.read_habits().is_marked(content)]
        assert any(" ".join(content.split()).startswith(beginning) for content in marked), (path, owner)


def test_each_checked_folder_has_a_limit() -> None:
    folders = {
        FINDER.get_folder(path.relative_to(ROOT).as_posix())
        for folder in FINDER.CHECKED
        for path in FINDER.find_python_files(ROOT / folder)
    }
    assert folders == set(FINDER.read_habits().limits)


@pytest.mark.parametrize(
    ("subject", "faults"),
    [
        ("Return the shortest plan first", 0),
        ("Whether a page is up to date is shown", 1),
        (f"Return {'x' * 80}", 1),
        ("", 1),
    ],
)
def test_a_commit_subject_is_an_imperative_of_at_most_72_characters(subject: str, faults: int) -> None:
    assert len(SUBJECTS.find_faults(subject)) == faults
