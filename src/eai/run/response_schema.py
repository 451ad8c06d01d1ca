"""The response schema of a suite: the form of answers, for providers that can enforce one."""

from __future__ import annotations

from inspect_ai.model import ResponseSchema
from inspect_ai.util import JSONSchema

from eai.abilities.protocol import Ability
from eai.benchmarks.benchmark import Benchmark

_TEXT = JSONSchema(type="string")
_DEFAULTS = {
    Ability.GOAL_INTERPRETATION: JSONSchema(type="object"),
    Ability.SUBGOAL_DECOMPOSITION: JSONSchema(
        type="object", properties={"output": JSONSchema(type="array", items=_TEXT)}, required=["output"]
    ),
    Ability.TRANSITION_MODELING: JSONSchema(type="object", properties={"output": _TEXT}, required=["output"]),
}
"""The forms of the default notation; that of plans is a list, and providers can enforce objects only."""


def response_schema(benchmark: Benchmark, ability: Ability) -> ResponseSchema | None:
    """The form of an answer, or None where it is not an object, which is all that providers can enforce."""
    own = benchmark.response_schemas.get(ability)
    schema = _DEFAULTS.get(ability) if own is None else JSONSchema.model_validate(own)
    return None if schema is None else ResponseSchema(name=ability.value, json_schema=schema)
