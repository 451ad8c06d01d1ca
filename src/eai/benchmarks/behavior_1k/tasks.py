"""The activities of BEHAVIOR-1K as tasks, made from the stored data on first use.

The definitions have no instructions in English. Instructions are therefore written from the goals.
"""

from __future__ import annotations

import hashlib
from collections.abc import Container, Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Any, NamedTuple, TypeAlias

import eai.logic.formula as f
from eai.base.errors import InputError
from eai.base.files import parse_toml
from eai.base.store import PackFile
from eai.benchmarks.behavior_1k.kinds import ACTIVITIES, KINDS, PACK, PLANS, RULES, ObjectKinds
from eai.benchmarks.behavior_1k.operators import READING
from eai.benchmarks.behavior_1k.scene import RECIPE, SceneBuilder, make_scene_builder
from eai.benchmarks.packs import open_pack
from eai.tasks.english import NUMBERS, EnglishWords, inflect_sentence, make_predicate_sentences, pluralize
from eai.tasks.source import Source, TaskSet
from eai.tasks.task import Task, goal
from eai.world.action import Action

_EVIDENCE = "evidence.toml"

ObjectKindsWithAbilities: TypeAlias = Container[str]
"""The kinds of objects whose abilities are known, such as ``mug``."""

PhraseOfVariable = Mapping[str, str]
"""Variable of a goal -> the English phrase that replaces it, such as ``every lamp``."""


def _read_packaged_file(name: str) -> bytes:
    return (files("eai.benchmarks.behavior_1k") / name).read_bytes()


def load_exclusion_reasons() -> Mapping[str, str]:
    """Return a mapping from activities that scores leave out to the reason."""
    entries = parse_toml(_read_packaged_file(_EVIDENCE).decode())["left_out"]
    return {name: entry["reason"] for entry in entries for name in entry["activities"]}


def load_activity_subsets() -> Mapping[str, tuple[str, ...]]:
    """Return named subsets of the activities: a mapping from the name of a subset to names of activities."""
    return {
        name: tuple(names)
        for name, names in parse_toml(_read_packaged_file(_EVIDENCE).decode())["subsets"].items()
    }


class DataForAmendedDefinitions(NamedTuple):
    """Data for activities whose definitions differ from those of bddl 3.6.0.

    Attributes:
        kinds: kind of objects that bddl 3.6.0 lacks -> its abilities, in the form of the file `KINDS`.
        plans: activity -> gold plan, in the form of the file `PLANS`.
        left_out: activity that scores leave out -> the reason.
    """

    kinds: Mapping[str, Mapping[str, Any]]
    plans: Mapping[str, str]
    left_out: Mapping[str, str]


def load_scene_builder_and_object_kinds(
    pack: PackFile, definitions: Mapping[str, str], supplement: DataForAmendedDefinitions
) -> tuple[SceneBuilder, ObjectKindsWithAbilities]:
    """Return the function that makes an activity's scene, and the kinds of objects with known abilities."""
    values = pack.read_json(KINDS)
    values = {**values, "kinds": {**values["kinds"], **supplement.kinds}}
    all_definitions = {**split_by_activity(pack.read_member(ACTIVITIES)), **definitions}
    return make_scene_builder(ObjectKinds(values, pack.read_json(RULES)), all_definitions), values["kinds"]


