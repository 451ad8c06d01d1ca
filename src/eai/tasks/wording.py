"""The words of prompts and answers for one ability (kind of question), from a benchmark's declaration."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeAlias

from eai.logic.rewriting import rename_objects
from eai.tasks.goal_text import write_goal
from eai.tasks.rules import DomainRulesInPrompts, explain_rule_notation, write_operator_title
from eai.tasks.task import Task
from eai.world.domain import Domain
from eai.world.fault import FaultKind
from eai.world.listing import FactLister, make_fact_lister
from eai.world.operator import Check, Operator
from eai.world.state import Fact
from eai.world.vocabulary import Predicate, make_parameter_names

ObjectName: TypeAlias = Callable[[Task, int], str]
"""Function that returns the name of an object in prompts, given its task and its index."""

_WORDS_BEFORE_REASONS = (
    (FaultKind.AFFORDANCE, "impossible where"),
    (FaultKind.MISSING_STEP, "not yet possible while"),
    (FaultKind.ADDITIONAL_STEP, "needless where"),
)
"""Pairs: a kind of fault, and the words with which prompts begin the list of reasons for such faults."""


def get_declared_object_name(task: Task, index: int) -> str:
    """Return the declared name of an object."""
    return task.scene.objects[index].name


@dataclass(frozen=True)
class PromptAndAnswerWording:
    """The words of the prompts and answers for one ability (kind of question) and one benchmark.

    Attributes:
        domain: the declaration of the benchmark's domain.
        predicates: names of the stored or derived predicates that goals use.
        answer_names: mapping from declared names of predicates to their names in answers, if these differ.
        object_name: returns the name of an object in prompts.
        conventions: returns a text on facts of a task's world that prompts must explain, such as what heats
            food; None for worlds without such facts.
        static: predicates that no action changes, and that descriptions of states list after `predicates`.
        hands: predicates of objects in the agent's hands, which descriptions of states list last.
        rules: the exact conditions and effects of actions; None if prompts give reasons for failures instead.
        unchanging: predicates that no action changes, and whose facts `conventions` tells in words. Exact
            rules state these facts.
        surroundings: returns indices of further objects of a task that prompts list, such as the rooms of a
            house.
        states_instruction: whether questions for plans state a task's instruction in addition to its goals.
    """

    domain: Domain
    predicates: tuple[str, ...]
    answer_names: Mapping[str, str] = field(default_factory=dict)
    object_name: ObjectName = get_declared_object_name
    conventions: Callable[[Task], str] | None = None
    static: tuple[str, ...] = ()
    hands: tuple[str, ...] = ()
    rules: DomainRulesInPrompts | None = None
    unchanging: tuple[str, ...] = ()
    surroundings: Callable[[Task], Iterable[int]] | None = None
    states_instruction: bool = False

    @staticmethod
    def from_domain(domain: Domain) -> PromptAndAnswerWording:
        """Return the wording of prompts and answers with a domain's own names and rules.

        Prompts use its visible predicates, but not the unchanging properties of single objects.
        """
        said = [p for p in domain.vocabulary.predicates if p.visible and not is_unchanging_object_property(p)]
        changeable = tuple([p.name for p in said if not p.static])
        static = tuple([p.name for p in said if p.static])
        return PromptAndAnswerWording(
            domain, changeable, static=static, rules=DomainRulesInPrompts(domain), states_instruction=True
        )

    def describe_vocabulary(self) -> str:
        """Return all predicates that prompts use, each with its parameters, one a line.

        The attributes `predicates` and `static` list them.
        """
        arities = [(name, self._find_predicate_arity(name)) for name in (*self.predicates, *self.static)]
        return _join_lines(
            f"{self._get_predicate_name_in_answers(name)}({', '.join(make_parameter_names(arity))})"
            for name, arity in arities
        )

    def describe_operators(self) -> str:
        """Return the descriptions of all actions, each as `describe_operator` writes it.

        If prompts show the exact rules of actions, an explanation of their notation comes first.
        """
        listed = _join_lines(map(self.describe_operator, self.domain.operators))
        if self.rules is None:
            return listed
        rules = "\n".join([listed, *self.rules.write_predicate_definitions()])
        return f"{explain_rule_notation(rules)}\n{rules}"

    def write_operators_heading(self, phrase_for_one_action: str) -> str:
        """Return the heading above the text of `describe_operators`.

        `phrase_for_one_action` stands for one action in the heading, such as ``each`` in "what each
        requires".
        """
        if self.rules is None:
            return f"the reasons for which {phrase_for_one_action} can fail"
        return f"what {phrase_for_one_action} requires and changes"

    def describe_operator(self, operator: Operator) -> str:
        """Return one action with its exact rule; or, without `rules`, with the reasons why it can fail."""
        exact = None if self.rules is None else self.rules.write_operator_rule(operator)
        return exact or _describe_reasons_for_failure(operator)

    def describe_objects(self, task: Task) -> str:
        """Return a task's objects with their properties, each once, and notes on the benchmark's rules."""
        listed = _join_lines(
            dict.fromkeys([self.describe_object(task, index) for index in self.list_prompt_objects(task)])
        )
        notes = [] if self.conventions is None else [self.conventions(task)]
        agent = task.scene.agent
        if self.rules is not None and agent is not None:
            notes.append(f"The agent is {self.object_name(task, agent)}.")
        return "\n\n".join([listed, *filter(None, notes)])

    def list_prompt_objects(self, task: Task) -> list[int]:
        """Return the indices of the objects that a prompt lists: those of the task, and its surroundings.

        Surroundings are, for instance, rooms.
        """
        if self.surroundings is None:
            return list_objects_in_prompt(task)
        return sorted({*list_objects_in_prompt(task), *self.surroundings(task)})

    def describe_object(self, task: Task, index: int) -> str:
        """Return a text with an object's name, its kind and its properties."""
        return f"{self.object_name(task, index)} {self.describe_object_kind_and_properties(task, index)}"

    def describe_object_kind_and_properties(self, task: Task, object_index: int) -> str:
        """Return the kind of an object with all more general kinds, and the object's properties."""
        properties = [
            p for p in self.domain.vocabulary.predicates if p.visible and is_unchanging_object_property(p)
        ]
        having = [p.name for p in properties if task.initial.has(p.name, object_index)]
        kinds = self.domain.vocabulary.list_kind_with_ancestors(task.scene.objects[object_index].category)
        return f"[{', '.join(kinds)}]: {', '.join(having) or '-'}"

    def describe_initial_state(self, task: Task) -> str:
        """Return the facts about a task's objects in the initial state, one a line."""
        about = self.list_prompt_objects(task)
        facts = [
            fact
            for listing in self.fact_listers_of_state_predicates
            for fact in listing.list_facts(task.initial, about)
        ]
        return _join_lines(dict.fromkeys([self.write_fact(task, fact) for fact in facts]))

    @cached_property
    def fact_listers_of_goal_predicates(self) -> tuple[FactLister, ...]:
        """For each predicate of goals, the `FactLister` that finds the facts of the predicate in a state.

        The order is that of `predicates`.
        """
        return self._make_fact_listers(self.predicates)

    @cached_property
    def fact_listers_of_state_predicates(self) -> tuple[FactLister, ...]:
        """For each predicate in descriptions of states, the `FactLister` that finds its facts in a state."""
        others = [name for name in (*self.static, *self.hands) if name not in self.predicates]
        return (*self.fact_listers_of_goal_predicates, *self._make_fact_listers(others))

    def _make_fact_listers(self, names: Iterable[str]) -> tuple[FactLister, ...]:
        """Return for each predicate an object that lists its facts in a state.

        If prompts state the exact rules of actions, facts such as ``near(a, a)`` are listed too.
        """
        repeated = self.rules is not None
        return tuple(
            [make_fact_lister(self.domain.vocabulary, name, allow_equal_arguments=repeated) for name in names]
        )

    def write_fact(self, task: Task, fact: Fact) -> str:
        """Return a fact about objects of a task, as text for prompts."""
        return self.write_fact_with_names(fact.predicate, [self.object_name(task, i) for i in fact.arguments])

    def write_fact_with_names(self, predicate: str, object_names: Iterable[str]) -> str:
        """Return a fact about objects with the given names, as text for prompts."""
        return f"{self._get_predicate_name_in_answers(predicate)}({', '.join(object_names)})"

    def write_instruction_line(self, task: Task) -> str:
        """Return a task's instruction as a line, or an empty text.

        The text is empty if prompts leave the instruction out, or state it instead of the goals.
        """
        shown = self.states_instruction and task.has_goals_in_prompts
        return f"\nInstruction: {task.instruction}" if shown else ""

    def describe_goals(self, task: Task) -> str:
        """Return the goals of a task, or its instruction if prompts do not state the goals."""
        if not task.has_goals_in_prompts:
            return task.instruction
        names = {
            task.scene.objects[i].name: self.object_name(task, i) for i in range(len(task.scene.objects))
        }
        return _join_lines(
            write_goal(rename_objects(goal.formula, names))
            for goal in task.with_only_goals_stated_in_prompts.goals
        )

    def _get_predicate_name_in_answers(self, predicate: str) -> str:
        return self.answer_names.get(predicate, predicate)

    def _find_predicate_arity(self, predicate: str) -> int:
        return self.domain.vocabulary.find_arity(predicate) or 0


def list_objects_in_prompt(task: Task) -> list[int]:
    """Return the objects that a prompt mentions: the objects that an answer may name, and the agent."""
    agent = () if task.scene.agent is None else (task.scene.agent,)
    return list(dict.fromkeys((*task.relevant, *agent)))


def _describe_reasons_for_failure(operator: Operator) -> str:
    names = {parameter.name: parameter.name for parameter in operator.parameters}
    checks: Sequence[Check] = (
        *operator.checks,
        *(check for attempt in operator.alternatives for check in attempt.checks),
    )
    lines = [write_operator_title(operator)]
    for kind, meaning in _WORDS_BEFORE_REASONS:
        reasons = dict.fromkeys(c.reason.format_map(names) for c in checks if c.fault is kind)
        if reasons:
            lines.append(f"  {meaning}: {'; '.join(reasons)}")
    return "\n".join(lines)


def is_unchanging_object_property(predicate: Predicate | None) -> bool:
    """Whether a predicate states an unchanging property of one object."""
    return predicate is not None and predicate.static and predicate.arity == 1


def _join_lines(texts: Iterable[str]) -> str:
    return "\n".join(texts) or "-"
