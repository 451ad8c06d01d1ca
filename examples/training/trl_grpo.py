"""Train a language model with TRL on generated tasks (GRPO): by whole plans, or action by action.

    pip install . 'trl==1.16.0' 'datasets' 'torch'
    eai generate --like virtualhome --tier S --n 2000 --split train --out tasks/
    eai generate --like virtualhome --tier S --n 200 --split test --out tasks/
    eai export prompts --domain tasks/ --ability action_sequencing --format hf --out prompts
    python examples/training/trl_grpo.py
    python examples/training/trl_grpo.py --acting    one action a turn, by a model that calls tools

Such a model needs a GPU. To measure the result on tasks that it has not learned from, serve the model and run
`eai run --domain tasks/test.jsonl`.
"""

from __future__ import annotations

import argparse

import torch
from datasets import load_dataset
from trl import GRPOConfig, GRPOTrainer

from eai.agents.rewards import TrlEnvironment, TrlReward


def main() -> None:
    """Train on the split ``train``."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--model", default="Qwen/Qwen3-0.6B")
    parser.add_argument("--prompts", default="prompts", help="folder that eai export prompts wrote")
    parser.add_argument("--out", default="runs/grpo")
    parser.add_argument("--acting", action="store_true", help="one action a turn instead of whole plans")
    parser.add_argument("--steps", type=int, default=-1, help="changes of the weights; -1 for three epochs")
    parser.add_argument("--tokens", type=int, default=1024, help="maximum number of tokens of an answer")
    options = parser.parse_args()
    plans, acting = {"reward_funcs": TrlReward("progress")}, {"environment_factory": TrlEnvironment}
    trainer = GRPOTrainer(
        model=options.model,
        train_dataset=load_dataset(options.prompts, split="train"),
        args=GRPOConfig(
            output_dir=options.out,
            num_generations=8,
            max_completion_length=options.tokens,
            max_steps=options.steps,
            seed=0,
            use_cpu=not torch.cuda.is_available(),
        ),
        **(acting if options.acting else plans),
    )
    trainer.train()
    trainer.save_model()
    trainer.save_state()


if __name__ == "__main__":
    main()
