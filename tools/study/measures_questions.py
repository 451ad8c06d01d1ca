"""Measures of statements about the questions to the models, their number and the models' names."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from statistics import fmean

from claim import Finding, by_degree
from evidence import NAMED, B, Evidence, Suite, V
from measures_rates import OPEN_WEIGHT
from rates import all_of, if_so, most_of

from eai.abilities.protocol import PAPER_ABILITIES, Ability, Protocol
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.results.model_cards import make_model_table
from eai.results.paper_tables import map_files_to_paper_models
from eai.tasks.prompts.prompt import BelievedTask, Prompt

PLANNING = (Ability.SUBGOAL_DECOMPOSITION, Ability.ACTION_SEQUENCING)
PRINTED_TOKENS, PRINTED_QUERIES, PRINTED_RUNS = 192_280_000, 84_960, 180
CHARACTERS_PER_TOKEN = 4
"""The usual rule of thumb for English text."""

_SELF = re.compile(r"\(same_obj [^)]*\)")
"""Facts such as (same_obj bowl bowl), which BEHAVIOR's problems have and its questions lack."""

_SCENE = re.compile(r"_0_([A-Z]\w*?_\d_(?:int|garden))_")
"""The scene in a name of a task of BEHAVIOR."""

_DATE = re.compile(r"(20\d\d)-?(\d\d)-?(\d\d)$")
"""A date at the end of a model's id."""

BATHROOM = (
    ("RIGHT_GRASP", "rag_0"),
    ("RIGHT_PLACE_INSIDE", "sink_7"),
    ("TOGGLE_ON", "sink_7"),
    ("SOAK", "rag_0"),
    ("TOGGLE_OFF", "sink_7"),
    ("LEFT_GRASP", "rag_0"),
    ("CLEAN", "sink_7"),
    ("CLEAN", "bathtub_4"),
    ("LEFT_PLACE_INSIDE", "bucket_0"),
)
"""The plan of the paper's printed question, after its first step, which opens a cabinet."""

BEGINNING = 40
"""Number of characters of an instruction that are looked for in a question."""


def parts_of_questions(evidence: Evidence) -> Finding:
    """Look for instructions, the first part, because published questions name the other parts."""
    counts = {}
    for domain, ability, questions in _questions(evidence):
        tasks = find_benchmark(domain).tasks(evidence.published)
        hits = sum(tasks[task].instruction[:BEGINNING] in text for task, text in questions.items())
        counts[f"{NAMED[domain]}, {ability.value.replace('_', ' ')}"] = hits, len(questions)
    text = ", ".join(f"{name} {hits} of {number}" for name, (hits, number) in counts.items())
    return all_of(*counts.values(), text=f"questions with the beginning of the task's instruction: {text}")


def names_in_questions(evidence: Evidence) -> Finding:
    """Look for the names of tasks, by letters alone, because questions write names in several ways."""
    counts = {}
    for domain, ability, questions in _questions(evidence, system=True):
        tasks = find_benchmark(domain).tasks(evidence.published)
        hits = sum(_letters(tasks[task].title) in _letters(text) for task, text in questions.items())
        counts[f"{NAMED[domain]}, {ability.value.replace('_', ' ')}"] = hits, len(questions)
    text = ", ".join(f"{name} {hits} of {number}" for name, (hits, number) in counts.items())
    return all_of(*counts.values(), text=f"questions with the name of the task: {text}")


def rooms_of_scenes(evidence: Evidence) -> Finding:
    """Count the rooms of each scene that questions name, VirtualHome's by category, BEHAVIOR's by floors."""
    counts, text = [], []
    for domain, ability, pattern in (
        (V, Ability.SUBGOAL_DECOMPOSITION, r"\| (\w+)\.\d+ \| Rooms \|"),
        (B, Ability.ACTION_SEQUENCING, r"room_floor_(\w+?)_\d+"),
    ):
        prompts = find_benchmark(domain).official_prompts(ability, evidence.published) or {}
        rooms: dict[str, set[str]] = {}
        for task, prompt in prompts.items():
            scene = _SCENE.search(task)
            own = re.split("Your task:|# Target Task", prompt.user)[-1]
            rooms.setdefault(scene[1] if scene else "", set()).update(re.findall(pattern, own))
        several = sum(len(each) > 1 for each in rooms.values())
        counts.append((several, len(rooms)))
        text.append(f"{NAMED[domain]} {several} of {len(rooms)}, {max(map(len, rooms.values()))} at most")
    return all_of(*counts, text=f"scenes of which questions name more than one room: {'; '.join(text)}")


def plans_of_several_actions(evidence: Evidence) -> Finding:
    lengths = [len(task.script) for task in find_benchmark(B).tasks(evidence.published).values()]
    several = sum(length > 1 for length in lengths)
    return most_of(
        (several, len(lengths)),
        text=f"{several} of {len(lengths)} annotated plans of BEHAVIOR have more than one action, "
        f"{fmean(lengths):.1f} on average",
    )


