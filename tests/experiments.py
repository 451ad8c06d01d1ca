"""Make experiments of the package's own studies from their options."""

from __future__ import annotations

from typing import Any

from eai.abilities.experiment import Experiment
from eai.abilities.replanning_options import ReplanningOptions
from eai.results.older_records import OLDER_OPTION_FIELDS, read_older_experiment


def experiment(*replanning: Any, **options: Any) -> Experiment:
    """Return an experiment with names such as ``scene="image"``; other options are options of replanning."""
    names = {name: options.pop(name) for name in OLDER_OPTION_FIELDS if name in options}
    return read_older_experiment(names, ReplanningOptions(*replanning, **options))