def open_tasks(
    english: EnglishWords,
    source: Source | None = None,
    definitions: Mapping[str, str] | None = None,
    supplement: DataForAmendedDefinitions = DataForAmendedDefinitions({}, {}, {}),  # noqa: B008 - a frozen value
) -> TaskSet[Task]:
    """Return the tasks in alphabetical order; download them first if they are missing.

    The digest of the tasks covers the data, the plans and the reasons for excluding activities. The
    data leave some rules open. This package decides them, and the digest also covers the name of these
    decisions (`READING`).

    Args:
        english: English sentences for predicates.
        source: the source of the data.
        definitions: activity -> definition; by default, the definitions in the data.
        supplement: kinds, plans and reasons for exclusion, for definitions that differ from those in the
            data. If a kind of object is in neither the data nor the supplement, the task is excluded.

    Raises:
        DataError: the tasks cannot be obtained, or the store is damaged.
    """
    pack = open_pack(PACK, source)
    packed = split_by_activity(pack.read_member(ACTIVITIES))
    plans = read_plans()
    excluded = load_exclusion_reasons()
    texts = packed if definitions is None else definitions

    @cache
    def get_scene_builder_and_kinds() -> tuple[SceneBuilder, ObjectKindsWithAbilities]:
        return load_scene_builder_and_object_kinds(pack, texts, supplement)

    def build_task(task_id: str) -> Task:
        make_scene, known_kinds = get_scene_builder_and_kinds()
        activity, initial = make_scene(task_id)
        is_packed = packed.get(task_id) == texts[task_id]
        unknown = [kind for kind in sorted({*activity.synsets.values()}) if kind not in known_kinds]
        left_out = supplement.left_out.get(task_id) or _explain_unknown_kinds(unknown)
        title = task_id.replace("_", " ")
        formulas = tuple(dict.fromkeys(f.get_operands(activity.problem.goal, f.And)))
        indices = range(len(initial.scene.objects))
        nameable = len(indices) - initial.scene.get_category_mask(RECIPE).bit_count()
        return Task(
            id=task_id,
            title=title,
            instruction=_write_instruction(title, formulas, activity.category_by_object, english),
            initial=initial,
            goals=tuple(map(goal, formulas)),
            relevant=tuple(indices[:nameable]),
            script=_read_plan((plans if is_packed else supplement.plans).get(task_id, "")),
            unsolvable=excluded.get(task_id) if is_packed else left_out,
            unnamed=tuple(indices[nameable:]),
        )

    digests = [pack.members[member] for member in (ACTIVITIES, KINDS, RULES)]
    if definitions is not None:
        digests.append(hashlib.sha256(repr(sorted(definitions.items())).encode()).hexdigest())
    if any(supplement):
        digests.append(hashlib.sha256(repr(supplement).encode()).hexdigest())
    digests += [hashlib.sha256(_read_packaged_file(name)).hexdigest() for name in (PLANS, _EVIDENCE)]
    return TaskSet(texts, build_task, hashlib.sha256("".join((*digests, READING)).encode()).hexdigest())


def _explain_unknown_kinds(kinds: Sequence[str]) -> str | None:
    return f"bddl 3.6.0 does not describe {', '.join(kinds)}" if kinds else None


def _read_plan(line: str) -> tuple[Action, ...]:
    """Return the plan in a line such as ``OPERATOR 3 5;...``. The numbers are indices of objects.

    An empty line gives an empty plan.
    """
    steps = [step.split(" ") for step in line.split(";")] if line else []
    return tuple(Action(operator, tuple(map(int, names))) for operator, *names in steps)


def read_plans(file: str = PLANS) -> Mapping[str, str]:
    """Return the gold plans in a packaged file by activity."""
    return split_by_activity(_read_packaged_file(file))


def split_by_activity(content: bytes) -> Mapping[str, str]:
    """Return a mapping from activity to text. Each line of the content is an activity, a tab and the text."""
    return dict(line.split("\t") for line in content.decode().splitlines())


def _get_category_noun(category: str) -> str:
    """Return the English noun of a category: ``apple half`` for ``half__apple``."""
    if category.startswith("half__"):
        return f"{_get_category_noun(category.removeprefix('half__'))} half"
    return category.replace("__", " ").replace("_", " ")


def _write_instruction(
    title: str, goals: Sequence[f.Formula], objects: Mapping[str, str], english: EnglishWords
) -> str:
    """Return an instruction: the title of an activity, and a clause for each goal.

    Args:
        title: the title of the activity.
        goals: the goals of the activity.
        objects: category of each declared object.
        english: English sentences for predicates.
    """
    sentences = _SentenceWriter(objects, english)
    clauses = "; ".join(sentences.write_goal_clause(goal, {}) for goal in goals)
    return f"{title[:1].upper()}{title[1:]}. In the end it shall be so that: {clauses}."


