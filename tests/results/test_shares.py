from __future__ import annotations

from eai.results.lines import TidyTableLine, estimate_share_of_each_kind


def line(task: str, name: str) -> TidyTableLine:
    return TidyTableLine(protocol="strict", domain="d", ability="a", model="m", task=task, name=name)


def test_each_kind_has_its_share_of_all_lines_in_the_order_asked() -> None:
    lines = [line("1", "wash"), line("2", "wash"), line("3", "cook"), line("4", "read")]
    found = dict(estimate_share_of_each_kind(lines, ["x", "y", "x", "x"], ["y", "x", "z"]))
    assert [(kind, share.numerator, share.denominator) for kind, share in found.items()] == [
        ("y", 1, 4),
        ("x", 3, 4),
        ("z", 0, 4),
    ]
    assert all(share.low is not None and share.value is not None and share.low <= share.value
               for share in found.values())  # fmt: skip
