; The tower cannot be built part by part.
(define (problem sussman)
  (:domain blocksworld)
  (:objects a b c)
  (:init (on-table a) (on-table b) (on c a) (clear c) (clear b) (hand-empty))
  (:goal (and (on a b) (on b c))))
