"""A person plays: lines that are typed become commands of an episode, or are answered beside the game.

The person gets the observations that models get, and every command counts as theirs do. Who asks what is
possible knows more than they do, so that the harness of the episode says it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import groupby
from operator import attrgetter

from eai.acting.play import Episode, Play, read_episode
from eai.envs.command import DONE, LOOK, is_look
from eai.envs.game import Stage, manual
from eai.errors import InputError, did_you_mean
from eai.world.fault import FaultKind

HARNESS, PROMPTED = "person", "person who asked what is possible"
"""What acts, in records."""

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

_LINE = re.compile(r"\s*([\w-]+)\s*(.*?)\s*")


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
    told = [play.act(turn.said) for turn in before.turns]
    same = (before.rules, before.seed, before.turns) == (stage.rules, seed, tuple(play.turns))
    if not same or before.harness not in (HARNESS, PROMPTED):
        raise InputError(f"{stage.task.id} was begun by somebody else, in another setting or with other data")
    return play, told


def words(play: Play) -> list[str]:
    """The words that commands may be made of: actions, and the objects that have been seen."""
    stage, wording = play.game.stage, play.game.stage.benchmark.observed_wording()
    names = [wording.object_name(stage.task, index) for index in sorted(play.game.known)]
    return [*_operators(stage), *names]


def enter(play: Play, line: str) -> str:
    """What a person reads after a line: the observation, or what was asked for beside the game."""
    stage = play.game.stage
    command = command_in(line, _operators(stage))
    if command.startswith(POSSIBLE):
        play.harness = PROMPTED
        return "\n".join(_possible(play, command.removeprefix(POSSIBLE).split())) or "Nothing like that."
    if command.casefold() == HELP:
        return f"{manual(stage.benchmark, stage.rules.feedback, stage.rules.view)}\n\n{stage.opening}"
    known = words(play)
    told = play.look() if is_look(command, stage.domain) else play.act(command)
    if not told.startswith(f"Failed ({FaultKind.HALLUCINATION.value})"):
        return told
    unknown = [word for word in re.findall(r"[^\s(),]+", command) if word not in known]
    hints = filter(None, [did_you_mean(word, known) for word in unknown])
    return "\n".join([told, *(f"({hint.removeprefix('; ')})" for hint in hints)])


def command_in(line: str, operators: Sequence[str]) -> str:
    """The command in a line: the operator as it is written, and brackets around its objects."""
    found = _LINE.fullmatch(line)
    named = {each.casefold(): each for each in operators}
    if found is None or found[1].casefold() not in named:
        return line.strip()
    objects = found[2] if found[2].startswith("(") else f"({', '.join(found[2].replace(',', ' ').split())})"
    return named[found[1].casefold()] + (objects if found[2] else "")


def _operators(stage: Stage) -> list[str]:
    return [*stage.domain.arities, DONE, LOOK]


def _possible(play: Play, parts: Sequence[str]) -> Iterator[str]:
    """What is possible now, a line an operator; only what has all these parts in it."""
    write = play.game.stage.commands.write
    for operator, actions in groupby(play.game.admissible(), key=attrgetter("operator")):
        commands = [write(action).replace(", ", ",") for action in actions]
        chosen = [each for each in commands if all(part.casefold() in each.casefold() for part in parts)]
        if chosen:
            yield f"{operator}: {' '.join(each.partition('(')[2].removesuffix(')') for each in chosen)}"
