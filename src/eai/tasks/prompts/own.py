"""Render our own prompts from the declaration of a domain. Published prompts are read from files instead.

Prompts of transition modeling show the first lines of operators, which the answer must complete.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cache, partial
from string import Template
from typing import TypeAlias

import eai.logic.formula as f
from eai.base.grouping import group_pairs
from eai.logic.traversal import find_predicates, walk_subformulas
from eai.pddl.model import OBJECT, PddlDomain, get_variable_type
from eai.pddl.writer import write_atom, write_axiom, write_domain, write_formula, write_problem, write_term
from eai.tasks.operator_task import TransitionTask
from eai.tasks.prompts.prompt import BelievedTask, Prompt, make_memory_saving_prompt_mapping
from eai.tasks.prompts.short import (
    RULES,
    explain_symbols_in_short_fact_list,
    merge_lines_of_similar_facts,
    merge_lines_of_similar_objects,
    shorten_predicate_list,
    shorten_rules,
)
from eai.tasks.prompts.template import PromptTemplates, Text
from eai.tasks.special import AmbiguousTaskMark, PossiblyImpossibleTaskMark
from eai.tasks.task import GoalKind, Task
from eai.tasks.wording import PromptAndAnswerWording
from eai.world.vocabulary import make_parameter_names

MAX_SHOWN_TYPES = 300
"""Maximum number of types of a domain that prompts print in full.

Prompts about a domain with more types print only the types and predicates that matter to the task.
"""

MAX_EXAMPLE_OPERATORS = 2
"""Maximum number of operators in the example of a prompt of transition modeling."""

_QUANTIFIERS = {f.ForAll: "forall", f.Exists: "exists", f.Exactly: "forn", f.ForPairs: "forpairs"}

_DECLINABLE = {"action_sequencing": "", "environment": "_acting"}
"""Mapping from a template of questions to the suffix of the templates that explain how to decline them.

