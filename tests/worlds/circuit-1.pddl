(define (problem lamp) (:domain circuit)
  (:objects battery bulb motor - part)
  (:init (source battery) (switch battery) (wire battery bulb) (wire battery motor))
  (:goal (and (powered bulb) (powered motor))))
