"""Networks that the iterative-attention model is measured against: one file, one model."""
