"""Score hostile answers, and print exceptions, unstable verdicts and the cost of the most expensive answers.

    python -m bench fuzz                   2,000 answers to each of the eight suites
    python -m bench fuzz --suite behavior/ --rows 200 --seed 7
    python -m bench fuzz --dearest 10      names ten answers of each suite and protocol
    python -m bench fuzz --suite behavior/subgoal --answer 176

Answers are those of `mutated_answers`. One in four is made worse: cut off, repeated, nested, with quantifiers
around a formula, or with unusual characters. Equal seeds give equal answers. Each answer is scored twice and
explained, under both protocols, with the built-in planner. For each suite and protocol the program prints:

- answers that raise, or whose two verdicts differ;
- a digest of all verdicts, which must not depend on PYTHONHASHSEED;
- the peak memory of the process so far (MB);
- CPU milliseconds of the most expensive of the three calls: median, 99.9th percentile and maximum;
- the most expensive answers, each by its number and its beginning; `--answer` prints a whole answer.

Scorers are made beforehand, and garbage collection skips them, as in a run with many answers. The exit status
is 1 if an answer raises or its verdicts differ.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
import resource
import sys
import time
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from bench.record import add_write_option, get_suite_title, write_rows
from bench.result import Figure
from differential.mutated_answers import maker
from differential.mutations import Dice
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.benchmarks.suite import Suite, open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.codec import verdict_to_record_fields
from eai.results.collector import reduce_garbage_collection
from eai.tasks.source import Source
from protocols import PROTOCOLS

SUITES = tuple(
    f"{domain}/{ability.value}" for domain in ("virtualhome", "behavior") for ability in PAPER_ABILITIES
)
LONGEST = 20_000
"""Maximum number of characters of an answer; a trainer cuts answers off earlier."""
ODD = ("\0", "\u202e", "\ud800", "\U0001f9fd", "}" * 50, '"', "\\u0000", "<think>", "```", "NaN", "1e999")


QUANTIFIERS = (
    "forall {0}. (",
    "exists {0}. (",
    "forn 2. {0}. (",
    "forpairs {0}, {1}. (",
    "fornpairs 2. {0}, {1}. (",
)
_FORMULA = re.compile(r'(?<=")[^"\n]*\([^"\n]*\)(?=")')
_ARGUMENT = re.compile(r"[\w.]+(?=\s*[,)])")


class Row(NamedTuple):
    """A hostile answer to a task. Its number determines it."""

    number: int
    task_id: str
    text: str

    def __str__(self) -> str:
        return f"{self.number}: {self.task_id} {self.text[:60]!r}"


class Cost(NamedTuple):
    """The cost of an answer's most expensive call."""

    milliseconds: float
    row: Row


class Fuzzed(NamedTuple):
    """Results of fuzzing some answers.

    Attributes:
        wrong: Descriptions of failures.
        verdicts: Digest of all verdicts.
        costs: Costs of the answers, ascending.
    """

    wrong: Sequence[str]
    verdicts: str
    costs: Sequence[Cost]

    def at(self, share: float) -> float:
        """Return a quantile of the costs: the given share of the answers costs at most this."""
        return self.costs[min(len(self.costs) - 1, int(share * len(self.costs)))].milliseconds


def worse(dice: Dice, text: str) -> str:
    """Return an answer with one more defect."""
    place = dice.below(len(text) + 1)
    match dice.below(7):
        case 0:
            text = text[:place]
        case 1:
            text = text[:place] + dice.one(ODD) * (1 + dice.below(20)) + text[place:]
        case 2:
            text *= 2 + dice.below(20)
        case 3:
            text = text.replace("(", "(" * (2 + dice.below(40)), 1 + dice.below(5))
        case 4:
            text = _FORMULA.sub(lambda found: quantified(dice, found[0]), text, 1 + dice.below(3))
        case 5:
            text = quantified_pddl(dice, text)
        case _:
            text = text.replace("[", "[" * (2 + dice.below(2_000)), 1)
    return text[:LONGEST]


def quantified(dice: Dice, formula: str) -> str:
    """Return a formula inside up to five quantifiers, with some arguments replaced by their variables."""
    heads: list[str] = []
    names: list[str] = []
    for level in range(1 + dice.below(5)):
        bound = (f"v{level}", f"w{level}")
        quantifier = dice.one(QUANTIFIERS)
        names += bound if "{1}" in quantifier else bound[:1]
        of = [f"{name}{dice.one(('', '', ': sofa', ': rag.n.01', ': light'))}" for name in bound]
        heads.append(quantifier.format(*of))
    body = _ARGUMENT.sub(lambda found: dice.one(names) if dice.chance(0.7) else found[0], formula)
    return (
        "".join(heads) + dice.one(("{}", "{} or not ({})", "not ({})")).format(body, body) + ")" * len(heads)
    )


