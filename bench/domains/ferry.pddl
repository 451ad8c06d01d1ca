; A ferry carries cars from place to place, one at a time.
(define (domain ferry)
  (:requirements :strips :typing)
  (:types car place)
  (:predicates
    (at ?c - car ?p - place)
    (ferry-at ?p - place)
    (ferry-empty)
    (on-ferry ?c - car))

  (:action sail
    :parameters (?from ?to - place)
    :precondition (ferry-at ?from)
    :effect (and (not (ferry-at ?from)) (ferry-at ?to)))

  (:action board
    :parameters (?c - car ?p - place)
    :precondition (and (at ?c ?p) (ferry-at ?p) (ferry-empty))
    :effect (and (not (at ?c ?p)) (not (ferry-empty)) (on-ferry ?c)))

  (:action leave
    :parameters (?c - car ?p - place)
    :precondition (and (on-ferry ?c) (ferry-at ?p))
    :effect (and (not (on-ferry ?c)) (ferry-empty) (at ?c ?p))))
