; A library with a night watch: quantifiers, conditional effects, a derived predicate, types above types.
(define (domain library)
  (:requirements :adl :derived-predicates)
  (:types
    book atlas - print
    print lamp - thing
    thing shelf room - object)
  (:constants desk - shelf)
  (:predicates
    (on ?p - print ?s - shelf)
    (stands-in ?s - shelf ?r - room)
    (lights ?l - lamp ?r - room)
    (lit ?l - lamp)
    (watch-in ?r - room)
    (read ?p - print)
    (dusty ?p - print)
    (bright ?r - room)
    (closed))

  (:derived (bright ?r - room)
    (exists (?l - lamp) (and (lights ?l ?r) (lit ?l))))

  ; Whoever changes rooms leaves the light on only where an atlas still lies open on the desk.
  (:action walk
    :parameters (?from ?to - room)
    :precondition (and (watch-in ?from) (not (= ?from ?to)) (not (closed)))
    :effect (and
      (not (watch-in ?from))
      (watch-in ?to)
      (forall (?l - lamp)
        (when (and (lights ?l ?from) (forall (?a - atlas) (not (on ?a desk)))) (not (lit ?l))))))

  (:action switch
    :parameters (?l - lamp ?r - room)
    :precondition (and (watch-in ?r) (lights ?l ?r))
    :effect (and (when (lit ?l) (not (lit ?l))) (when (not (lit ?l)) (lit ?l))))

  (:action browse
    :parameters (?s - shelf ?r - room)
    :precondition (and (watch-in ?r) (stands-in ?s ?r) (bright ?r))
    :effect (forall (?p - print) (when (and (on ?p ?s) (imply (dusty ?p) (not (on ?p desk)))) (read ?p))))

  ; What is put back on its own shelf stays there: an addition wins.
  (:action put
    :parameters (?p - print ?s - shelf)
    :precondition (exists (?r - room) (and (watch-in ?r) (or (stands-in ?s ?r) (= ?s desk))))
    :effect (and (forall (?other - shelf) (not (on ?p ?other))) (on ?p ?s) (dusty ?p)))

  (:action close
    :parameters ()
    :precondition (forall (?p - print) (read ?p))
    :effect (and (closed) (forall (?l - lamp) (not (lit ?l))))))
