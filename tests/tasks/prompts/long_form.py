"""Write prompts of the sets ``short`` and ``facts`` in the form of our other prompts."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

from eai.tasks.short_lists import expand_shortened_lists

_OBJECTS = re.compile(r"^Objects(?: \[kind, unless in the name\]: properties|:)\n", re.MULTILINE)
_FACTS = re.compile(r"^(?:Facts(?:; nothing else holds\..*|:)|Now:)$")
_LINE = re.compile(r"([^\[:]+?)(?: \[([^\]]*)\])?(?:: (.+))?")
_ALL = re.compile(r"(\S+)\(\*\): all(?: but (.+))?")
_BOTH_WAYS = re.compile(r"(\S+)\((.+), (.+)\)")
_NUMBER = re.compile(r"[._-]?\d+$")
_RANGE = re.compile(r"(\S+?)(\d+)\.\.(\d+)")


def write_long_form(prompt: str) -> str:
    """Return a prompt with one object and one fact a line."""
    headings = [*_OBJECTS.finditer(prompt)]
    before, text = (
        (prompt[: headings[-1].start()], prompt[headings[-1].end() :]) if headings else ("", prompt)
    )
    lines = text.split("\n")
    start = next(number for number, line in enumerate(lines) if _FACTS.fullmatch(line))
    end = next((number for number in range(start, len(lines)) if not lines[number]), len(lines))
    listed, _, others = "\n".join(lines[:start]).strip("\n").partition("\n\n")
    kinds = {name: about for line in listed.splitlines() for name, about in _read_objects(line)}
    heading = "Now:" if lines[start].startswith("Now") else "Initial state:"
    objects = [f"{name} {about}" for name, about in kinds.items()]
    facts = [fact for line in lines[start + 1 : end] for fact in _read_facts(line, kinds)]
    parts = ["Objects [kind]: properties", *objects, "", others, "", heading, *facts, *lines[end:]]
    return before + "\n".join(parts)


def _read_objects(line: str) -> Iterator[tuple[str, str]]:
    """Yield each name in a line with its kind and properties."""
    read = _LINE.fullmatch(line)
    assert read is not None, line
    for name in [each for word in read[1].split(", ") for each in _count(word)]:
        kind = _NUMBER.sub("", name) if read[2] is None else read[2]
        yield name, f"[{kind}]: {read[3] or '-'}"


def _count(word: str) -> Sequence[str]:
    """Return the names in a range, or the name itself."""
    read = _RANGE.fullmatch(word)
    return [f"{read[1]}{number}" for number in range(int(read[2]), int(read[3]) + 1)] if read else [word]


def _read_facts(line: str, kinds: Mapping[str, str]) -> Iterator[str]:
    """Yield the facts that a line states."""
    everything = _ALL.fullmatch(line)
    if everything is not None:
        others = (everything[2] or "").split(", ")
        yield from (f"{everything[1]}({name})" for name in kinds if name not in others)
        return
    for fact in expand_shortened_lists(line.replace(" both ways", "")).splitlines():
        yield fact
        pair = _BOTH_WAYS.fullmatch(fact) if " both ways" in line else None
        if pair is not None:
            yield f"{pair[1]}({pair[3]}, {pair[2]})"
