(define (problem read-all)
  (:domain library)
  (:objects hall attic - room high low - shelf faust - book alps - atlas one two - lamp)
  (:init
    (watch-in hall) (stands-in high attic) (stands-in low hall) (lights one hall) (lights two attic)
    (on faust low) (on alps high))
  (:goal (and (forall (?p - print) (read ?p)) (closed))))
