"""Named axes of a study with their roles, and what each number is for a design."""
