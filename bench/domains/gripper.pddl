; A robot with two hands carries balls from room to room.
(define (domain gripper)
  (:requirements :strips :typing)
  (:types room ball hand)
  (:constants left right - hand)
  (:predicates
    (robot-in ?r - room)
    (in ?b - ball ?r - room)
    (free ?h - hand)
    (carries ?h - hand ?b - ball))

  (:action move
    :parameters (?from ?to - room)
    :precondition (robot-in ?from)
    :effect (and (not (robot-in ?from)) (robot-in ?to)))

  (:action pick
    :parameters (?b - ball ?r - room ?h - hand)
    :precondition (and (in ?b ?r) (robot-in ?r) (free ?h))
    :effect (and (carries ?h ?b) (not (in ?b ?r)) (not (free ?h))))

  (:action drop
    :parameters (?b - ball ?r - room ?h - hand)
    :precondition (and (carries ?h ?b) (robot-in ?r))
    :effect (and (in ?b ?r) (free ?h) (not (carries ?h ?b)))))