class _SentenceWriter:
    """Writes the goals of one activity as English clauses."""

    def __init__(self, objects: Mapping[str, str], english: EnglishWords) -> None:
        self._objects = objects
        self._categories = list(objects.values())
        self._english = english

    def name_term(self, term: f.Term, names: PhraseOfVariable) -> str:
        """Return words for a variable or object.

        The words are the entry in `names`, or else ``the oven`` for the only oven, or else the name.
        """
        if term.name in names:
            return names[term.name]
        category = self._objects[term.name]
        return f"the {_get_category_noun(category)}" if self._categories.count(category) == 1 else term.name

    def write_goal_clause(self, goal: f.Formula, names: PhraseOfVariable) -> str:
        """Return an English clause, without a full stop, that states a goal.

        Raises:
            InputError: the goal has a temporal operator.
        """
        match goal:
            case f.Atom():
                return self._write_sentence(goal, names)
            case f.Not(f.Atom() as atom):
                return self._write_sentence(atom, names, negated=True)
            case f.Not(f.ForAll(variable, body)):
                return self.write_goal_clause(f.Exists(variable, f.Not(body)), names)
            case f.Not(f.Exists(variable, f.Atom() as atom)):
                return self._write_sentence(
                    atom, {**names, variable.name: f"no {_get_variable_noun(variable)}"}
                )
            case f.Not(operand):
                return f"it is not so that {self.write_goal_clause(operand, names)}"
            case f.And(parts):
                comma = ", and " if any(isinstance(operand, f.Or) for operand in parts) else " and "
                return comma.join(self.write_goal_clause(operand, names) for operand in parts)
            case f.Or(parts):
                return f"either {' or '.join(self.write_goal_clause(operand, names) for operand in parts)}"
            case f.Implies(premise, conclusion):
                condition = self.write_goal_clause(premise, names)
                return f"if {condition} then {self.write_goal_clause(conclusion, names)}"
            case f.ForAll() | f.Exists() | f.Exactly() | f.ForPairs():
                return self._write_quantified(goal, names)
        raise InputError(
            f"a goal of the class {type(goal).__name__} cannot be written as a sentence; "
            "leave out temporal operators"
        )

    def _write_quantified(self, goal: f.Formula, names: PhraseOfVariable) -> str:
        """Return the clause for a goal about all, some or a number of objects, or about pairs of objects."""
        match goal:
            case f.ForAll(variable, f.Not(f.Atom() as atom)):
                return self._write_sentence(
                    atom, {**names, variable.name: f"no {_get_variable_noun(variable)}"}
                )
            case f.ForAll(variable, body) | f.Exists(variable, body):
                quantifier = "every" if isinstance(goal, f.ForAll) else "at least one"
                which = f"{quantifier} {_get_variable_noun(variable)}"
                if isinstance(body, f.Atom):
                    return self._write_sentence(body, {**names, variable.name: which})
                return f"for {which}, {self._write_quantified_body(body, names, variable)}"
            case f.Exactly(count, variable, body):
                noun = _get_variable_noun(variable) if count == 1 else pluralize(_get_variable_noun(variable))
                number = NUMBERS.get(count, str(count))
                return f"for exactly {number} {noun}, {self._write_quantified_body(body, names, variable)}"
            case f.ForPairs(first, second, body):
                clause = self._write_quantified_body(body, names, first, second)
                own, other = _get_variable_noun(first), _get_variable_noun(second)
                return f"each {own} goes with a different {other}, so that {clause}"
        raise InputError(
            f"a goal of the class {type(goal).__name__} cannot be written as a sentence; "
            "leave out temporal operators"
        )

    def _write_quantified_body(self, body: f.Formula, names: PhraseOfVariable, *variables: f.Variable) -> str:
        return self.write_goal_clause(
            body,
            {**names, **{variable.name: f"that {_get_variable_noun(variable)}" for variable in variables}},
        )

    def _write_sentence(self, atom: f.Atom, names: PhraseOfVariable, *, negated: bool = False) -> str:
        sentence = make_predicate_sentences(atom.predicate, len(atom.arguments), self._english)[0]
        phrases = [self.name_term(term, names) for term in atom.arguments]
        return inflect_sentence(sentence, negated=negated).format(**dict(zip("xy", phrases, strict=False)))


def _get_variable_noun(variable: f.Variable) -> str:
    return _get_category_noun(variable.category or "thing")
