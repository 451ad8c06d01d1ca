(define (domain leer)	; für Müßiggänger – œuvre
(:predicates (p) (q))
(:action a :parameters () :precondition (and) :effect (and (p)))
(:action b :parameters () :precondition (and (p) (and)) :effect (and (q) (and))))