"""Measure world-model questions per CPU second, the balance of their answers, and shortcuts.

A thousand questions of all kinds are written first, so that no measured kind includes opening the tasks.

    python -m bench questions [--domain D ...] [--n N]
"""

from __future__ import annotations

import argparse
import time

from eai.benchmarks.registry import PAPER_BENCHMARKS, find_benchmark
from eai.extensions.questions.question import QuestionForm, QuestionKind
from eai.extensions.questions.shortcuts import (
    compute_answer_entropy,
    compute_guess_probabilities,
    compute_success_rates_of_shortcuts,
    find_best_shortcut,
)
from eai.extensions.questions.writer import QuestionGenerator

WARM = 1_000


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--domain", nargs="+", default=list(PAPER_BENCHMARKS))
    parser.add_argument("--n", type=int, default=300)
    arguments = parser.parse_args()
    for domain in arguments.domain:
        writer = QuestionGenerator(find_benchmark(domain))
        list(writer.write_questions(number=WARM))
        for kind in QuestionKind:
            start = time.process_time()
            questions = list(writer.write_questions([kind], number=arguments.n))
            seconds = time.process_time() - start
            guesses = compute_guess_probabilities(questions)
            chances = [
                compute_success_rates_of_shortcuts(
                    [question for question in questions if question.form is form], guesses
                )
                for form in QuestionForm
            ]
            best = [
                f"{each[name].percent:.0f} ({name})"
                for each in chances
                for name in [find_best_shortcut(each)]
            ]
            even = [compute_answer_entropy(questions, kind, form) or 0.0 for form in QuestionForm]
            size = sum(len(question.prompt) for question in questions) / max(1, len(questions))
            print(
                f"{domain} {kind.value}: {len(questions)} questions, {len(questions) / seconds:.0f} a CPU s, "
                f"{size:.0f} characters, entropy {' '.join(f'{each:.2f}' for each in even)}, "
                f"right without knowing the world {', '.join(best)}"
            )
