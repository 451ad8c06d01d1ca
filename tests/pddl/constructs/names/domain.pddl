(define (domain robot) (:types robot box) (:predicates (robot ?b - box) (box) (2nd ?r - robot) (box-1_x ?b - box ?r - robot))
(:action robot :parameters (?robot - robot ?b - box) :precondition (not (box-1_x ?b ?robot)) :effect (and (robot ?b) (box-1_x ?b ?robot)))
(:action 2nd :effect (box) :precondition () :parameters ())
(:action box :parameters (?r - robot) :precondition (and (box)) :effect (and (2nd ?r) (not (box)))))