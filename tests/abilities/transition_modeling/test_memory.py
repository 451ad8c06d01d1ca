"""What is remembered is bounded."""

from __future__ import annotations

from eai.abilities.transition_modeling.memory import Memory


def test_results_are_found_once_until_they_are_forgotten() -> None:
    memory: Memory[int, str] = Memory(limit=6)
    found: list[int] = []

    def recalled(key: int) -> str:
        return memory.recall(key, size=key, find=lambda: str(found.append(key) or key))

    assert [recalled(key) for key in (1, 5, 1, 3, 5, 1, 3)] == ["1", "5", "1", "3", "5", "1", "3"]
    assert found == [1, 5, 3, 5, 1, 3]  # 3 puts 1 and 5 out, 5 puts 3 out
    assert memory.size == 4


def test_what_is_larger_than_the_memory_is_found_and_forgotten() -> None:
    memory: Memory[str, int] = Memory(limit=2)
    assert [memory.recall("long", 3, lambda: 7), memory.size] == [7, 0]
    assert [memory.recall("a", 1, lambda: 8), memory.recall("a", 1, lambda: 9)] == [8, 8]
