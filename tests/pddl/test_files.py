"""Files of PDDL: every character is read or refused with its place, and a message names the mistake."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from command_line import Command
from eai.base.errors import InputError
from eai.benchmarks.registry import find_benchmark
from eai.pddl.files import is_domain_file, read_domain_text, read_problem_file, read_problem_text, read_text
from eai.pddl.writer import write_effect
from eai.tasks.source import Source
from eai.tasks.task_files import find_task_files
from eai.tasks.task_lines import write_task_line

TWO = """\
(define (domain two)
 (:requirements :strips)
 (:predicates (p ?x) (r ?x))
 (:action mk :parameters (?x) :precondition () :effect (p ?x))
 (:action un :parameters (?x) :precondition (p ?x) :effect (r ?x)))
"""
PROBLEM = """\
(define (problem q)
 (:domain two)
 (:objects a b)
 (:init)
 (:goal (r a)))
"""
CONSTANT = """\
(define (domain c)
 (:types t s)
 (:constants a - t)
 (:predicates (p ?x - t))
 (:action mk :parameters (?x - t) :precondition () :effect (p ?x)))
"""
DASH = """\
(define (domain c)
 (:requirements :typing)
 (:types ball)
 (:predicates (p ?x - ball))
 (:action mk :parameters (?x -ball) :precondition () :effect (p ?x)))
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def write(**files: str | bytes) -> None:
    """Write files ``NAME.pddl``."""
    for name, text in files.items():
        Path(f"{name}.pddl").write_bytes(text if isinstance(text, bytes) else text.encode())


def tasks_of(reference: str) -> list[str]:
    return list(find_benchmark(reference).tasks(Source()))


def refusal(reference: str) -> str:
    with pytest.raises(InputError) as caught:
        find_benchmark(reference)
    return str(caught.value)


def test_a_comment_may_be_in_latin_1() -> None:
    write(d=b"; Dom\xe4ne f\xfcr b\xe9\n" + TWO.encode(), p=b";\xe9\n" + PROBLEM.encode() + b"; fin\xe9")
    assert tasks_of("pddl:d.pddl,p.pddl") == ["q"]
    assert read_text(Path("d.pddl")).startswith("; Domäne für bé\n")


@pytest.mark.parametrize(
    "reference", ["d.pddl,all/", "d.pddl,all", "d.pddl, all/", "./d.pddl,./all/", "./", "."]
)
def test_files_and_folders_may_be_written_in_each_usual_form(eai: Command, reference: str) -> None:
    write(d=TWO)
    Path("all").mkdir()
    Path("all/q.pddl").write_text(PROBLEM)
    assert tasks_of(f"pddl:{reference}") == ["q"]
    checked = eai("check", f"pddl:{reference}")
    assert (checked.status, checked.err) == (0, "")
    assert "and 1 task; nothing is wrong" in checked.out


def test_a_reference_to_files_without_the_word_before_them_names_the_word() -> None:
    for reference in ("d.pddl,all/", "d.pddl"):
        expected = f"{reference}: files of PDDL are given as pddl:DOMAIN,PROBLEMS; put pddl: in front"
        assert refusal(reference) == expected


def test_a_comment_in_utf_8_is_read_as_utf_8() -> None:
    write(d=f"; Domäne\n{TWO}")
    assert read_text(Path("d.pddl")).startswith("; Domäne\n")


def test_a_byte_that_is_not_utf_8_outside_a_comment_is_refused_with_its_place() -> None:
    write(d=TWO.encode().replace(b"(r ?x))", b"(r\xe9 ?x)) ; \xe9", 1), p=PROBLEM)
    assert refusal("pddl:d.pddl,p.pddl") == "d.pddl: line 3, column 24: expected UTF-8, found the byte 0xe9"


@pytest.mark.parametrize(
    ("end", "place"),
    [(")", "line 6, column 1"), ("\n; a\n (:action)", "line 8, column 2"), (" x", "line 6, ")],
)
@pytest.mark.parametrize("name", ["d", "p"])
def test_text_behind_the_last_parenthesis_is_refused_with_its_place(name: str, end: str, place: str) -> None:
    texts = {"d": TWO, "p": PROBLEM}
    write(**texts | {name: texts[name] + end})
    message = refusal("pddl:d.pddl,p.pddl")
    assert message.startswith(f"{name}.pddl: {place}")
    assert "expected the end of the file, as the definition ends at line 5, column " in message


