"""A person plays: lines that are typed become commands of an episode, or are answered beside the game.

The person gets the observations that models get, and every command counts as theirs do. Who asks what is
possible knows more than they do, so that the harness of the episode says it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from itertools import groupby
from operator import attrgetter

from eai.abilities.declining import list_declining_commands
from eai.agents.command import DONE, LOOK
from eai.agents.observation import manual
from eai.agents.play import Episode, Play, read_episode
from eai.agents.stage import Stage
from eai.base.errors import InputError
from eai.world.fault import FaultKind

HARNESS, PROMPTED = "person", "person who asked what is possible"
"""The names of people in records, as harnesses."""

POSSIBLE, HELP = "?", "help"
"""The lines that are no commands."""

RULES = f"""\
Every line is one action and counts, also with a mistake, also if impossible.
Brackets and capitals may be left out: "open jar_0" is OPEN(jar_0).
{DONE} ends the task: it is won if all goals hold then, and lost without it.
These cost nothing:
  {HELP}      all actions with what they need, and the task again
  {POSSIBLE} WORD    what is possible now and has WORD in it, or all of it; the record
            says that you asked"""

_LINE = re.compile(r"\s*([\w-]+)\s*(?:(\(.*\))|([^()\[\]{}]*?))\s*")
"""An action, and its objects with brackets around them or without."""


def begin(stage: Stage, seed: int, answer: str = "") -> tuple[Play, Sequence[str]]:
    """An episode of a person, which resumes where an answer stops, and what was observed in it so far.

    Raises:
        InputError: the answer is no episode of a person with these rules, seed and data.
    """
    if not answer:
        return Play(stage, seed, 1, harness=HARNESS), ()
    before = read_episode(answer)
    if not isinstance(before, Episode):
        raise InputError(f"{stage.task.id}: {before.reason}")
    play = Play(stage, seed, 1, harness=before.harness)
    told = [play.say(turn.said) for turn in before.turns]
    same = (before.rules, before.seed, before.turns) == (stage.rules, seed, tuple(play.turns))
    if not same or before.harness not in (HARNESS, PROMPTED):
        raise InputError(f"{stage.task.id} was begun by somebody else, in another setting or with other data")
    return play, told


def completions(play: Play, before: str) -> list[str]:
    """The words that may follow on a line: actions first, then objects that have been seen."""
    stage, wording = play.stage, play.stage.benchmark.observed_wording()
    if not before.strip():
        return _operators(stage)
    return [wording.object_name(stage.task, index) for index in sorted(play.memory.known)]


def enter(play: Play, line: str) -> str:
    """Carry a line out; returns the observation, or the answer to a question beside the game."""
    stage = play.stage
    command = command_in(line, _operators(stage))
    if command.startswith(POSSIBLE):
        play.harness = PROMPTED
        return "\n".join(_possible(play, command.removeprefix(POSSIBLE).split())) or "Nothing like that."
    if command.casefold() == HELP:
        return f"{manual(stage.benchmark, stage.rules)}\n\n{stage.opening}"
    known = [*completions(play, ""), *completions(play, command)]
    taken = len(play.turns)
    told = play.say(command)
    if len(play.turns) == taken or play.outcome.fault is not FaultKind.HALLUCINATION:
        return told
    by_case = {word.casefold(): word for word in known}
    unknown = [word.casefold() for word in re.findall(r"[^\s(),]+", command) if word not in known]
    near = [by_case[each] for word in unknown for each in get_close_matches(word, by_case, 1)]
    return "\n".join([told, *(f"(did you mean {word}?)" for word in near)])


def command_in(line: str, operators: Sequence[str]) -> str:
    """The command in a line: the operator as it is written, and brackets around its objects."""
    found = _LINE.fullmatch(line)
    if found is None:
        return line.strip()
    operator, brackets, words = found.groups()
    operator = {each.casefold(): each for each in operators}.get(operator.casefold(), operator)
    return operator + (brackets or (f"({', '.join(words.replace(',', ' ').split())})" if words else ""))


def _operators(stage: Stage) -> list[str]:
    return [*stage.domain.arities, DONE, LOOK, *list_declining_commands(stage.task)]


def _possible(play: Play, parts: Sequence[str]) -> Iterator[str]:
    """The actions that are possible now, a line an operator; only those with all these parts in them."""
    write = play.stage.commands.write
    for operator, actions in groupby(play.admissible(), key=attrgetter("operator")):
        commands = [write(action).replace(", ", ",") for action in actions]
        chosen = [each for each in commands if all(part.casefold() in each.casefold() for part in parts)]
        if chosen:
            objects = " ".join([each.partition("(")[2].removesuffix(")") for each in chosen])
            yield f"{operator}: {objects}".rstrip(": ")
