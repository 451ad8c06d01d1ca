"""Train a small transformer from nothing on a CPU: on certificates first, then by rewards (GRPO).

    pip install '.[run,analysis,plots]' 'trl==1.16.0' 'transformers==5.24.0' datasets torch
    python examples/training/small_transformer.py --out runs/small

`eai generate` makes tasks of BEHAVIOR: `train`, and `test` with goals that no training task has. A prompt has
facts and goals alone (`--set facts`). For each seed, a new model learns plans from certificates. Then
each arm continues with a copy of it: `rewards` learns from the rewards of its own plans, `certificates` goes
on with certificates for about the same processor time, and `shuffled` learns from rewards that are dealt out
anew among the plans of a batch.

OUT/log.jsonl has a line for each measurement, OUT/plans.jsonl the measured plans.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import statistics
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

os.environ.setdefault("HF_HUB_OFFLINE", "1")

import numpy as np
import torch
from datasets import Dataset, load_dataset
from datasets.utils.logging import disable_progress_bar
from matplotlib.figure import Figure
from scipy.stats import t
from tokenizers import Regex, Tokenizer, decoders, models, pre_tokenizers, trainers
from transformers import (
    LlamaConfig,
    LlamaForCausalLM,
    PreTrainedTokenizerFast,
    PrinterCallback,
    Trainer,
    TrainerCallback,
)
from transformers.utils.logging import set_verbosity_error
from trl import GRPOConfig, GRPOTrainer, SFTConfig, SFTTrainer

from eai.agents.rewards import TrlReward

TOKENS = (
    r" \[[^]\n]+\][^\n]*\n"  # kind and properties of an object
    r'|\[\{"action": "|"\}, \{"action": "|", "object": "|"\}\]'  # what all plans have
    r"|\n\n\w+:\n|[A-Za-z_]+_\d+|[A-Za-z]+(?:_[A-Za-z]+)*(?:\.n\.\d+| ?\()?(?:\*[^\w\n]*)?|\d+|[^\w\n]+|\n+|."
)
"""Pattern of a token. The name of an object is one token, since models copy one token sooner than several."""

CHAT_TEMPLATE = (
    "{% for message in messages %}{{ message.content }}"
    "{{ '\\nPlan:\\n' if message.role == 'user' else eos_token }}{% endfor %}"
)

MAX_PLAN_TOKENS = 60

GENERATOR_SEEDS = {"train": 1, "test": 2}

GROUP_SIZE = 8
"""Number of plans for one task that are compared with each other."""

ARMS = ("rewards", "certificates", "shuffled")

LABELS = {
    "start": "certificates",
    "rewards": "then rewards (GRPO)",
    "certificates": "then certificates again",
    "shuffled": "then shuffled rewards",
}
"""Names of the first part of the training and of the arms in the figure and the table."""


class Rewards:
    """Pays each plan that reaches all goals.

    Args:
        seed: Seed of the order in which shuffled rewards are dealt out. None does not shuffle them.
    """

    __name__ = "success"

    def __init__(self, seed: int | None = None) -> None:
        self._reward = TrlReward("success")
        self._order = None if seed is None else random.Random(seed)
        self.means: list[float] = []

    def __call__(self, completions: list[Any], task: list[str], **others: Any) -> list[float]:
        """Return the reward of each plan, and remember their mean before they are shuffled."""
        rewards = [reward or 0.0 for reward in self._reward(completions=completions, task=task)]
        self.means.append(statistics.fmean(rewards))
        if self._order is not None:
            self._order.shuffle(rewards)
        return rewards


@dataclass
class Log:
    """Writes measurements of a seed, and measures the processor time that learning takes.

    Attributes:
        measuring: Processor seconds that measurements took. They are left out of the time for learning.
    """

    folder: Path
    seed: int
    test: Dataset
    tokenizer: PreTrainedTokenizerFast
    measuring: float = 0.0

    def measure(self, model: LlamaForCausalLM, arm: str, seconds: float, **numbers: float) -> None:
        """Write what share of the test tasks the most probable plans solve, and how many can be read."""
        begun = time.process_time()
        plans = write_plans(model, self.tokenizer, self.test["prompt"])
        sums: dict[str, float] = {}
        rewards = TrlReward("success")(
            completions=plans, task=self.test["task"], log_metric=lambda name, mean: sums.update({name: mean})
        )
        line = {
            "seed": self.seed,
            "arm": arm,
            "seconds": round(seconds),
            "solved": sums["eai/success"],
            "readable": 1 - sums["eai/fault.parsing"],
            **numbers,
        }
        append_lines(self.folder / "log.jsonl", [line])
        named = {"seed": self.seed, "arm": arm, "seconds": round(seconds)}
        rows = zip(self.test["task"], plans, rewards, strict=True)
        append_lines(
            self.folder / "plans.jsonl",
            [{**named, "task": task, "plan": plan, "reward": reward} for task, plan, reward in rows],
        )
        print(json.dumps(line), flush=True)
        self.measuring += time.process_time() - begun


@dataclass
class Clock(TrainerCallback):
    """Measures the model after every few changes of the weights, with the processor time that they took.

    Attributes:
        every: Number of changes between two measurements.
        begun_at: Processor seconds of learning before this part of the training.
    """

    log: Log
    arm: str
    every: int
    begun_at: float = 0.0
    rewards: Rewards | None = None
    started: float = field(init=False)

    def on_train_begin(self, *arguments: Any, **others: Any) -> None:
        """Start the clock."""
        self.started = time.process_time() - self.log.measuring

    def on_step_end(self, arguments: Any, state: Any, control: Any, model: Any = None, **others: Any) -> None:
        """Measure if it is time, and after the last change."""
        if state.global_step % self.every and state.global_step < state.max_steps:
            return
        spent = time.process_time() - self.log.measuring - self.started
        numbers = {"steps": state.global_step}
        if self.rewards is not None:
            numbers["reward"] = statistics.fmean(self.rewards.means)
            self.rewards.means.clear()
        self.log.measure(model, self.arm, self.begun_at + spent, **numbers)


def append_lines(file: Path, lines: Sequence[dict[str, Any]]) -> None:
    """Append values to a file of JSON Lines."""
    with file.open("a", encoding="utf-8") as stream:
        stream.writelines(json.dumps(line) + "\n" for line in lines)


def run_eai(*arguments: object) -> None:
    """Run a command of eai in this environment."""
    subprocess.run([sys.executable, "-m", "eai", *map(str, arguments)], check=True)


def make_rows(folder: Path, split: str, number: int) -> Dataset:
    """Return the rows of a split: prompt, plan of the certificate and name of each task. Generate it once."""
    tasks, rows = folder / f"{split}.jsonl", folder / "gold" / f"{split}.jsonl"
    if not rows.exists():
        run_eai(
            *("generate", "--like", "behavior", "--tier", "S", "--objects", 10),
            *("--n", number, "--split", split, "--seed", GENERATOR_SEEDS[split], "--out", folder),
        )
        suite = ("--domain", tasks, "--ability", "action_sequencing")
        run_eai("run", *suite, "--set", "facts", "--model", "eai/oracle", "--out", folder / "gold" / split)
        run_eai("export", "sft", folder / "gold" / split, "--domain", tasks, "--set", "facts", "--out", rows)
    return load_dataset("json", data_files=str(rows), split="train").select_columns(
        ["prompt", "completion", "task"]
    )


def make_tokenizer(rows: Dataset) -> PreTrainedTokenizerFast:
    """Return a tokenizer with the tokens of prompts and plans."""
    tokenizer = Tokenizer(models.WordLevel(unk_token="<unknown>"))
    tokenizer.pre_tokenizer = pre_tokenizers.Split(Regex(TOKENS), "isolated")
    tokenizer.decoder = decoders.Fuse()
    texts = [row[column][0]["content"] + "\nPlan:\n" for row in rows for column in ("prompt", "completion")]
    special = ["<pad>", "<end>", "<unknown>"]
    tokenizer.train_from_iterator(texts, trainers.WordLevelTrainer(special_tokens=special))
    return PreTrainedTokenizerFast(
        tokenizer_object=tokenizer,
        pad_token="<pad>",
        eos_token="<end>",
        unk_token="<unknown>",
        padding_side="left",
        chat_template=CHAT_TEMPLATE,
        model_input_names=["input_ids", "attention_mask"],
    )


def make_model(tokenizer: PreTrainedTokenizerFast) -> LlamaForCausalLM:
    """Return a model with random weights."""
    return LlamaForCausalLM(
        LlamaConfig(
            vocab_size=len(tokenizer),
            hidden_size=128,
            intermediate_size=512,
            num_hidden_layers=4,
            num_attention_heads=4,
            num_key_value_heads=4,
            max_position_embeddings=512,
            pad_token_id=tokenizer.pad_token_id,
            bos_token_id=None,
            eos_token_id=tokenizer.eos_token_id,
            tie_word_embeddings=True,
        )
    )


@torch.no_grad()
def write_plans(
    model: LlamaForCausalLM, tokenizer: PreTrainedTokenizerFast, prompts: Sequence[Any]
) -> list[str]:
    """Return the model's most probable plan, token by token, for each prompt."""
    model.eval()
    plans: list[str] = []
    for start in range(0, len(prompts), 100):
        inputs = tokenizer.apply_chat_template(
            list(prompts[start : start + 100]), padding=True, return_tensors="pt", return_dict=True
        )
        written = model.generate(**inputs, max_new_tokens=MAX_PLAN_TOKENS, do_sample=False)
        plans += tokenizer.batch_decode(written[:, inputs["input_ids"].shape[1] :], skip_special_tokens=True)
    model.train()
    return plans