def test_a_parenthesis_too_many_in_an_operator_loses_no_later_operator() -> None:
    write(d=TWO.replace(":effect (p ?x))\n", ":effect (p ?x)))\n"), p=PROBLEM)
    assert refusal("pddl:d.pddl,p.pddl").startswith("d.pddl: line 5, column 2: expected the end of the file")


def test_comments_and_blanks_may_stand_behind_the_end() -> None:
    write(d=f"{TWO}\n ; done (\n\t", p=f"{PROBLEM};")
    assert tasks_of("pddl:d.pddl,p.pddl") == ["q"]


def test_a_parenthesis_too_few_is_found_where_the_next_section_begins() -> None:
    write(d=TWO.replace(":effect (p ?x))\n", ":effect (p ?x)\n"), p=PROBLEM)
    expected = "d.pddl: line 5, column 2: expected a closing parenthesis before this section"
    assert refusal("pddl:d.pddl,p.pddl") == expected


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            ":precondition ()",
            ":preconditions ()",
            "line 4, column 31: expected .* did you mean :precondition?",
        ),
        (":effect (p", ":efect (p", "line 4, column 48: expected .* did you mean :effect?"),
        (
            ":parameters (?x) :precondition ()",
            ":parameters :precondition ()",
            "line 4, column 14: expected a li",
        ),
        (":precondition ()", ":effect (r ?x)", "line 4, column 46: expected :effect once only"),
        (":effect (p ?x))", "(p ?x))", "line 4, column 48: expected a word, not a list"),
        ("(:action mk ", "(:action ", "line 4, column 11: expected the name of an action, not :parameters"),
        ("(:predicates", "(:predicate", "line 3, column 2: .* not .:predicate .* did you mean :predicates?"),
        ("(domain two", "(domian two", "line 1, column 9: .* did you mean domain?"),
        ("(p ?x) :effect", "(pp ?x) :effect", "line 5, column 46: .* not pp .* did you mean p?"),
        (
            ":precondition ()",
            ":precondition (fora (?y) (p ?y))",
            "line 4, column 46: .* did you mean forall?",
        ),
    ],
)
def test_a_misspelt_word_of_a_domain_is_named_with_its_place(old: str, new: str, message: str) -> None:
    assert old in TWO
    write(d=TWO.replace(old, new, 1), p=PROBLEM)
    with pytest.raises(InputError, match=message.replace("?", r"\?")):
        find_benchmark("pddl:d.pddl,p.pddl")


DERIVED = """\
(define (domain two)
 (:predicates (p ?x) (r ?x))
 (:derived (r ?y) (p ?y))
 (:action mk :parameters (?x) :precondition () :effect (p ?x)))
"""


@pytest.mark.parametrize(
    ("head", "message"),
    [
        ("(r ?y ?z)", "expected r with as many arguments as are declared"),
        ("(r ?y ?y)", "expected y once only"),
        ("(q ?y)", "expected a declared predicate, not q"),
    ],
)
def test_a_derived_predicate_fits_its_declaration(head: str, message: str) -> None:
    write(d=DERIVED.replace("(r ?y)", head), p=PROBLEM)
    assert refusal("pddl:d.pddl,p.pddl").startswith("d.pddl: line 3, column ")
    assert message in refusal("pddl:d.pddl,p.pddl")


def test_an_initial_fact_of_a_derived_predicate_is_refused_with_its_place() -> None:
    write(d=DERIVED, p=PROBLEM.replace("(:init)", "(:init (r a))"))
    expected = "p.pddl: line 4, column 10: expected facts from which r follows, as r is a derived predicate"
    assert refusal("pddl:d.pddl,p.pddl") == expected


@pytest.mark.parametrize("effect", ["{}", "(when (r ?x) {})", "(forall (?y) {})", "(and (p ?x) {})"])
def test_costs_are_ignored_anywhere_in_an_effect(effect: str) -> None:
    costs = TWO.replace(":effect (p ?x)", f":effect {effect.format('(increase (total-cost) 1)')}")
    nothing = TWO.replace(":effect (p ?x)", f":effect {effect.format('(and)')}")
    assert read_domain_text(costs, Path("d")) == read_domain_text(nothing, Path("d"))


