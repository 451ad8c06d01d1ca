"""Compare the cost of `strict` and `eai-1.0.5` in subgoal decomposition.

Under `strict` a small search carries out a subgoal; under `eai-1.0.5` the tables of the reference package do.
The ratio of processor time per answer is the cost of the search. Scorers are made beforehand. Each answer is
scored once, and one scorer scores all models' answers to a task. Then an answer is scored that is slow under
`strict` by design: sixteen subgoals, each an action on any object.

    python -m bench strict_subgoals [--every 4]
"""

from __future__ import annotations

import argparse
import json
import time

from bench.record import add_write_option, write_figures
from differential.oracle_answers import OracleAnswer, model_files, oracle_answers, require_oracle
from eai.abilities.protocol import Ability, Protocol
from eai.benchmarks.suite import open_suite
from eai.results.collector import reduce_garbage_collection

LONG = OracleAnswer(
    "27_2",
    json.dumps(
        {
            "necessity_to_use_action": "yes",
            "actions_to_include": ["GRAB", "OPEN"],
            "output": ["exists x. (GRAB(x))", "exists x. (OPEN(x))"] * 8,
        }
    ),
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--every", type=int, default=1, help="score one answer of so many")
    add_write_option(parser)
    arguments, slowest = parser.parse_args(), {}
    require_oracle()
    for domain in ("virtualhome", "behavior"):
        files = model_files(f"{domain}/{Ability.SUBGOAL_DECOMPOSITION.value}")
        answers = [answer for file in files for answer in oracle_answers(file)][:: arguments.every]
        costs = {protocol: _measure_costs(domain, protocol, answers) for protocol in Protocol.list_names()}
        means = {protocol: sum(each) / len(each) for protocol, each in costs.items()}
        print(f"{domain}, {len(answers)} answers, ms of processor time each")
        for protocol, each in costs.items():
            median, late = each[len(each) // 2], each[len(each) * 99 // 100]
            print(
                f"  {protocol.value:10} mean {means[protocol]:6.2f}   median {median:6.2f}   "
                f"99th percentile {late:7.2f}   most {each[-1]:7.2f}"
            )
        print(f"  ratio of the means {means[Protocol.STRICT] / means[Protocol('eai-1.0.5')]:.1f}")
        strict = costs[Protocol.STRICT]
        slowest[domain] = f"{strict[-1] / 1000:.2g} s ({means[Protocol.STRICT]:.1f} ms)"
        share = sum(cost > 50 for cost in costs[Protocol.STRICT]) / len(answers)
        print(f"  {share:.2%} cost more than 50 ms under strict")
    (cost,) = _measure_costs("virtualhome", Protocol.STRICT, [LONG])
    print(f"virtualhome, an answer made to take long: {cost:,.0f} ms")
    if arguments.write:
        write_figures(
            "strict_subgoals",
            {
                "Slowest subgoals of nine models (mean), VirtualHome": slowest["virtualhome"],
                "Slowest subgoals of nine models (mean), BEHAVIOR": slowest["behavior"],
                "Sixteen subgoals that are made to take long": f"{cost / 1000:.2g} s",
            },
        )


def _measure_costs(domain: str, protocol: Protocol, answers: list[OracleAnswer]) -> list[float]:
    """Return the processor time of each answer in ms, ascending."""
    suite = open_suite(domain, Ability.SUBGOAL_DECOMPOSITION, protocol)
    suite = suite.choose_suite_for_answers([answer.text for answer in answers])
    costs = []
    reduce_garbage_collection()
    for answer in answers:
        scorer = suite.scorer(answer.task_id)
        start = time.process_time()
        scorer.score(answer.text)
        costs.append((time.process_time() - start) * 1000)
    return sorted(costs)
