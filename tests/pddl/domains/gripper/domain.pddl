; A robot with two hands carries balls from room to room; each action has a cost.
(define (domain gripper)
  (:requirements :strips :typing :action-costs)
  (:types room ball hand)
  (:constants left right - hand)
  (:predicates
    (robot-in ?r - room)
    (in ?b - ball ?r - room)
    (free ?h - hand)
    (carries ?h - hand ?b - ball))
  (:functions (total-cost) - number)

  (:action move
    :parameters (?from ?to - room)
    :precondition (robot-in ?from)
    :effect (and (not (robot-in ?from)) (robot-in ?to) (increase (total-cost) 3)))

  (:action pick
    :parameters (?b - ball ?r - room ?h - hand)
    :precondition (and (in ?b ?r) (robot-in ?r) (free ?h))
    :effect (and (carries ?h ?b) (not (in ?b ?r)) (not (free ?h)) (increase (total-cost) 1)))

  (:action drop
    :parameters (?b - ball ?r - room ?h - hand)
    :precondition (and (carries ?h ?b) (robot-in ?r))
    :effect (and (in ?b ?r) (free ?h) (not (carries ?h ?b)) (increase (total-cost) 1))))