def quantified_pddl(dice: Dice, text: str) -> str:
    """Return operators in which one condition or effect is inside up to five quantifiers."""
    start = text.find("(and")
    end, depth = start + 1, 1
    while 0 < end < len(text) and depth:
        depth += (text[end] == "(") - (text[end] == ")")
        end += 1
    heads = []
    for level in range(1 + dice.below(5)):
        variables = " ".join(f"?{letter}{level}" for letter in "abcdefgh"[: 1 + dice.below(8)])
        heads.append(f"({dice.one(('forall', 'exists'))} ({variables} - object) ")
    if start < 0:
        return text
    return text[:start] + "".join(heads) + text[start:end] + ")" * len(heads) + text[end:]


def answers(suite: str, task_ids: Sequence[str], numbers: Iterable[int], seed: int) -> list[Row]:
    """Return the hostile answers with these numbers."""
    domain, _, ability = suite.partition("/")
    make, made = maker(domain, Ability(ability)), []
    for number in numbers:
        dice = Dice(f"fuzz {suite} {seed} {number}")
        task_id = dice.one(task_ids)
        text = make(dice, task_id)
        made.append(Row(number, task_id, worse(dice, text) if dice.chance(0.25) else text))
    return made


def fuzz(suite: Suite, rows: Sequence[Row]) -> Fuzzed:
    """Score answers twice, explain them, and return the results."""
    wrong: list[str] = []
    costs: list[Cost] = []
    digest = hashlib.sha256()
    for row in rows:
        scorer, took = suite.scorer(row.task_id), []
        try:
            verdicts = []
            for _ in range(2):
                start = time.process_time()
                verdicts.append(json.dumps(verdict_to_record_fields(scorer.score(row.text))))
                took.append((time.process_time() - start) * 1000)
            start = time.process_time()
            scorer.explain(row.text)
            took.append((time.process_time() - start) * 1000)
        except Exception as error:
            wrong.append(f"{row}: {type(error).__name__}: {error}")
            continue
        costs.append(Cost(max(took), row))
        digest.update(verdicts[0].encode())
        if len(set(verdicts)) > 1:
            wrong.append(f"{row}: two verdicts")
    costs.sort()
    return Fuzzed(wrong, digest.hexdigest()[:12], costs)


def main() -> int:
    """Fuzz the chosen suites."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--suite", default="", help="a part of DOMAIN/ABILITY")
    parser.add_argument("--rows", type=int, default=2_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--dearest", type=int, default=1, help="how many answers to name")
    parser.add_argument("--answer", type=int, help="print the answer of this number, and score none")
    add_write_option(parser)
    arguments = parser.parse_args()
    failed, table = False, []
    for name in [each for each in SUITES if arguments.suite in each]:
        domain, _, ability = name.partition("/")
        cells: list[Figure] = []
        for protocol in PROTOCOLS:
            suite = open_suite(
                domain, Ability(ability), protocol, source=Source(planner=PlannerChoice.BUILT_IN)
            )
            if arguments.answer is not None:
                [row] = answers(name, suite.task_ids, [arguments.answer], arguments.seed)
                print(row.text.encode("utf-8", "backslashreplace").decode())
                break
            rows = answers(name, suite.task_ids, range(arguments.rows), arguments.seed)
            for task_id in suite.task_ids:
                suite.scorer(task_id)
            reduce_garbage_collection()
            fuzzed = fuzz(suite, rows)
            megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
            print(
                f"{name:35} {protocol.value:10} {arguments.rows} answers, {len(fuzzed.wrong)} wrong; "
                f"{fuzzed.verdicts} {megabytes} MB; "
                f"ms {fuzzed.at(0.5):.2f} median, {fuzzed.at(0.999):.0f} p99.9, {fuzzed.at(1):.0f} most"
            )
            cells += [float(f"{fuzzed.at(share):.2g}") for share in (0.999, 1)]
            for milliseconds, row in fuzzed.costs[::-1][: arguments.dearest]:
                print(f"    {milliseconds:6.0f} ms {row}")
            for line in fuzzed.wrong[:5]:
                print("   ", line.encode("ascii", "backslashreplace").decode())
            sys.stdout.flush()
            failed |= bool(fuzzed.wrong)
        else:
            table.append([get_suite_title(domain, ability), *cells, megabytes])
    if arguments.write:
        write_rows("fuzz", table)
    return int(failed)
