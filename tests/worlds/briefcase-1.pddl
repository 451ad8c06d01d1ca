(define (problem commute) (:domain briefcase)
  (:objects home office - place paper pen - portable)
  (:init (is-at home) (at paper home) (at pen office))
  (:goal (and (at paper office) (forall (?o - portable) (not (in ?o))) (is-at home))))
