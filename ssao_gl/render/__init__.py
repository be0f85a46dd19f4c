"""Drawing: the headless renderer, the pass for other people's programs, and the arrays that come back."""
