"""What is remembered is bounded."""

from __future__ import annotations

from eai.abilities.transition_modeling.memory import Memory


def test_results_are_found_once_until_they_are_forgotten() -> None:
    memory: Memory[int, str] = Memory(limit=2)
    found: list[int] = []

    def recalled(key: int) -> str:
        return memory.recall(key, lambda: str(found.append(key) or key))

    assert [recalled(key) for key in (1, 2, 1, 3, 1)] == ["1", "2", "1", "3", "1"]
    assert found == [1, 2, 3, 1]
    assert len(memory) == 2
