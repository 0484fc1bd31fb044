"""Named axes with their roles, their product, and what each number is for a design. Knows nothing of study files."""
