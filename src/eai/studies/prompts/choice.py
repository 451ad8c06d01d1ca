"""Make the entry in a run's records that names the prompts which the run used."""

from __future__ import annotations

from eai.abilities.experiment import Experiment, make_study_settings_of_one_option

STUDY = "prompts"
"""Name of this study. Records of a run store the name of the run's prompts under this key."""

_PLACE = 40


def make_experiment_with_prompt_name(prompt_name: str | None) -> Experiment:
    """Return an experiment that records the name of a run's prompts; an empty experiment for no name."""
    if prompt_name is None:
        return Experiment()
    return Experiment(
        {STUDY: make_study_settings_of_one_option("prompt", "prompt_name", prompt_name, _PLACE)}
    )
