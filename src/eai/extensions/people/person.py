"""Turn lines that a person types into commands of an episode, or answer the person's questions.

The person gets the observations that models get, and every command counts as a model's command does. A person
who asks which actions are possible knows more than a model, so the record of the episode says so.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from difflib import get_close_matches
from itertools import groupby
from operator import attrgetter

from eai.abilities.declining import list_agent_commands_declining_task
from eai.agents.command import DONE, LOOK
from eai.agents.game_setup import GameSetup
from eai.agents.observation import make_manual
from eai.agents.play import RecordedGame, StoredEpisode, read_episode
from eai.base.errors import InputError
from eai.world.fault import FaultKind

HARNESS, PROMPTED = "person", "person who asked what is possible"
"""Values of the field `harness` (the means of playing) in the record of a game that a person played.

`PROMPTED` means that the person asked which actions are possible, `HARNESS` that the person did not.
"""

POSSIBLE, HELP = "?", "help"
"""Lines by which a person asks a question. They are no commands, so they do not count as actions."""

RULES = f"""\
Every line is one action and counts, also with a mistake, also if impossible.
Brackets and capitals may be left out: "open jar_0" is OPEN(jar_0).
{DONE} ends the task: it is won if all goals hold then, and lost without it.
These cost nothing:
  {HELP}      all actions with what they need, and the task again
  {POSSIBLE} WORD    what is possible now and has WORD in it, or all of it; the record
            says that you asked"""

_LINE = re.compile(r"\s*([\w-]+)\s*(?:(\(.*\))|([^()\[\]{}]*?))\s*")
"""Regular expression for an action and its objects, with or without brackets."""


def get_new_or_resumed_episode_and_observations(
    game_setup: GameSetup, seed: int, saved_episode: str = ""
) -> tuple[RecordedGame, Sequence[str]]:
    """Return a new or resumed episode of a person, and its observations so far.

    Args:
        game_setup: The task with the rules of the game.
        seed: Seed of slips (actions that fail at random).
        saved_episode: Text of the episode to resume; empty for a new episode.

    Raises:
        InputError: The text is not an episode that a person played with these rules, this seed and this data.
    """
    if not saved_episode:
        return RecordedGame(game_setup, seed, 1, harness=HARNESS), ()
    saved = read_episode(saved_episode)
    if not isinstance(saved, StoredEpisode):
        raise InputError(
            f"{game_setup.task.id}: the answer in the file --out cannot be read as an episode: "
            f"{saved.reason}; give another file as --out, or remove this answer"
        )
    play = RecordedGame(game_setup, seed, 1, harness=saved.harness)
    observations = [play.play_command(turn.said) for turn in saved.turns]
    is_same = (saved.rules, saved.seed, saved.turns) == (game_setup.rules, seed, tuple(play.turns))
    if not is_same or saved.harness not in (HARNESS, PROMPTED):
        raise InputError(
            f"{game_setup.task.id}: the file --out has an episode that cannot be resumed: a model played it, "
            "or it had other settings or data; give the settings of this episode, or another file as --out"
        )
    return play, observations


def list_possible_next_words(play: RecordedGame, before: str) -> list[str]:
    """Return words that may come next on a line: actions at its beginning, then objects seen so far."""
    setup, wording = play.setup, play.setup.benchmark.observation_wording()
    if not before.strip():
        return _list_operator_names(setup)
    return [wording.object_name(setup.task, index) for index in sorted(play.memory.known)]


def execute_line(play: RecordedGame, line: str) -> str:
    """Execute a typed line and return the observation. If the line is a question, return its answer."""
    setup = play.setup
    command = normalize_command(line, _list_operator_names(setup))
    if command.startswith(POSSIBLE):
        play.harness = PROMPTED
        return (
            "\n".join(_list_possible_actions_with_words(play, command.removeprefix(POSSIBLE).split()))
            or "Nothing like that."
        )
    if command.casefold() == HELP:
        return f"{make_manual(setup.benchmark, setup.rules)}\n\n{setup.opening}"
    words = [*list_possible_next_words(play, ""), *list_possible_next_words(play, command)]
    turns = len(play.turns)
    observation = play.play_command(command)
    if len(play.turns) == turns or play.outcome.fault is not FaultKind.HALLUCINATION:
        return observation
    by_case = {word.casefold(): word for word in words}
    unknown = [word.casefold() for word in re.findall(r"[^\s(),]+", command) if word not in words]
    similar = [by_case[match] for word in unknown for match in get_close_matches(word, by_case, 1)]
    return "\n".join([observation, *(f"(did you mean {word}?)" for word in similar)])


def normalize_command(line: str, operators: Sequence[str]) -> str:
    """Return a typed line as a command: the operator's name with its capitals, the objects in brackets."""
    match = _LINE.fullmatch(line)
    if match is None:
        return line.strip()
    operator, brackets, words = match.groups()
    operator = {name.casefold(): name for name in operators}.get(operator.casefold(), operator)
    return operator + (brackets or (f"({', '.join(words.replace(',', ' ').split())})" if words else ""))


def _list_operator_names(setup: GameSetup) -> list[str]:
    return [*setup.domain.operator_arities, DONE, LOOK, *list_agent_commands_declining_task(setup.task)]


def _list_possible_actions_with_words(game: RecordedGame, words: Sequence[str]) -> Iterator[str]:
    """Yield a line for each operator: its name, and the objects of its possible actions.

    Only actions whose text contains all the given words are listed.
    """
    write = game.setup.commands.write_command
    for operator, actions in groupby(game.find_possible_actions(), key=attrgetter("operator")):
        commands = [write(action).replace(", ", ",") for action in actions]
        chosen = [
            command for command in commands if all(text.casefold() in command.casefold() for text in words)
        ]
        if chosen:
            objects = " ".join([command.partition("(")[2].removesuffix(")") for command in chosen])
            yield f"{operator}: {objects}".rstrip(": ")