An answer that declines a question states that the task is impossible, or asks for the meant object. Answers
may not decline questions of other templates.
"""

_WORD = re.compile(r"[^\s()]+")

Example: TypeAlias = Callable[[str], str]
"""Function that returns the right answer to the task with a given id."""


@dataclass(frozen=True, slots=True)
class PromptTemplateValues:
    """The material from which prompts of one ability (kind of question) are made, for any declared domain.

    Attributes:
        template: name of the ability, which is also the name of its templates. `render_operator_prompts`
            renders transition modeling instead.
        wording: the names of objects, predicates and actions in prompts.
        role: the role of the agent, as in ``a household robot``.
        tasks: mapping from ids to the tasks.
        answer_format: text that explains the format of answers.
        example: returns the right answer to the example in a prompt.
        beliefs: mapping from the ids of some tasks to the goals or the scene that a model believes, which
            questions then state. Examples in prompts show true tasks.
        examples: the tasks that prompts may show with their answers; None for all tasks.
        short_texts: texts for short prompts on the rules of actions and on the form of answers, as in
            `Notation.short_texts`.
    """

    template: str
    wording: PromptAndAnswerWording
    role: str
    tasks: Mapping[str, Task]
    answer_format: str
    example: Example
    beliefs: Mapping[str, BelievedTask] = field(default_factory=dict)
    examples: Mapping[str, Task] | None = None
    short_texts: Mapping[str, str] = field(default_factory=dict)

    def find_example_with_other_title(self, excluded_title: str) -> Task | None:
        """Return the first example whose title differs from the given title, or None.

        Similar tasks share a title.
        """
        examples = self.tasks if self.examples is None else self.examples
        return next((task for task in examples.values() if task.title != excluded_title), None)


def make_domain_texts_by_placeholder(
    wording: PromptAndAnswerWording, benchmark_short_texts: Mapping[str, str]
) -> Mapping[str, str]:
    """Return a mapping from placeholders of templates to texts on the predicates and actions of a domain.

    Args:
        wording: the names of predicates and actions in prompts.
        benchmark_short_texts: the benchmark's own texts for prompts in short notation (``short``).
    """
    vocabulary, operators = wording.describe_vocabulary(), wording.describe_operators()
    return {
        "vocabulary": vocabulary,
        "short_vocabulary": shorten_predicate_list(vocabulary),
        "operators": operators,
        "short_operators": benchmark_short_texts.get(RULES) or shorten_rules(operators),
        "of_each": wording.write_operators_heading("each"),
    }


def render_prompts(material: PromptTemplateValues, templates: PromptTemplates) -> Mapping[str, Prompt]:
    """Return the prompts of tasks.

    The example in a prompt is the first task with another title (name that similar tasks share).
    """
    name, wording, tasks = material.template, material.wording, material.tasks
    shared = {
        **make_domain_texts_by_placeholder(wording, material.short_texts),
        "role": material.role,
        "format": material.answer_format,
        "short_format": material.short_texts.get(name, material.answer_format),
    }
    tells_goals = "$explained" in templates.read(f"{name}.txt")
    find_example_with_other_title = cache(material.find_example_with_other_title)

    @cache
    def render_example_with_other_title(excluded_title: str) -> str:
        if (other := find_example_with_other_title(excluded_title)) is None:
            return ""
        question = _render_question(name, wording, BelievedTask(other), templates)
        return templates.fill_template(
            "example.txt", {"task": question, "answer": material.example(other.id)}
        )

    def render_prompt(task_id: str, task: Task) -> Prompt:
        belief = material.beliefs.get(task_id) or BelievedTask(task)
        other = find_example_with_other_title(task.title)
        about = [belief.task] if other is None else [belief.task, other]
        explained = explain_goal_notation(name, about, templates) if tells_goals else []
        values = {
            **shared,
            "explained": "".join([f"\n\n{explanation}" for explanation in explained]),
            "example": render_example_with_other_title(task.title),
            "task": _render_question(name, wording, belief, templates),
        }
        return Prompt(templates.fill_template(f"{name}.txt", values), images=belief.images)

    return make_memory_saving_prompt_mapping(
        (task_id, render_prompt(task_id, task)) for task_id, task in tasks.items()
    )


def render_task_prompt(
    material: PromptTemplateValues, belief: BelievedTask, templates: PromptTemplates
) -> Prompt:
    """Return the prompt about a task with the goals or the scene that a model believes to be true.

    The task of `belief` has these goals and this scene. `material.beliefs` is ignored.
    """
    task = belief.task
    other = material.find_example_with_other_title(task.title)
    examples = {} if other is None else {other.id: other}
    single = replace(material, tasks={task.id: task}, beliefs={task.id: belief}, examples=examples)
    return render_prompts(single, templates)[task.id]


def _render_question(
    name: str, wording: PromptAndAnswerWording, belief: BelievedTask, templates: PromptTemplates
) -> str:
    task = belief.task
    objects, initial = wording.describe_objects(task), write_initial_state(wording, belief)

    def write_short_initial_state() -> str:
        return merge_lines_of_similar_facts(initial, objects)

    values: dict[str, Text] = {
        "title": task.title,
        "instruction": task.instruction,
        "instructed": wording.write_instruction_line(task),
        "objects": objects,
        "short_objects": lambda: merge_lines_of_similar_objects(objects),
        "initial": initial,
        "short_initial": write_short_initial_state,
        "lists": lambda: explain_symbols_in_short_fact_list(write_short_initial_state()),
        "goals": _write_goals_and_subgoals(wording, belief, templates),
    }
    return templates.fill_template(f"{name}_task.txt", values)


def _write_goals_and_subgoals(
    wording: PromptAndAnswerWording, belief: BelievedTask, templates: PromptTemplates
) -> str:
    """Return the text of the goals that a question states, followed by its subgoals, if any."""
    goals = wording.describe_goals(belief.task)
    if not belief.subgoals:
        return goals
    return (
        f"{goals}\n\n{templates.fill_template('subgoals.txt', {'subgoals': chr(10).join(belief.subgoals)})}"
    )


def write_initial_state(wording: PromptAndAnswerWording, belief: BelievedTask) -> str:
    """Return a text on the initial state of a task: the true state, or the state that a model perceived."""
    return Template(belief.initial).safe_substitute(initial=wording.describe_initial_state(belief.task))


def explain_goal_notation(name: str, tasks: Iterable[Task], templates: PromptTemplates) -> list[str]:
    """Return explanations of the symbols in the goals of tasks: actions, quantifiers and temporal operators.

    Args:
        name: name of the template that explains goals about actions, usually the name of an ability.
        tasks: the tasks.
        templates: the templates.
    """
    about = [task.with_only_goals_stated_in_prompts for task in tasks]
    goals = [goal for task in about for goal in task.goals]
    forms = {type(part) for goal in goals for part in walk_subformulas(goal.formula)}
    used = {
        name: any(goal.kind is GoalKind.ACTION for goal in goals),
        **{word: form in forms for form, word in _QUANTIFIERS.items()},
        "over_time": any(goal.is_temporal for goal in goals),
    }
    special = {type(task.special) for task in about} if name in _DECLINABLE else set()
    for kind, template in ((PossiblyImpossibleTaskMark, "missing"), (AmbiguousTaskMark, "ambiguous")):
        used[f"{template}{_DECLINABLE.get(name)}"] = kind in special
    return [
        templates.read(f"goals/{template_name}.txt") for template_name, is_used in used.items() if is_used
    ]


def make_answer_format_samples_by_placeholder(wording: PromptAndAnswerWording) -> Mapping[str, str]:
    """Return a mapping from placeholders to samples for the explanation of the answer's format.

    The samples are predicates and actions of the domain with their parameters.
    """
    arity = wording.domain.vocabulary.find_arity
    names = {name: wording.answer_names.get(name, name) for name in wording.predicates}
    examples = [(written, *make_parameter_names(arity(name) or 0)) for name, written in names.items()]
    examples = examples or [("predicate", "x")]
    state = min(examples, key=lambda words: abs(len(words) - 2))
    relation = min(examples, key=lambda words: (len(words) < 3, len(words)))
    actions = sorted(wording.domain.operators, key=lambda operator: (operator.arity == 0, operator.arity))
    few = dict.fromkeys([*actions[:1], *actions[-1:]])
    steps = [{"action": o.name, "object": ", ".join([p.name for p in o.parameters])} for o in few]
    return {
        "steps": json.dumps(steps),
        "state": json.dumps(state),
        "relation": json.dumps(relation),
        "action": json.dumps(actions[0].name if actions else "action"),
        "first": f"{state[0]}({', '.join(state[1:])})",
        "second": f"{relation[0]}({', '.join(relation[1:])})",
    }


def render_operator_prompts(
    tasks: Mapping[str, TransitionTask], templates: PromptTemplates, *, has_example: bool = True
) -> Mapping[str, Prompt]:
    """Return the prompts of transition modeling.

    The example in a prompt shows operators that the task does not ask for. If a domain has very many types,
    the prompt shows only the predicates in operators and goals of task and example. Predicates in the
    definitions of these predicates are shown, too.

    Raises:
        InputError: a template of the user cannot be used.
    """
    answer_format = templates.read("formats/transition_modeling.txt")

    def render_prompt(task: TransitionTask) -> Prompt:
        other, others = _choose_example_task_and_operators(task, tasks) if has_example else (task, ())
        names = _find_names_to_print_in_prompt(task, other, (*task.operators, *others))
        example = _render_operator_example(other, others, names, templates)
        question = _render_operator_question(task, task.operators, names, templates)
        values: dict[str, Text] = {
            "predicates": write_domain(
                _keep_declarations_used_in_prompt(task.domain.header, names, f"{example}\n{question}")
            ),
            "short_predicates": partial(_write_short_domain_header, task),
            "format": answer_format,
            "short_format": answer_format,
            "example": example,
            "task": question,
        }
        return Prompt(templates.fill_template("transition_modeling.txt", values))

    return make_memory_saving_prompt_mapping(
        (task_id, render_prompt(task)) for task_id, task in tasks.items()
    )


def _find_names_to_print_in_prompt(
    task: TransitionTask, example_task: TransitionTask, operators: Sequence[str]
) -> Set[str] | None:
    """Return the names to print in a prompt, or None to print the whole domain.

    They are the names in ``operators``, in the goals of the task and of the example, and in definitions of
    derived predicates among these names.
    """
    header = task.domain.header
    if len(header.types) <= MAX_SHOWN_TYPES:
        return None
    texts = [task.domain.operators[name].write_pddl for name in operators]
    names = set(
        _WORD.findall(
            " ".join((*texts, *(each.problem_text.partition("(:goal")[2] for each in (task, example_task))))
        )
    )
    grown = 0
    while grown < len(names):
        grown = len(names)
        for axiom in header.axioms:
            if axiom.name in names:
                names.update(find_predicates(axiom.condition))
    return names


def _keep_declarations_used_in_prompt(
    domain: PddlDomain, predicate_names: Set[str] | None, prompt_text: str
) -> PddlDomain:
    """Return the domain with only the predicates in ``predicate_names``, and the types in the prompt's text.

    Return the whole domain if ``predicate_names`` is None.
    """
    if predicate_names is None:
        return domain
    words = {*_WORD.findall(prompt_text), *(item.type for item in domain.constants)}
    return replace(
        domain,
        types=tuple([each for each in domain.types if each.name in words]),
        predicates=tuple([each for each in domain.predicates if each.name in predicate_names]),
        axioms=tuple([each for each in domain.axioms if each.name in predicate_names]),
    )


def _render_operator_question(
    task: TransitionTask, operators: Sequence[str], names: Set[str] | None, templates: PromptTemplates
) -> str:
    """Return the question: the problem, and operators whose conditions and effects are empty.

    It states only the initial facts whose predicates are in ``names``; all facts if ``names`` is None.
    """
    heads = "\n".join(
        f"(:action {name}\n  :parameters {task.domain.operators[name].parameters}\n"
        "  :precondition ()\n  :effect ())"
        for name in operators
    )
    problem = task.problem_text.strip()
    if names is not None:
        facts = [fact for fact in task.problem.initial if fact.predicate in names]
        problem = write_problem(replace(task.problem, initial=tuple(facts))).strip()
    write_short_problem = partial(_write_problem_as_short_lists, task, operators)
    values: dict[str, Text] = {
        "problem": problem,
        "short_problem": write_short_problem,
        "lists": lambda: explain_symbols_in_short_fact_list(write_short_problem()),
        "heads": heads,
        "short_heads": "\n".join(
            [
                f"(:action {name} :parameters {_write_parameters_on_one_line(task, name)})"
                for name in operators
            ]
        ),
    }
    return templates.fill_template("transition_modeling_task.txt", values)


def _write_parameters_on_one_line(task: TransitionTask, operator: str) -> str:
    return " ".join(task.domain.operators[operator].parameters.split())


def _write_problem_as_short_lists(task: TransitionTask, operators: Sequence[str]) -> str:
    """Return the objects, facts and goal of a problem as short lists."""
    problem, names = task.problem, _find_names_to_print_in_prompt(task, task, operators)
    objects = "\n".join([f"{item.name} [{item.type}]: -" for item in problem.objects])
    by_predicate = group_pairs(
        (fact.predicate, f"{fact.predicate}({', '.join(map(write_term, fact.arguments))})")
        for fact in problem.initial
        if names is None or fact.predicate in names
    )
    state = "\n".join([fact for facts in by_predicate.values() for fact in facts])
    denied = [f"not {write_atom(atom)}" for atom in problem.denied]
    lists = [
        merge_lines_of_similar_objects(objects).replace(f" [{OBJECT}]", ""),
        merge_lines_of_similar_facts(state, objects),
    ]
    return "\n".join([*filter(None, lists), *denied, f"(:goal {write_formula(problem.goal)})"])


def _write_short_domain_header(task: TransitionTask) -> str:
    """Return the types and predicates that a task needs, as short lists."""
    header = task.domain.header
    names = _find_names_to_print_in_prompt(task, task, task.operators) or {
        each.name for each in header.predicates
    }
    heads = " ".join([task.domain.operators[name].parameters for name in task.operators])
    needed = _keep_declarations_used_in_prompt(header, names, f"{write_problem(task.problem)} {heads}")
    by_types = group_pairs(
        (", ".join(map(get_variable_type, each.parameters)), each.name) for each in needed.predicates
    )
    types = group_pairs((item.type, item.name) for item in needed.types if item.name != OBJECT)
    lines = [f"Types of {kind}: {', '.join(alike)}" for kind, alike in types.items()]
    lines += [f"Constant: {item.name} - {item.type}" for item in needed.constants]
    lines += [f"({kinds}): {', '.join(alike)}" for kinds, alike in by_types.items()]
    return "\n".join([*lines, *[" ".join(write_axiom(axiom).split()) for axiom in needed.axioms]])


def _choose_example_task_and_operators(
    task: TransitionTask, tasks: Mapping[str, TransitionTask]
) -> tuple[TransitionTask, Sequence[str]]:
    """Return the task for the example, and some of its operators that the prompt's task does not ask for.

    The task with most operators is chosen; among several, the task with the shortest text.
    """
    own_names = set(task.operators)

    def list_operators_not_asked_for(candidate: TransitionTask) -> list[str]:
        return [name for name in candidate.operators if name not in own_names][:MAX_EXAMPLE_OPERATORS]

    best = max(
        tasks.values(),
        key=lambda candidate: (len(list_operators_not_asked_for(candidate)), -len(candidate.problem_text)),
    )
    return best, list_operators_not_asked_for(best)


def _render_operator_example(
    example_task: TransitionTask, operators: Sequence[str], names: Set[str] | None, templates: PromptTemplates
) -> str:
    """Return the text of the example: a question for operators of another task, and the right answer.

    The text is empty if no operators are given.
    """
    if not operators:
        return ""
    answer = json.dumps(
        {"output": "\n".join(example_task.domain.operators[name].write_pddl for name in operators)}
    )
    question = _render_operator_question(example_task, operators, names, templates)
    return templates.fill_template("example.txt", {"task": question, "answer": answer})