def test_a_predicate_may_be_called_increase() -> None:
    domain = read_domain_text(TWO.replace("(r ", "(increase "), Path("d"))
    assert [write_effect(action.effect) for action in domain.actions] == ["(p ?x)", "(increase ?x)"]


def test_swapped_files_are_named() -> None:
    write(d=TWO, p=PROBLEM)
    message = "p.pddl: line 1, column 9: expected the definition of a domain, not of the problem q"
    assert refusal("pddl:p.pddl,d.pddl").startswith(message)
    message = "d.pddl: line 1, column 9: expected the definition of a problem, not of the domain two"
    assert refusal("pddl:d.pddl,d.pddl").startswith(message)


@pytest.mark.parametrize("reference", ["pddl:both.pddl,p.pddl", "pddl:d.pddl,both.pddl", "pddl:."])
def test_a_file_with_two_definitions_is_refused(reference: str) -> None:
    write(both=TWO + PROBLEM, p=PROBLEM)
    if reference != "pddl:.":
        write(d=TWO)
    expected = "expected one definition in a file; put this problem into a file of its own"
    assert refusal(reference).endswith(f"both.pddl: line 6, column 1: {expected}")


def test_the_hyphen_before_a_type_needs_no_space_behind_it() -> None:
    write(d=DASH, p="(define (problem q) (:domain c) (:objects a -ball b - ball) (:init) (:goal (p a)))")
    scene = find_benchmark("pddl:d.pddl,p.pddl").tasks(Source())["q"].initial.scene
    assert [(thing.name, thing.category) for thing in scene.objects] == [("a", "ball"), ("b", "ball")]


@pytest.mark.parametrize(
    ("old", "new"), [("(?x -ball)", "(?x- ball)"), ("(:types ball)", "(:types ball- object)")]
)
def test_the_hyphen_before_a_type_needs_a_space_before_it(old: str, new: str) -> None:
    write(d=DASH.replace(old, new), p=PROBLEM)
    assert "expected a space before the hyphen, as in " in refusal("pddl:d.pddl,p.pddl")


def test_a_constant_may_be_declared_again_as_an_object_of_its_type() -> None:
    write(d=CONSTANT, p="(define (problem q) (:domain c) (:objects a b - t) (:init) (:goal (p a)))")
    scene = find_benchmark("pddl:d.pddl,p.pddl").tasks(Source())["q"].initial.scene
    assert [thing.name for thing in scene.objects] == ["a", "b"]


def test_a_constant_that_is_declared_again_with_another_type_is_refused_with_both_places() -> None:
    write(d=CONSTANT, p="(define (problem q) (:domain c)\n (:objects a - s) (:init) (:goal (p a)))")
    message = "p.pddl: line 2, column 12: expected a - t, as among the constants of d.pddl, line 3, not a - s"
    assert refusal("pddl:d.pddl,p.pddl") == message


def test_a_constant_of_another_type_is_refused_if_the_file_of_the_domain_is_unknown() -> None:
    domain = read_domain_text(CONSTANT, Path("d.pddl"))
    text = "(define (problem q) (:domain c) (:objects a) (:init) (:goal (p a)))"
    with pytest.raises(InputError, match=r"expected a - t, as among the constants of the domain, not a$"):
        read_problem_text(text, Path("p.pddl"), domain)


def test_a_constant_that_is_declared_twice_in_a_domain_is_refused() -> None:
    write(d=CONSTANT.replace("a - t)", "a - t\n a - s)", 1), p=PROBLEM)
    assert refusal("pddl:d.pddl,p.pddl") == "d.pddl: line 4, column 2: expected a once only (:constants)"


def test_another_domain_than_that_of_a_problem_is_named_with_its_file() -> None:
    write(d=CONSTANT, p=PROBLEM)
    message = "p.pddl: line 2, column 3: expected (:domain c), as in d.pddl, not (:domain two)"
    assert refusal("pddl:d.pddl,p.pddl") == message
    write(d=TWO.replace("domain two", "domain c"))
    assert refusal("pddl:d.pddl,p.pddl") == message
    write(p=PROBLEM.replace("(:domain two)", ""))
    assert tasks_of("pddl:d.pddl,p.pddl") == ["q"]


