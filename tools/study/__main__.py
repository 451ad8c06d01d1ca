"""Write the study of the paper's statements and claims: `python tools/study [RECORDS...]`.

Without RECORDS the public answers are scored, in about ten minutes, and the page is docs/study.md. Rates come
from `published_eai-1.0.5.json`: run tools/published_scores.py first. RECORDS are folders or files of `eai
score --protocol eai-1.0.5`; then statements and claims are checked with these records.

    python tools/study                           writes docs/study.md
    python tools/study --answers FOLDER          uses the public answers in a folder
    python tools/study --no-planner              leaves out the claims on single operators
    python tools/study --check                   writes nothing; exit status 1 if the page would change
    python tools/study --only Sensitivity        prints the rows with this word (two minutes); writes nothing
    python tools/study scores --out study.md     from other records
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # published_scores
import difficulty
import elsewhere
import errors
import printed
from claim import Claim
from evidence import Evidence
from page import page_of, rows_with
from published_scores import ANSWERS, find_answers

from eai.abilities.protocol import PAPER_ABILITIES, Ability, Protocol
from eai.benchmarks.registry import PAPER_BENCHMARKS
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.batch import NO_ROW, score_run
from eai.results.options import ScoringOptions
from eai.results.paper_tables import map_files_to_paper_models, read_published_scores
from eai.results.runs import read_runs
from eai.tasks.source import Source

PAGE = Path(__file__).resolve().parents[2] / "docs" / "study.md"
CLAIMS: Sequence[Claim] = (*difficulty.CLAIMS, *errors.CLAIMS, *elsewhere.CLAIMS, *printed.CLAIMS)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("records", type=Path, nargs="*")
    parser.add_argument("--answers", type=Path, default=ANSWERS, help="the folder of the public answers")
    parser.add_argument("--out", type=Path, default=PAGE)
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    parser.add_argument("--only", default="", metavar="WORDS", help="print the rows with these words")
    parser.add_argument("--no-planner", action="store_true", help="leave out checks that need a planner")
    chosen = parser.parse_args()
    if chosen.records and chosen.out == PAGE:
        sys.exit("--out is missing: name a file for the page of these records")
    evidence = from_records(chosen.records) if chosen.records else from_answers(chosen.answers)
    if chosen.only:
        print(rows_with(chosen.only, CLAIMS, evidence, planner=not chosen.no_planner))
        return
    text = page_of(CLAIMS, evidence, planner=not chosen.no_planner)
    if chosen.check:
        sys.exit(0 if chosen.out.read_text(encoding="utf-8") == text else f"{chosen.out} is not current")
    chosen.out.write_text(text, encoding="utf-8")


def from_records(paths: Sequence[Path]) -> Evidence:
    """Return evidence from records of one protocol."""
    evidence = Evidence(Source())
    protocols = set()
    for run in read_runs(paths):
        protocols.add(run.key.protocol)
        evidence.add(run.records)
    if len(protocols) > 1:
        sys.exit("the records have several protocols: give records of one protocol")
    return evidence


def from_answers(
    folder: Path = ANSWERS,
    domains: Sequence[str] = PAPER_BENCHMARKS,
    abilities: Sequence[Ability] = PAPER_ABILITIES,
) -> Evidence:
    """Return evidence from the published answers, scored under the paper's protocol.

    No planner runs yet.
    """
    source = Source(planner=PlannerChoice.NONE)
    evidence = Evidence(source, read_published_scores("eai-1.0.5").suites)
    for domain in domains:
        for ability in abilities:
            suite = open_suite(domain, ability, Protocol("eai-1.0.5"), source=source)
            for file in map_files_to_paper_models():
                answers = find_answers(folder / domain / ability.value, file, suite)
                if answers is None:
                    continue
                given = {response.task_id for response in answers.responses}
                missing = {task_id: NO_ROW for task_id in suite.task_ids if task_id not in given}
                evidence.add(score_run(suite, answers, missing, ScoringOptions()))
    return evidence


if __name__ == "__main__":
    main()
