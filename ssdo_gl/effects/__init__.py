"""One module for each effect: its settings, need, passes and terms; `registry` finds them."""