def learn(trainer: Trainer, clock: Clock) -> None:
    """Train, and measure on the way."""
    trainer.remove_callback(PrinterCallback)
    trainer.add_callback(clock)
    trainer.train()


COMMON = {
    "report_to": "none",
    "save_strategy": "no",
    "logging_strategy": "no",
    "disable_tqdm": True,
    "use_cpu": True,
    "bf16": False,
    "gradient_checkpointing": False,
    "lr_scheduler_type": "constant_with_warmup",
}


def learn_from_certificates(
    model: LlamaForCausalLM, rows: Dataset, rate: float, steps: int, batch: int, clock: Clock
) -> None:
    """Train on prompts with the plans of certificates."""
    settings = SFTConfig(
        max_steps=steps,
        output_dir=str(clock.log.folder / "trainer"),
        per_device_train_batch_size=batch // 4,
        learning_rate=rate,
        warmup_steps=100,
        adam_beta2=0.98,
        weight_decay=0.05,
        completion_only_loss=False,
        train_sampling_strategy="group_by_length",
        seed=clock.log.seed,
        **COMMON,
    )
    learn(SFTTrainer(model, settings, train_dataset=rows, processing_class=clock.log.tokenizer), clock)


def learn_from_rewards(
    model: LlamaForCausalLM, rows: Dataset, rate: float, steps: int, batch: int, clock: Clock
) -> None:
    """Train on the model's own plans for prompts, by their rewards (GRPO)."""
    settings = GRPOConfig(
        max_steps=steps,
        output_dir=str(clock.log.folder / "trainer"),
        per_device_train_batch_size=batch,
        num_generations=GROUP_SIZE,
        max_completion_length=MAX_PLAN_TOKENS,
        learning_rate=rate,
        warmup_steps=5,
        beta=0.0,
        seed=clock.log.seed,
        **COMMON,
    )
    prompts = rows.select_columns(["prompt", "task"])
    learn(GRPOTrainer(model, clock.rewards, settings, prompts, processing_class=clock.log.tokenizer), clock)


