; Couriers drive vans along roads and walk along paths: static relations decide what can be reached.
(define (domain courier)
  (:requirements :typing :negative-preconditions)
  (:types place locatable - object
          courier van parcel - locatable)
  (:predicates
    (at ?x - locatable ?p - place)
    (aboard ?x - locatable ?v - van)
    (empty ?v - van)
    (road ?from ?to - place)
    (path ?from ?to - place)
    (curfew))
  (:action enter
    :parameters (?c - courier ?v - van ?p - place)
    :precondition (and (at ?c ?p) (at ?v ?p) (empty ?v))
    :effect (and (not (at ?c ?p)) (aboard ?c ?v) (not (empty ?v))))
  (:action leave
    :parameters (?c - courier ?v - van ?p - place)
    :precondition (and (aboard ?c ?v) (at ?v ?p))
    :effect (and (not (aboard ?c ?v)) (at ?c ?p) (empty ?v)))
  (:action drive
    :parameters (?c - courier ?v - van ?from ?to - place)
    :precondition (and (aboard ?c ?v) (at ?v ?from) (road ?from ?to) (not (curfew)))
    :effect (and (not (at ?v ?from)) (at ?v ?to)))
  (:action walk
    :parameters (?c - courier ?from ?to - place)
    :precondition (and (at ?c ?from) (path ?from ?to))
    :effect (and (not (at ?c ?from)) (at ?c ?to)))
  (:action load
    :parameters (?x - parcel ?v - van ?p - place)
    :precondition (and (at ?x ?p) (at ?v ?p))
    :effect (and (not (at ?x ?p)) (aboard ?x ?v)))
  (:action unload
    :parameters (?x - parcel ?v - van ?p - place)
    :precondition (and (aboard ?x ?v) (at ?v ?p))
    :effect (and (not (aboard ?x ?v)) (at ?x ?p))))
