"""Write the table of prompt lengths in docs/running.md: `python tools/prompt_lengths.py`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from statistics import median
from typing import get_args

from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark, get_title, list_paper_benchmarks
from eai.benchmarks.suite import open_suite
from eai.run.context import choose_default_max_answer_tokens, estimate_longest_answer, estimate_prompt_tokens
from eai.run.job import DecodingOptions
from eai.tasks.prompts.prompt import PromptSet

PAGE = Path(__file__).resolve().parents[1] / "docs" / "running.md"
BEGIN, END = "<!-- prompt lengths: tools/prompt_lengths.py -->\n", "<!-- end -->\n"
SETS: Sequence[PromptSet] = get_args(PromptSet)
SMALL_CONTEXT = 2048
"""Number of tokens in the context of a small model."""


def make_page() -> str:
    """Return the page with a new table."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    return before + BEGIN + "".join(_make_table()) + END + rest.partition(END)[2]


def _make_table() -> Iterable[str]:
    yield f"| suite | {' | '.join([f'`{name}`' for name in SETS])} | longest gold answer | `max_tokens` |\n"
    yield f"|---|{'--:|' * (len(SETS) + 2)}\n"
    for domain in (*list_paper_benchmarks(), "behavior-1k"):
        for ability in map(Ability, PAPER_ABILITIES):
            yield row(domain, ability)


def row(domain: str, ability: Ability) -> str:
    """Return the row of a suite: median and maximum tokens of its prompts, by prompt set.

    For `short`, the row also has the number of prompts that a small context cannot hold.
    """
    benchmark, suite = find_benchmark(domain), open_suite(domain, ability)
    cells = [f"{get_title(domain)}, {ability.value.replace('_', ' ')}"]
    for name in SETS:
        prompts = PromptLibrary(name, None, suite.source).open(benchmark, ability).values()
        lengths = [estimate_prompt_tokens(prompt) for prompt in prompts]
        longer = sum(length > SMALL_CONTEXT for length in lengths)
        note = f"; {longer} of {len(lengths)} above {SMALL_CONTEXT:,}" if name == "short" and longer else ""
        cells.append(f"{round(median(lengths)):,} ({max(lengths):,}{note})")
    limit = choose_default_max_answer_tokens("", suite, DecodingOptions())
    return f"| {' | '.join([*cells, f'{estimate_longest_answer(suite):,}', f'{limit:,}'])} |\n"


if __name__ == "__main__":
    PAGE.write_text(make_page(), encoding="utf-8")