def train_seed(
    folder: Path, seed: int, rows: Dataset, test: Dataset, steps: tuple[int, int, int], batch: int
) -> None:
    """Train the model of a seed, then a copy of it in each arm, but what an earlier run has trained.

    Args:
        folder: Folder of the log and the models.
        seed: Seed of the weights, the batches and the sampled plans.
        rows: Tasks to learn from.
        test: Tasks to measure on.
        steps: Changes of the weights: by certificates at first, by rewards, and by certificates again.
        batch: Number of plans for a change of the weights by rewards; a quarter of it by certificates.
    """
    torch.manual_seed(seed)
    tokenizer = make_tokenizer(rows)
    log = Log(folder, seed, test, tokenizer)
    model, start = make_model(tokenizer), folder / f"start-{seed}"
    first, by_rewards, again = steps
    if not start.exists():
        log.measure(model, "start", 0, steps=0)
        learn_from_certificates(model, rows, 2e-3, first, batch, Clock(log, "start", max(1, first // 4)))
        model.save_pretrained(start)
        tokenizer.save_pretrained(start)
    begun_at = max(
        line["seconds"]
        for line in read_lines(folder / "log.jsonl")
        if line["seed"] == seed and line["arm"] == "start"
    )
    for arm in ARMS:
        if (folder / f"{arm}-{seed}").exists():
            continue
        model = LlamaForCausalLM.from_pretrained(start)
        if arm == "certificates":
            learn_from_certificates(
                model, rows, 1e-3, again, batch, Clock(log, arm, max(1, again // 6), begun_at)
            )
        else:
            rewards = Rewards(seed if arm == "shuffled" else None)
            clock = Clock(log, arm, max(1, by_rewards // 6), begun_at, rewards)
            learn_from_rewards(model, rows, 3e-4, by_rewards, batch, clock)
        model.save_pretrained(folder / f"{arm}-{seed}")


def read_lines(file: Path) -> list[dict[str, Any]]:
    """Return the values of a file of JSON Lines."""
    return [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]


def read_curves(log: Path) -> dict[str, list[list[dict[str, Any]]]]:
    """Return the measurements of each arm, a list for each seed. Those of an arm begin where it parted."""
    curves: dict[str, dict[int, list[dict[str, Any]]]] = {arm: {} for arm in LABELS}
    for line in read_lines(log):
        curves[line["arm"]].setdefault(line["seed"], []).append(line)
    for arm in ARMS:
        for seed, curve in curves[arm].items():
            curve.insert(0, curves["start"][seed][-1])
    return {arm: list(by_seed.values()) for arm, by_seed in curves.items()}


def summarize(log: Path) -> None:
    """Print a Markdown table of the last measurements: means of all seeds, with 95 % t-intervals."""
    print("| model | test tasks solved | plans that can be read | mean reward in training |")
    print("|---|--:|--:|--:|")
    for arm, curves in read_curves(log).items():
        ends = [curve[-1] for curve in curves]
        columns = [[100 * end[key] for end in ends if key in end] for key in ("solved", "readable", "reward")]
        print(f"| {LABELS[arm]} | " + " | ".join(map(describe_mean, columns)) + " |")


def describe_mean(percentages: Sequence[float]) -> str:
    """Return a mean over seeds as text, with half the width of its 95 % t-interval."""
    if len(percentages) < 2:
        return " ".join([f"{value:.1f} %" for value in percentages])
    half = t.ppf(0.975, len(percentages) - 1) * statistics.stdev(percentages) / len(percentages) ** 0.5
    return f"{statistics.fmean(percentages):.1f} ± {half:.1f} %"


def print_plans(folder: Path) -> None:
    """Print three plans of seed 0 for the first test task that only learning from rewards solves."""
    plans: dict[str, list[dict[str, Any]]] = {}
    for line in read_lines(folder / "plans.jsonl"):
        if line["seed"] == 0 and line["arm"] in ("start", "rewards"):
            plans.setdefault(line["task"], []).append(line)
    for task, lines in plans.items():
        start = [line for line in lines if line["arm"] == "start"]
        shown = [start[1], start[-1], lines[-1]]
        if [line["reward"] for line in shown] == [0, 0, 1]:
            print(task)
            for line in shown:
                print(f"  {line['arm']}, {line['seconds'] / 60:.0f} min: {line['plan']}")
            return


def draw(log: Path, file: Path) -> None:
    """Draw the share of test tasks solved against processor time: each seed, and their mean."""
    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.subplots()
    for color, (arm, curves) in zip(("0.35", "C0", "C1", "C3"), read_curves(log).items(), strict=True):
        points = [[(line["seconds"] / 60, 100 * line["solved"]) for line in curve] for curve in curves]
        for curve in points:
            axes.plot(*zip(*curve, strict=True), color=color, linewidth=0.8, alpha=0.4)
        if points:
            means = np.mean(list(zip(*points, strict=False)), axis=1)
            axes.plot(*means.T, color=color, linewidth=2, marker="o", markersize=3, label=LABELS[arm])
    axes.set_xlabel("processor time of learning, minutes")
    axes.set_ylabel("test tasks solved, %")
    axes.set_ylim(0, None)
    axes.legend(frameon=False)
    figure.savefig(file)


def main() -> None:
    """Train all seeds, and draw what the log says."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--out", type=Path, default=Path("runs/small"), help="folder for tasks, log and models"
    )
    parser.add_argument("--seeds", type=int, nargs="+", default=(0, 1, 2), metavar="SEED")
    parser.add_argument("--tasks", type=int, nargs=2, default=(4000, 300), metavar=("TRAIN", "TEST"))
    parser.add_argument(
        "--steps",
        type=int,
        nargs=3,
        default=(1500, 264, 2304),
        metavar=("FIRST", "REWARDS", "AGAIN"),
        help="changes of the weights by certificates, then by rewards, or by certificates again",
    )
    parser.add_argument("--batch", type=int, default=128, help="plans for each change of the weights")
    parser.add_argument("--threads", type=int, default=1, help="threads of PyTorch")
    options = parser.parse_args()
    disable_progress_bar()
    set_verbosity_error()
    torch.set_num_threads(options.threads)
    rows, test = (
        make_rows(options.out, split, number)
        for split, number in zip(("train", "test"), options.tasks, strict=True)
    )
    for seed in options.seeds:
        train_seed(options.out, seed, rows, test, tuple(options.steps), options.batch)
    summarize(options.out / "log.jsonl")
    print_plans(options.out)
    draw(options.out / "log.jsonl", options.out / "curve.svg")


if __name__ == "__main__":
    main()
