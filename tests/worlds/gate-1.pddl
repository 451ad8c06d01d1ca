(define (problem castle) (:domain gate)
  (:init (locked) (guarded))
  (:goal (and (inside) (not (guarded)))))
