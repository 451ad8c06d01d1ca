"""Options that several commands share: the name of each, its help text and its panel in the help."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.base.entry_points import load_from_extension
from eai.base.errors import InputError, require_extra
from eai.base.store import FOLDER_VARIABLE, DataPackStore
from eai.cli.console import DOMAIN_HELP
from eai.cli.progress import show_data_progress
from eai.pddl.planning import PlannerChoice, PlannerLimits
from eai.results.options import ScoringOptions
from eai.tasks.options import Options
from eai.tasks.source import ErrataChoice, Source, find_errata_choice, find_planner_choice

if TYPE_CHECKING:
    from eai.agents.setting import AgentSetting
    from eai.results.batch import Scoring

ANSWERS, SCORING, OUTPUT = "What is scored", "Scoring", "Output"
"""Titles of the panels of options in the help of commands that score."""

ABILITIES = f"{', '.join(PAPER_ABILITIES)}, or another one by its name"
"""Text that lists the values of ``--ability``, the kinds of questions that a benchmark asks."""

RECORDS = "Files of records, or folders with records.jsonl somewhere below."
"""Help text of arguments that name records."""


def make_flag(*names: str, panel: str | None = None, **more: Any) -> Any:
    """Return an option of a command. Names are given only if they differ from the name of the parameter.

    The option's help text is the argument ``help``, or an entry below ``Options:`` in the docstring of the
    command.
    """
    return typer.Option(*names, rich_help_panel=panel, **more)


OfDomain = Annotated[str, make_flag("--domain", help=DOMAIN_HELP)]
OfAbility = Annotated[Ability, make_flag("--ability", help=f"{ABILITIES}.", parser=Ability.from_name)]
Seed = Annotated[int, make_flag("--seed", help="Of all that is random.")]
Workers = Annotated[
    int | None,
    make_flag(
        "--workers",
        help="Number of processes. Any number writes the same bytes.",
        show_default="1",
        min=1,
    ),
]


def make_ray_flag(panel: str | None = None) -> Any:
    """Return the flag of the address of a Ray cluster (`open_scoring_workers`)."""
    return make_flag(
        "--ray",
        help="Use all cores of a Ray cluster, or --workers of them: auto, HOST:PORT, or local.",
        panel=panel,
        metavar="ADDRESS",
    )


OnRay = Annotated[str | None, make_ray_flag()]


def make_option_flag(options: type[Options], option: str, panel: str, *names: str, **more: Any) -> Any:
    """Return the flag of an option of a run's specification, with its meaning and limits."""
    field = options.model_fields[option]
    for end, name in (("min", "ge"), ("max", "le")):
        more |= {end: getattr(each, name) for each in field.metadata if hasattr(each, name)}  # noqa: B035
    return make_flag(*names, help=options.describe_option(option), panel=panel, **more)


def make_scoring_flag(option: str, *names: str, **more: Any) -> Any:
    """Return the command-line flag of an option of `ScoringOptions`, such as ``--planner``."""
    return make_option_flag(ScoringOptions, option, SCORING, *names, **more)


Planner = Annotated[PlannerChoice, make_scoring_flag("planner", parser=find_planner_choice)]
Errata = Annotated[ErrataChoice, make_scoring_flag("errata", parser=find_errata_choice)]

AsJson = Annotated[
    bool, make_flag("--json", help="Print the results as JSON, and nothing else.", panel=OUTPUT)
]
Wide = Annotated[bool, make_flag("--wide", help="All columns in one table, however wide.", panel=OUTPUT)]


def _set_data_folder(command: typer.Context, folder: Path | None) -> Path | None:
    """Make a folder the default folder of data sets, for this command and the processes that it starts."""
    if folder is not None:
        before = {name: os.environ[name] for name in (FOLDER_VARIABLE,) if name in os.environ}

        def restore_data_folder_variable() -> None:
            del os.environ[FOLDER_VARIABLE]
            os.environ.update(before)

        command.call_on_close(restore_data_folder_variable)
        os.environ[FOLDER_VARIABLE] = str(folder)
    return folder


DataFolder = Annotated[
    Path | None,
    make_flag(
        "--data",
        help="Where the data set is; EAI_DATA_DIR or the user's cache if not given.",
        callback=_set_data_folder,
    ),
]


