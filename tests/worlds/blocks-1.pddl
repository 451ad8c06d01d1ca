(define (problem swap) (:domain blocks)
  (:objects a b c)
  (:init (ontable a) (on b a) (clear b) (ontable c) (clear c) (handempty))
  (:goal (and (on a b) (on b c))))
