"""Windows of pretension: a question, its choices solved, and the best of them."""
