"""The papers' numbers beside ours: one module per paper, and the scorecard over all of them."""
