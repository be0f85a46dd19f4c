"""Measuring methods against truth and the clock: views, variants, timing, errors, and what follows from them."""
