"""Shares of lines by their kind: of answers by leaf, of errors by check, of wrong goals by reason."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TypeVar

from eai.abilities.share import NONE, ONE
from eai.results.lines import Line
from eai.results.suites import case_of
from eai.results.table import Estimate

K = TypeVar("K")


def shares_by_kind(
    lines: Sequence[Line], kinds: Sequence[K], asked: Iterable[K]
) -> Iterator[tuple[K, Estimate]]:
    """Each kind that is asked for, with the share of lines that are of it.

    Args:
        lines: all lines.
        kinds: the kind of each.
        asked: those to tell, in this order.
    """
    of_it, of_others = ([case_of(line, share) for line in lines] for share in (ONE, NONE))
    for kind in asked:
        chosen = zip(kinds, of_it, of_others, strict=True)
        yield kind, Estimate.of([case if found == kind else other for found, case, other in chosen])
