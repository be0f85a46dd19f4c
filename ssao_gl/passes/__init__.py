"""The passes: each module declares passes of one kind as data, with the one draw that does them."""