def test_all_bad_files_of_a_folder_are_named() -> None:
    write(a=PROBLEM.replace("(r a)", "(r c)"), b=PROBLEM, c=PROBLEM + ")", d=TWO)
    first, second = refusal("pddl:d.pddl,.").split("\n")
    assert first.startswith("a.pddl: line 5, column 12: expected a declared object, not c (goal)")
    assert second.startswith("c.pddl: line 6, column 1: expected the end of the file")


@pytest.mark.parametrize("reference", ["pddl:world", "pddl:world/", "pddl:world/domain.pddl,world/problems/"])
def test_a_folder_may_have_its_domain_in_it(reference: str) -> None:
    Path("world/problems").mkdir(parents=True)
    write(**{"world/domain": TWO, "world/problems/p1": PROBLEM})
    write(**{"world/problems/p2": PROBLEM.replace("problem q", "problem r"), "world/problems/copy": TWO})
    if "," not in reference:
        Path("world/problems/copy.pddl").unlink()
    assert tasks_of(reference) == ["q", "r"]


def test_a_change_below_a_folder_is_noticed() -> None:
    Path("world/problems").mkdir(parents=True)
    write(**{"world/domain": TWO, "world/problems/p1": PROBLEM})
    assert tasks_of("pddl:world") == ["q"]
    write(**{"world/problems/p2": PROBLEM.replace("problem q", "problem r")})
    assert tasks_of("pddl:world") == ["q", "r"]


def test_a_change_of_a_file_after_a_blank_is_noticed() -> None:
    write(d=TWO, p=PROBLEM)
    assert tasks_of("pddl:d.pddl, p.pddl") == ["q"]
    write(p=PROBLEM.replace("problem q", "problem longer"))
    assert tasks_of("pddl:d.pddl, p.pddl") == ["longer"]


@pytest.mark.parametrize("reference", ["t.jsonl", "obfuscated:t.jsonl", "t/"])
def test_a_change_of_the_base_of_a_task_file_is_noticed(reference: str) -> None:
    Path("t").mkdir()
    write(d=TWO, p=PROBLEM)
    base = find_benchmark("pddl:d.pddl,p.pddl")
    for file in ("t.jsonl", "t/t.jsonl"):
        line = write_task_line(base.tasks(Source())["q"], "pddl:d.pddl,p.pddl", base.domain)
        Path(file).write_text(f"{line}\n")
    before = find_benchmark(reference)
    assert find_benchmark(reference) is before
    write(d=TWO.replace("(define (domain two)", "(define (domain two) ; changed"))
    assert find_benchmark(reference) is not before


def test_a_folder_without_one_domain_or_without_problems_is_refused() -> None:
    Path("world").mkdir()
    assert refusal("pddl:world") == "world: expected one file *.pddl that defines a domain, found none"
    write(**{"world/a": TWO})
    assert refusal("pddl:world") == "world: expected problems in files *.pddl, beside the domain world/a.pddl"
    write(**{"world/b": TWO})
    assert refusal("pddl:world").endswith("found 2 of them: world/a.pddl, world/b.pddl")
    assert "a folder with both" in refusal("pddl:nowhere") or "with both in it" in refusal("pddl:nowhere")


def test_a_file_of_a_domain_is_known_by_its_definition() -> None:
    write(a=f";(define (problem x))\n{TWO}", b=PROBLEM, c=TWO + PROBLEM, e="")
    assert [is_domain_file(Path(f"{name}.pddl")) for name in "abcef"] == [True, False, False, False, False]


def test_a_folder_of_pddl_that_is_checked_as_task_files_says_how_to_name_it() -> None:
    write(d=TWO)
    with pytest.raises(InputError, match=r"expected task files, .*; its files of PDDL are pddl:\.$"):
        find_task_files(Path())


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_named_pipe_is_refused_at_once() -> None:
    os.mkfifo("d.pddl")
    write(p=PROBLEM)
    assert refusal("pddl:d.pddl,p.pddl").startswith("d.pddl: is a named pipe")


def test_a_problem_without_its_domain_file_is_read_as_before() -> None:
    write(p=PROBLEM)
    assert read_problem_file(Path("p.pddl"), read_domain_text(TWO, Path("d.pddl"))).problem.name == "q"
