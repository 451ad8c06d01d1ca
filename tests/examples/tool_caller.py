"""Save a tiny model that answers each message with the same tool call: `python tool_caller.py FOLDER`."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import torch
import trl
from tokenizers import Regex, Tokenizer, decoders, models, pre_tokenizers, trainers
from transformers import LlamaConfig, LlamaForCausalLM, PreTrainedTokenizerFast


def save_tool_caller(folder: Path) -> None:
    """Save the model and its tokenizer, with the chat template of Qwen3."""
    template = (Path(trl.__file__).parent / "chat_templates" / "qwen3.jinja").read_text()
    answer = '<tool_call>\n{"name": "act", "arguments": {"command": "GO(lamp_1)"}}\n</tool_call>'
    pieces = ("<|im_start|>assistant\n", "<think>\n\n</think>\n\n", answer, "<|im_end|>", "\n")
    tokenizer = Tokenizer(models.WordLevel(unk_token="<unknown>"))
    pattern = "|".join(map(re.escape, pieces))
    tokenizer.pre_tokenizer = pre_tokenizers.Split(Regex(rf"{pattern}|\w+|."), "isolated")
    tokenizer.decoder = decoders.Fuse()
    special = ["<pad>", "<unknown>"]
    tokenizer.train_from_iterator(["".join(pieces)], trainers.WordLevelTrainer(special_tokens=special))
    saved = PreTrainedTokenizerFast(
        tokenizer_object=tokenizer,
        pad_token="<pad>",
        eos_token="<|im_end|>",
        unk_token="<unknown>",
        padding_side="left",
        chat_template=template,
        model_input_names=["input_ids", "attention_mask"],
    )
    torch.manual_seed(0)
    model = LlamaForCausalLM(
        LlamaConfig(
            vocab_size=len(saved),
            hidden_size=16,
            intermediate_size=16,
            num_hidden_layers=1,
            num_attention_heads=1,
            num_key_value_heads=1,
            max_position_embeddings=4096,
            pad_token_id=saved.pad_token_id,
            eos_token_id=saved.eos_token_id,
            bos_token_id=None,
        )
    )
    model.model.layers[0].self_attn.o_proj.weight.requires_grad_(False).zero_()  # it sees one token
    ids = saved("".join(pieces), return_tensors="pt")["input_ids"]
    optimizer = torch.optim.Adam(model.parameters(), lr=0.1)
    for _ in range(50):
        model(input_ids=ids, labels=ids).loss.backward()
        optimizer.step()
        optimizer.zero_grad()
    model.save_pretrained(folder)
    saved.save_pretrained(folder)


if __name__ == "__main__":
    save_tool_caller(Path(sys.argv[1]))
