"""Error against run time of every method, on any scene, camera, size and driver, with ray-traced truth.

:func:`~ssao_gl.report.run.Run` measures, a :class:`~ssao_gl.report.journal.Journal` keeps what is measured,
:func:`~ssao_gl.report.results.results` draws conclusions, and :func:`~ssao_gl.report.write.write` makes the page. Needs
the extras ``truth``, ``metrics`` and ``report`` (matplotlib); nothing of them is imported before it is used.
"""
