"""Numerical stability, proven on the driver at hand: named cases and random ones, for every registered method.

A case (:mod:`.case`) is a promise with a bound; it asks the laboratory (:mod:`.lab`) for pictures, which holds every one of
them to what all pictures promise, and gives back one number. The battery (:mod:`.battery`) compares numbers with bounds.
"""
