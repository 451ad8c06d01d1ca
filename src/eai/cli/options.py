"""Options that several commands have, each with one name, one help text and one panel."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.base.errors import InputError
from eai.base.store import FOLDER_VARIABLE, Store
from eai.cli.console import DOMAIN_HELP
from eai.cli.progress import data_progress
from eai.pddl.planning import PlannerChoice, PlannerTerms
from eai.results.options import ScoringOptions
from eai.tasks.options import Options
from eai.tasks.source import ErrataChoice, Source, errata_choice, planner_choice

if TYPE_CHECKING:
    from eai.agents.setting import Setting

ANSWERS, SCORING, OUTPUT = "What is scored", "Scoring", "Output"
"""The panels of the help of commands that score."""

ABILITIES = f"{', '.join(PAPER_ABILITIES)}, or another one by its name"
"""The values of ``--ability``."""

RECORDS = "Files of records, or folders with records.jsonl somewhere below."
"""The help of an argument that names records."""


def flag(*names: str, panel: str | None = None, **more: Any) -> Any:
    """An option of a command: its names if not its parameter's, and its panel in the help.

    What it means is said by ``help``, or by the docstring of the command (`Options`).
    """
    return typer.Option(*names, rich_help_panel=panel, **more)


OfDomain = Annotated[str, flag("--domain", help=DOMAIN_HELP)]
OfAbility = Annotated[Ability, flag("--ability", help=f"{ABILITIES}.", parser=Ability.from_name)]
Seed = Annotated[int, flag("--seed", help="Of all that is random.")]


def flag_of(options: type[Options], option: str, panel: str, *names: str, **more: Any) -> Any:
    """The flag of an option of a run's specification, with its meaning and its limits."""
    field = options.model_fields[option]
    for end, name in (("min", "ge"), ("max", "le")):
        more |= {end: getattr(each, name) for each in field.metadata if hasattr(each, name)}  # noqa: B035
    return flag(*names, help=options.describe_option(option), panel=panel, **more)


def scoring(option: str, *names: str, **more: Any) -> Any:
    """The flag of an option of scoring."""
    return flag_of(ScoringOptions, option, SCORING, *names, **more)


Planner = Annotated[PlannerChoice, scoring("planner", parser=planner_choice)]
Errata = Annotated[ErrataChoice, scoring("errata", parser=errata_choice)]

AsJson = Annotated[bool, flag("--json", help="Print the results as JSON, and nothing else.", panel=OUTPUT)]
Wide = Annotated[bool, flag("--wide", help="All columns in one table, however wide.", panel=OUTPUT)]


def _data_of(command: typer.Context, folder: Path | None) -> Path | None:
    """The folder, which is the default for all that a command starts: built-in models, Inspect, workers."""
    if folder is not None:
        before = {name: os.environ[name] for name in (FOLDER_VARIABLE,) if name in os.environ}

        def restore() -> None:
            del os.environ[FOLDER_VARIABLE]
            os.environ.update(before)

        command.call_on_close(restore)
        os.environ[FOLDER_VARIABLE] = str(folder)
    return folder


DataFolder = Annotated[
    Path | None,
    flag(
        "--data",
        help="Where the data set is; EAI_DATA_DIR or the user's cache if not given.",
        callback=_data_of,
    ),
]


def store(folder: Path | None) -> Store:
    """The store in a folder, or in the default one."""
    return Store() if folder is None else Store(folder)


@contextmanager
def opened_source(
    folder: Path | None,
    planner: PlannerChoice = PlannerChoice.AUTO,
    errata: ErrataChoice = ErrataChoice.CURRENT,
    terms: PlannerTerms | None = None,
) -> Iterator[Source]:
    """The data set in a folder, or in the default one; a progress bar says what is fetched of it."""
    with data_progress() as report:
        yield Source(store(folder), report, planner, errata, terms or PlannerTerms())


def planner_terms(command: typer.Context, seconds: int | None, memory_mib: int | None) -> PlannerTerms:
    """The terms of planners in a command, whose processes share what they find until it ends."""
    folder = command.with_resource(TemporaryDirectory(prefix="eai-planning-"))
    return PlannerTerms(seconds, memory_mib, Path(folder))


SETTING = "--with"
"""The flag for options that have no flag of their own."""

Chosen = TypeVar("Chosen", bound=Options)


def with_settings(name: str, options: type[Chosen], settings: Sequence[str]) -> Chosen:
    """The options of a section with settings, which may have the name of the section before theirs.

    Raises:
        InputError: there is no such option or value.
    """
    values = dict(map(setting, settings))
    return options.read(name, {key.removeprefix(f"{name}."): value for key, value in values.items()})


def setting(text: str, flag: str = SETTING, form: str = "OPTION=VALUE") -> tuple[str, str]:
    """The name and the value that a flag gives in such a form.

    Raises:
        InputError: it gives none.
    """
    key, separator, value = text.partition("=")
    if not separator:
        raise InputError(f"{flag} {text}: expected {form}")
    return key, value


AgentSettings = Annotated[
    list[str] | None, flag(SETTING, help="An option of agent, as in eai run.", metavar="OPTION=VALUE")
]


def setting_of_others(settings: Sequence[str]) -> Setting:
    """The setting in which somebody acts who is no model that this program asks.

    Raises:
        InputError: an option is one of models alone.
    """
    from eai.agents.setting import AGENT, Setting  # which commands that score do not need

    chosen = with_settings(AGENT, Setting, settings)
    for name in sorted(chosen.model_fields_set & {"harness", "tokens", "seconds"}):
        raise InputError(f"{SETTING} {name}: it is for models of eai run")
    return chosen


def option_rows(options: type[Options], before: str = "") -> Iterator[str]:
    """The rows of options in a table in Markdown: name, value if not given, meaning."""
    for name in options.model_fields:
        default = options.format_default(name)
        yield f"| `{before}{name}` | {default and f'`{default}`'} | {options.describe_option(name)} |"


def listed(text: str | None) -> list[str]:
    """The names that an option gives, separated by commas."""
    return [name.strip() for name in (text or "").split(",") if name.strip()]
