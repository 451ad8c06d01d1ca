; A shunting yard: switches join tracks in threes, and wagons stand in numbered berths of tracks.
(define (domain shunting)
  (:requirements :adl)
  (:types track wagon berth lever - object)
  (:predicates
    (switch ?from ?to - track ?by - lever)
    (behind ?b ?c - berth)
    (stands ?w - wagon ?t - track ?b - berth)
    (free ?t - track ?b - berth)
    (thrown ?by - lever)
    (coupled ?v ?w - wagon ?t - track))
  (:action throw
    :parameters (?by - lever)
    :precondition (not (thrown ?by))
    :effect (thrown ?by))
  (:action shunt
    :parameters (?w - wagon ?from ?to - track ?b ?c - berth ?by - lever)
    :precondition (and (stands ?w ?from ?b) (switch ?from ?to ?by) (thrown ?by) (free ?to ?c)
      (not (exists (?v - wagon ?t - track) (or (coupled ?v ?w ?t) (coupled ?w ?v ?t)))))
    :effect (and (not (stands ?w ?from ?b)) (stands ?w ?to ?c) (free ?from ?b) (not (free ?to ?c))
      (not (thrown ?by))))
  (:action couple
    :parameters (?v ?w - wagon ?t - track ?b ?c - berth)
    :precondition (and (stands ?v ?t ?b) (stands ?w ?t ?c) (behind ?b ?c))
    :effect (coupled ?v ?w ?t))
  (:action part
    :parameters (?t - track)
    :precondition (exists (?v ?w - wagon) (coupled ?v ?w ?t))
    :effect (forall (?v ?w - wagon) (when (coupled ?v ?w ?t) (not (coupled ?v ?w ?t))))))
