from __future__ import annotations

import pytest
from inspect_ai.model import ChatMessageAssistant, ContentReasoning, ContentText, ModelOutput

from eai.run.solver import _ReplyParts, find_reasoning, restore_brace_cut_off_by_stop_sequence, split_reply


@pytest.mark.parametrize(
    ("text", "answer", "reasoning"),
    [
        ('<think>\nhm, {"a": 1}?\n</think>\n\n{"b": 2}', '{"b": 2}', 'hm, {"a": 1}?'),
        ('hm, first the cup\n</think>{"b": 2}', '{"b": 2}', "hm, first the cup"),
        ("<think>a</think>b<think>c</think>d", "bd", "a\n\nc"),
        ('{"b": 2}\n<think>or not', '{"b": 2}', "or not"),
        ("<|channel|>analysis<|message|>hm<|end|><|channel|>final<|message|>{}", "{}", "hm"),
        ("\n<think>and so on and so", "", "and so on and so"),
    ],
)
def test_reasoning_is_separated_from_the_answer(text: str, answer: str, reasoning: str) -> None:
    assert split_reply(text) == _ReplyParts(answer, reasoning, ("reasoning",))


@pytest.mark.parametrize("text", ["", ' {"a": "b"}\n', "I think so", "```json\n{}\n```"])
def test_text_without_reasoning_does_not_change(text: str) -> None:
    assert split_reply(text) == _ReplyParts(text, "", ())


@pytest.mark.parametrize(
    ("text", "completed"),
    [('{"output": ["a"]', '{"output": ["a"]}'), ('{"a": 1}', '{"a": 1}'), ("sorry", "sorry"), ("", "")],
)
def test_the_brace_that_a_stop_sequence_cut_off_is_restored(text: str, completed: str) -> None:
    repairs = ("stop_sequence",) if text != completed else ()
    assert restore_brace_cut_off_by_stop_sequence(_ReplyParts(text, "", ()), ("}",)) == _ReplyParts(
        completed, "", repairs
    )
    assert restore_brace_cut_off_by_stop_sequence(_ReplyParts(text, "", ()), ()) == _ReplyParts(text, "", ())


def test_secret_reasoning_is_replaced_by_its_summary() -> None:
    secret = ContentReasoning(reasoning="gAAAAB", redacted=True)
    told = secret.model_copy(update={"summary": "It looks for the cup."})
    content = [ContentReasoning(reasoning="hm"), secret, told, ContentText(text="GRAB(cup)")]
    output = ModelOutput.from_message(ChatMessageAssistant(content=content))
    assert find_reasoning(output) == ["hm", "", "It looks for the cup."]
    assert find_reasoning(ModelOutput.from_content("m", "GRAB(cup)")) == []
