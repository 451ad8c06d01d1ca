"""Check commit subjects: an imperative verb first, at most 72 characters.

    python tools/commit_subjects.py                 the commits since the rule holds
    python tools/commit_subjects.py HEAD~5..HEAD    the commits of a range

The known verbs are data: tools/commit_verbs.txt. If a good verb is missing there, add it in the same commit.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
VERBS = frozenset((ROOT / "tools" / "commit_verbs.txt").read_text(encoding="utf-8").split())
MAX_CHARACTERS = 72

FIRST_COMMIT = "e3b31bb50260f22088578c1ec2248699dac29c0b"
"""Commits after this one are checked by default."""


def find_faults(subject: str) -> list[str]:
    """Return how a commit subject breaks the rule; empty if it keeps it."""
    words = subject.split()
    faults = [] if words and words[0].lower() in VERBS else ["no imperative verb first"]
    if len(subject) > MAX_CHARACTERS:
        faults.append(f"{len(subject)} characters, at most {MAX_CHARACTERS}")
    return faults


def list_subjects(commits: str) -> list[str]:
    """Return hash and subject of each commit in a range, without merges.

    Raises:
        subprocess.CalledProcessError: The range is unknown, or this is no clone.
    """
    command = ["git", "log", "--no-merges", "--format=%h %s", commits]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()


def has_commit(commit: str) -> bool:
    """Whether this clone has a commit. Shallow clones and source archives have only some commits."""
    command = ["git", "cat-file", "-e", f"{commit}^{{commit}}"]
    return subprocess.run(command, cwd=ROOT, capture_output=True, check=False).returncode == 0


def main() -> int:
    """Print subjects that break the rule; return 1 if there are any."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("range", nargs="?", help="commits, as git log takes them")
    commits = parser.parse_args().range
    if commits is None:
        if not has_commit(FIRST_COMMIT):
            print("commit subjects: not checked, because this clone lacks the history")
            return 0
        commits = f"{FIRST_COMMIT}..HEAD"
    subjects = list_subjects(commits)
    faulty = [
        f"{line} ({', '.join(faults)})"
        for line in subjects
        if (faults := find_faults(line.partition(" ")[2]))
    ]
    print(
        *faulty, f"{len(subjects) - len(faulty)} of {len(subjects)} commit subjects keep the rule", sep="\n"
    )
    return 1 if faulty else 0


if __name__ == "__main__":
    sys.exit(main())
