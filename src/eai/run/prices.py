"""Prices of models, from which Inspect computes what answers cost."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import yaml  # type: ignore[import-untyped]
from inspect_ai.model import Model, ModelCost, ModelInfo, get_model_info, set_model_info
from pydantic import TypeAdapter, ValidationError

from eai.abilities.misfit import misfit
from eai.errors import InputError


def read_prices(path: Path) -> Mapping[str, ModelCost]:
    """The prices in a file, by model, in dollars for a million tokens.

    Args:
        path: a YAML or JSON file in the form of Inspect's ``--model-cost-config``.

    Raises:
        InputError: the file cannot be read, or has another form.
    """
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        return TypeAdapter(dict[str, ModelCost]).validate_python(content)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except (UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError(f"{path}: expected YAML or JSON") from error
    except ValidationError as error:
        raise InputError(f"{path}: expected prices of models ({misfit(error, whole='the file')})") from error


def set_price(model: Model, prices: Mapping[str, ModelCost]) -> None:
    """Tell Inspect the price of a model; one that is not among the prices keeps what Inspect knows.

    Inspect's own ``model_cost_config`` refuses every model that is not in its database, such as those of
    local servers.
    """
    names = (str(model), model.canonical_name())
    cost = next((prices[name] for name in names if name in prices), None)
    if cost is not None:
        known = get_model_info(model) or ModelInfo()
        set_model_info(names[0], known.model_copy(update={"cost": cost}))
