"""Running a study: the plan, the evaluation of its parts, and the folder they are written to."""
