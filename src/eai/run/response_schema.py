"""The form of answers, for providers that can enforce one."""

from __future__ import annotations

from inspect_ai.model import ResponseSchema
from inspect_ai.util import JSONSchema

from eai.abilities.protocol import Ability, Domain


def response_schema(domain: Domain, ability: Ability) -> ResponseSchema | None:
    """The form of an answer, or None where it is not an object, which is all that providers can enforce."""
    text = JSONSchema(type="string")
    match domain, ability:
        case _, Ability.GOAL_INTERPRETATION:
            schema = JSONSchema(type="object")
        case _, Ability.SUBGOAL_DECOMPOSITION:
            output = {"output": JSONSchema(type="array", items=text)}
            schema = JSONSchema(type="object", properties=output, required=["output"])
        case _, Ability.TRANSITION_MODELING:
            schema = JSONSchema(type="object", properties={"output": text}, required=["output"])
        case Domain.VIRTUALHOME, Ability.ACTION_SEQUENCING:
            arguments = JSONSchema(type="array", items=text)
            schema = JSONSchema(type="object", additionalProperties=arguments)
        case _:
            return None
    return ResponseSchema(name=ability.value, json_schema=schema)