def joined_effects(evidence: Evidence) -> Finding:
    """Count the annotated operators with several effects under one ``and``."""
    counts, text = [], []
    for domain in (V, B):
        library = next(iter(find_benchmark(domain).operator_tasks(evidence.published).values())).domain
        effects = [operator.effect.strip() for operator in library.operators.values()]
        several = sum(effect.startswith("(and") and _parts(effect) > 1 for effect in effects)
        none = sum(not re.search(r"\w", effect.replace("and", "")) for effect in effects)
        counts.append((several, len(effects)))
        text.append(f"{NAMED[domain]} {several} of {len(effects)}, without any {none}")
    return most_of(*counts, text=f"operators with several effects: {'; '.join(text)}")


def agent_stands_at_first(evidence: Evidence) -> Finding:
    """Count VirtualHome's tasks in whose initial state nobody sits or lies."""
    tasks = find_benchmark(V).tasks(evidence.published).values()
    standing = sum(
        not any(fact.predicate in ("SITTING", "LYING") for fact in task.initial.facts()) for task in tasks
    )
    return most_of(
        (standing, len(tasks)),
        text=f"in {standing} of {len(tasks)} VirtualHome tasks nobody sits or lies at first",
    )


def plan_of_the_bathroom(evidence: Evidence) -> Finding:
    """Run the plan of the printed question in the released task, which has no cabinet around the rag."""
    suite = open_suite(B, Ability.ACTION_SEQUENCING, Protocol("eai-1.0.5"), source=evidence.published)
    (task_id,) = (name for name, task in suite.tasks.items() if task.title == "cleaning_bathrooms")
    verdict = suite.score(
        task_id, json.dumps([{"action": action, "object": thing} for action, thing in BATHROOM])
    )
    error = verdict.error
    stop = "runs" if error is None else f"stops at {BATHROOM[error.step or 0][0]}: {error.detail}"
    return if_so(
        bool(verdict.executable),
        f"without its first step, as the rag is in no cabinet there, the plan {stop}",
    )


def _parts(text: str) -> int:
    """Return how many bracketed parts stand directly inside the outer brackets."""
    depth = parts = 0
    for character in text:
        if character == "(":
            parts += depth == 1
        depth += (character == "(") - (character == ")")
    return parts


def operators_asked_for(evidence: Evidence) -> Finding:
    """Count VirtualHome's operators without effect, and those that some question asks for."""
    tasks = find_benchmark(V).operator_tasks(evidence.published)
    operators = next(iter(tasks.values())).domain.operators
    idle = {
        name
        for name, operator in operators.items()
        if not re.search(r"\w", operator.effect.replace("and", ""))
    }
    wanted = {name for task in tasks.values() for name in task.operators}
    return if_so(
        idle <= wanted,
        f"of VirtualHome's {len(operators)} operators {len(idle)} have no effect; questions ask for "
        f"{len(wanted)}, of which {len(idle & wanted) or 'none'} has no effect",
        in_part=bool(idle & wanted),
    )


def gold_in_questions(evidence: Evidence) -> Finding:
    """Compare goals of plans and subgoals by lines, and problems of operators by text without blanks."""
    counts = {}
    for domain, ability, questions in _questions(evidence):
        benchmark = find_benchmark(domain)
        name = f"{NAMED[domain]}, {ability.value.replace('_', ' ')}"
        if ability in PLANNING:
            tasks, section = benchmark.tasks(evidence.published), benchmark.data.goal_sections[ability]
            hits = 0
            for task, text in questions.items():
                other = section.replace_goals_in_question(text, BelievedTask(tasks[task]))
                lacking, own = _lines_lost(other, text), _lines_lost(text, other)
                hits += not lacking if domain == V else own >= len(tasks[task].goals)
            counts[name] = hits, len(questions)
        elif ability is Ability.TRANSITION_MODELING:
            operators = benchmark.operator_tasks(evidence.published)
            hits = sum(
                _squeezed(_SELF.sub("", operators[task].problem_text)) in _squeezed(text)
                for task, text in questions.items()
            )
            counts[name] = hits, len(questions)
    text = ", ".join(f"{name} {hits} of {number}" for name, (hits, number) in counts.items())
    return all_of(*counts.values(), text=f"questions with the data set's own goals or problem: {text}")


def equal_questions(evidence: Evidence) -> Finding:
    """Compare the answers of each model to questions that are the same byte for byte."""
    same, number = Counter[str](), 0
    for domain, ability, questions in _questions(evidence):
        groups: dict[str, list[str]] = {}
        for task, text in questions.items():
            groups.setdefault(text, []).append(task)
        equal = [tasks for tasks in groups.values() if len(tasks) > 1]
        number += len(equal)
        for model, records in evidence.suites[Suite(domain, ability.value)].items():
            answers = {record.task_id: record.response for record in records}
            same[model] += sum(len({answers[task] for task in tasks}) == 1 for tasks in equal)
    order = sorted(same, key=lambda model: (same[model], model))
    text = ", ".join(f"{map_files_to_paper_models()[model]} {same[model]}" for model in order[:3])
    return all_of(
        (sum(hits == number for hits in same.values()), len(same)),
        text=f"shipped questions fall into {number} groups of equal ones; all answers of "
        "a group are equal in "
        f"all groups for {sum(hits == number for hits in same.values())} of {len(same)} models, fewest for "
        f"{text} groups; whether the shipped questions are those that were asked is not known",
    )


