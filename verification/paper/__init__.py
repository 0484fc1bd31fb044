"""The paper's studies, figures and findings."""
