(define (domain d7) (:requirements :strips :typing :equality :negative-preconditions) (:types car - vehicle vehicle - object place)
(:constants garage - place) ; comment (with) parentheses
(:predicates (at ?v - vehicle ?p - place) ; another
 (linked ?a ?b) (seen ?x - object))
(:action drive ;; odd
 :parameters (?v - car ?a ?b - place) :precondition (and (at ?v ?a) (not (= ?a ?b)) (or (linked ?a ?b) (= ?b garage))) :effect (and (not (at ?v ?a)) (at ?v ?b) (seen ?v) (seen ?b))))