def number_of_tokens(evidence: Evidence) -> Finding:
    asked = {
        (domain, ability.value): questions for domain, ability, questions in _questions(evidence, system=True)
    }
    lengths = [
        len(asked[suite.domain, suite.ability].get(record.task_id, "")) + len(record.response)
        for suite, models in evidence.suites.items()
        for records in models.values()
        for record in records
    ]
    total, each = sum(lengths) / CHARACTERS_PER_TOKEN, fmean(lengths) / CHARACTERS_PER_TOKEN
    printed = PRINTED_TOKENS / PRINTED_QUERIES
    return Finding(
        by_degree(abs(total / PRINTED_TOKENS - 1) < 0.25, abs(each / printed - 1) < 0.25),
        f"{len(lengths):,} shipped questions with their answers have about {total / 1e6:.0f} million tokens "
        f"at four characters each, {each:,.0f} a query; the printed figures give {printed:,.0f} a query",
    )


def queries_of_runs(evidence: Evidence) -> Finding:
    tasks = max(len(questions) for _, _, questions in _questions(evidence))
    share = PRINTED_QUERIES / PRINTED_RUNS
    return if_so(
        share <= tasks,
        f"{share:.0f} queries a run by the printed figures; the largest suite has {tasks} tasks",
    )


def relevant_objects(evidence: Evidence) -> Finding:
    """Take the objects that the data set's own plan changes, as the explanation of its steps has them."""
    text, counts = [], []
    for domain in (V, B):
        benchmark, source = find_benchmark(domain), evidence.published
        suite = open_suite(domain, Ability.ACTION_SEQUENCING, Protocol.STRICT, source=source)
        book = open_gold_answers(benchmark, Ability.ACTION_SEQUENCING, source)
        changed = listed = 0
        for task_id in suite.task_ids:
            task = suite.tasks[task_id]
            steps = suite.assess(task_id, book[task_id].text).explain().steps
            words = {word for step in steps for fact in (*step.added, *step.removed) for word in _words(fact)}
            names = [task.scene.objects[index].name for index in task.relevant]
            changed += sum(name in words for name in names)
            listed += len(names)
        counts.append((changed, listed))
        text.append(f"{NAMED[domain]} {changed:,} of {listed:,}")
    return all_of(*counts, text=f"listed objects that the data set's plan changes: {', '.join(text)}")


def ids_on_cards(evidence: Evidence) -> Finding:
    cards = {row[0]: (str(row[2]), str(row[3])) for row in make_model_table().rows}
    others = [
        f"{cards[map_files_to_paper_models()[file]][0]} ({file})"
        for file in evidence.models
        if cards[map_files_to_paper_models()[file]][0] != file.lower()
    ]
    dates = {name: match for name, (text, _) in cards.items() if (match := _DATE.search(text))}
    right = sum("-".join(match.groups()) == cards[name][1] for name, match in dates.items())
    return all_of(
        (len(cards) - len(others), len(cards)),
        (right, len(dates)),
        text=f"{len(cards) - len(others)} of {len(cards)} ids are the names of the files of public answers "
        f"(not {', '.join(others)}); {right} of {len(dates)} dates in ids are the release",
    )


def open_hosts(evidence: Evidence) -> Finding:
    hosts = {str(row[0]): str(row[5]) for row in make_model_table().rows if row[0] in OPEN_WEIGHT}
    hits = sum(host == "TogetherAI" for host in hosts.values())
    text = ", ".join(f"{name} {host}" for name, host in hosts.items())
    return all_of((hits, len(hosts)), text=f"hosts of open models on the paper's cards: {text}")


def _questions(
    evidence: Evidence, *, system: bool = False
) -> Iterator[tuple[str, Ability, Mapping[str, str]]]:
    """Yield the data set's questions of each suite, by task."""
    for domain in (V, B):
        for ability in PAPER_ABILITIES:
            prompts = find_benchmark(domain).official_prompts(ability, evidence.published) or {}
            texts = {task: _text_of(prompt, system) for task, prompt in prompts.items()}
            yield domain, ability, texts


def _text_of(prompt: Prompt, system: bool) -> str:
    return f"{prompt.system or ''}{prompt.user}" if system else prompt.user


def _lines_lost(text: str, other: str) -> int:
    """Return the number of lines of a text that another text lacks."""
    return sum((Counter(text.splitlines()) - Counter([*other.splitlines(), ""])).values())


def _squeezed(text: str) -> str:
    return re.sub(r"\s+", "", text)


def _letters(text: str) -> str:
    return re.sub(r"[^a-z]", "", text.lower())


def _words(fact: str) -> Sequence[str]:
    return re.findall(r"[\w.]+", fact)
