"""Train a language model with TRL on generated tasks (GRPO). This needs a GPU, so no test runs it.

    pip install . 'trl==1.16.0' 'datasets' 'torch'
    eai generate --like virtualhome --tier S --n 2000 --split train --out tasks/
    eai generate --like virtualhome --tier S --n 200 --split test --out tasks/
    eai export prompts --domain tasks/ --ability action_sequencing --format hf --out prompts
    python examples/training/trl_grpo.py

To measure the result on tasks that it has not learned from, serve the model and run
`eai run --domain tasks/test.jsonl`.
"""

from __future__ import annotations

from datasets import load_dataset
from trl import GRPOConfig, GRPOTrainer

from eai.agents.rewards import TrlReward


def main() -> None:
    """Train on the split ``train``."""
    trainer = GRPOTrainer(
        model="Qwen/Qwen3-0.6B",
        reward_funcs=TrlReward("progress"),
        train_dataset=load_dataset("prompts", split="train"),
        args=GRPOConfig(output_dir="runs/grpo", num_generations=8, max_completion_length=1024, seed=0),
    )
    trainer.train()


if __name__ == "__main__":
    main()