def open_store(folder: Path | None) -> DataPackStore:
    """Return the data store in a folder, or the default store."""
    return DataPackStore() if folder is None else DataPackStore(folder)


@contextmanager
def open_data_source(
    folder: Path | None,
    planner: PlannerChoice = PlannerChoice.AUTO,
    errata: ErrataChoice = ErrataChoice.CURRENT,
    terms: PlannerLimits | None = None,
) -> Iterator[Source]:
    """Open the data set in a folder or in the default one, with a progress bar for downloads."""
    with show_data_progress() as report:
        yield Source(open_store(folder), report, planner, errata, terms or PlannerLimits())


def make_planner_limits_of_command(
    command: typer.Context, seconds: int | None, memory_mib: int | None
) -> PlannerLimits:
    """Return the time and memory limits of planners that the user chose for a command.

    The limits include a temporary folder, which is removed when the command ends. Lock files in this folder
    limit the number of planners that the processes of the command run at a time.
    """
    folder = command.with_resource(TemporaryDirectory(prefix="eai-planning-"))
    return PlannerLimits(seconds, memory_mib, Path(folder))


def open_scoring_workers(workers: int | None, ray: str | None) -> Scoring:
    """Open the processes that work for a command, on this machine or on a Ray cluster, for a ``with`` block.

    Args:
        workers: number of processes; None for all cores of the cluster, or for one process of this machine.
        ray: address of the cluster; None for this machine.

    Raises:
        InputError: Ray is not installed, or the cluster cannot be used.
    """
    if ray is not None:
        with require_extra("ray", "--ray needs"):
            open_on_cluster: Callable[[str, int | None], Scoring] = load_from_extension(
                "scoring_on_ray", "--ray"
            )
        return open_on_cluster(ray, workers)
    from eai.results.batch import Scoring  # imported late, because few commands need it

    return Scoring(workers or 1)


SETTING = "--with"
"""Flag that sets options without a flag of their own, as in ``--with agent.slip=0.1``."""

Chosen = TypeVar("Chosen", bound=Options)


def apply_settings_to_section(section: str, options: type[Chosen], settings: Sequence[str]) -> Chosen:
    """Return the options of a section, changed by settings NAME=VALUE; NAME may begin with the section.

    Raises:
        InputError: An option or its value is unknown.
    """
    values = dict(map(split_name_and_value, settings))
    return options.read(section, {key.removeprefix(f"{section}."): value for key, value in values.items()})


def split_name_and_value(
    text: str, flag_in_message: str = SETTING, form_in_message: str = "OPTION=VALUE"
) -> tuple[str, str]:
    """Split a flag NAME=VALUE.

    Raises:
        InputError: The text has another form.
    """
    key, separator, value = text.partition("=")
    if not separator:
        raise InputError(f"{flag_in_message} {text}: expected {form_in_message}")
    return key, value


AgentSettings = Annotated[
    list[str] | None, make_flag(SETTING, help="An option of agent, as in eai run.", metavar="OPTION=VALUE")
]


def parse_external_agent_setting(settings: Sequence[str]) -> AgentSetting:
    """Return the options of episodes in which a person or another program chooses the actions.

    Raises:
        InputError: The settings contain an option that applies only to models of ``eai run``.
    """
    from eai.agents.setting import (  # imported late, because commands that score do not need it
        AGENT_SETTING_FIELD,
        AgentSetting,
    )

    chosen = apply_settings_to_section(AGENT_SETTING_FIELD, AgentSetting, settings)
    for name in sorted(chosen.model_fields_set & {"harness", "tokens", "seconds"}):
        raise InputError(f"{SETTING} {name}: this option is only for models that eai run asks; leave it out")
    return chosen


def format_option_rows(options: type[Options], name_prefix: str = "") -> Iterator[str]:
    """Return rows of options for a table in Markdown: name, default, meaning."""
    for name in options.model_fields:
        default = options.format_default(name)
        yield f"| `{name_prefix}{name}` | {default and f'`{default}`'} | {options.describe_option(name)} |"


def split_names(text: str | None) -> list[str]:
    """Return the names in an option, separated by commas."""
    return [name.strip() for name in (text or "").split(",") if name.strip()]
