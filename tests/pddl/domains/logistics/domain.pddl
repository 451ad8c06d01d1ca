; Parcels go by truck within a city and by aeroplane between cities.
(define (domain logistics)
  (:requirements :strips :typing)
  (:types
    parcel vehicle - thing
    truck aeroplane - vehicle
    airport - place
    thing place city - object)
  (:predicates
    (at ?t - thing ?p - place)
    (in ?p - parcel ?v - vehicle)
    (part-of ?p - place ?c - city))

  (:action load
    :parameters (?p - parcel ?v - vehicle ?where - place)
    :precondition (and (at ?p ?where) (at ?v ?where))
    :effect (and (not (at ?p ?where)) (in ?p ?v)))

  (:action unload
    :parameters (?p - parcel ?v - vehicle ?where - place)
    :precondition (and (in ?p ?v) (at ?v ?where))
    :effect (and (not (in ?p ?v)) (at ?p ?where)))

  (:action drive
    :parameters (?t - truck ?from ?to - place)
    :precondition (and (at ?t ?from) (exists (?c - city) (and (part-of ?from ?c) (part-of ?to ?c))))
    :effect (and (not (at ?t ?from)) (at ?t ?to)))

  (:action fly
    :parameters (?a - aeroplane ?from ?to - airport)
    :precondition (at ?a ?from)
    :effect (and (not (at ?a ?from)) (at ?a ?to))))
