; A net of relays: what has power is reached from a source, by paths of even or of odd length.
(define (domain relays)
  (:requirements :adl :derived-predicates)
  (:types node)
  (:constants source - node)
  (:predicates
    (wire ?a ?b - node)
    (cut ?a ?b - node)
    (joined ?a ?b - node)
    (powered ?a - node)
    (evenly ?a ?b - node)
    (oddly ?a ?b - node)
    (tested ?a - node))
  (:derived (joined ?a ?b - node) (and (wire ?a ?b) (not (cut ?a ?b))))
  (:derived (powered ?a - node) (or (= ?a source) (exists (?b - node) (and (powered ?b) (joined ?b ?a)))))
  (:derived (oddly ?a ?b - node) (or (joined ?a ?b) (exists (?c - node) (and (evenly ?a ?c) (joined ?c ?b)))))
  (:derived (evenly ?a ?c - node) (exists (?b - node) (and (oddly ?a ?b) (joined ?b ?c))))
  (:action cut-off
    :parameters (?a ?b - node)
    :precondition (and (wire ?a ?b) (not (cut ?a ?b)) (powered ?a))
    :effect (cut ?a ?b))
  (:action mend
    :parameters (?a ?b - node)
    :precondition (and (wire ?a ?b) (cut ?a ?b) (not (powered ?b)))
    :effect (not (cut ?a ?b)))
  (:action test
    :parameters (?a - node)
    :precondition (and (evenly source ?a) (not (tested ?a)))
    :effect (tested ?a)))
