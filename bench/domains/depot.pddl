; Trucks carry crates between places, where a hoist piles them on pallets.
(define (domain depot)
  (:requirements :strips :typing)
  (:types
    pallet crate - surface
    truck hoist place surface - object)
  (:predicates
    (truck-at ?t - truck ?p - place)
    (hoist-at ?h - hoist ?p - place)
    (at ?s - surface ?p - place)
    (on ?c - crate ?s - surface)
    (in ?c - crate ?t - truck)
    (lifts ?h - hoist ?c - crate)
    (free ?h - hoist)
    (clear ?s - surface))

  (:action drive
    :parameters (?t - truck ?from ?to - place)
    :precondition (truck-at ?t ?from)
    :effect (and (not (truck-at ?t ?from)) (truck-at ?t ?to)))

  (:action lift
    :parameters (?h - hoist ?c - crate ?s - surface ?p - place)
    :precondition (and (hoist-at ?h ?p) (free ?h) (at ?c ?p) (on ?c ?s) (clear ?c))
    :effect (and (not (at ?c ?p)) (not (on ?c ?s)) (not (clear ?c)) (not (free ?h)) (lifts ?h ?c) (clear ?s)))

  (:action drop
    :parameters (?h - hoist ?c - crate ?s - surface ?p - place)
    :precondition (and (hoist-at ?h ?p) (at ?s ?p) (clear ?s) (lifts ?h ?c))
    :effect (and (not (lifts ?h ?c)) (not (clear ?s)) (free ?h) (at ?c ?p) (clear ?c) (on ?c ?s)))

  (:action load
    :parameters (?h - hoist ?c - crate ?t - truck ?p - place)
    :precondition (and (hoist-at ?h ?p) (truck-at ?t ?p) (lifts ?h ?c))
    :effect (and (not (lifts ?h ?c)) (free ?h) (in ?c ?t)))

  (:action unload
    :parameters (?h - hoist ?c - crate ?t - truck ?p - place)
    :precondition (and (hoist-at ?h ?p) (truck-at ?t ?p) (free ?h) (in ?c ?t))
    :effect (and (not (in ?c ?t)) (not (free ?h)) (lifts ?h ?c))))
