(define (problem two-cities)
  (:domain logistics)
  (:objects
    letter box - parcel
    van lorry - truck
    plane - aeroplane
    home - place
    heathrow tegel - airport
    london berlin - city)
  (:init
    (at letter home) (at box tegel) (at van heathrow) (at lorry tegel) (at plane tegel)
    (part-of home london) (part-of heathrow london) (part-of tegel berlin))
  (:goal (and (at letter tegel) (at box home))))
