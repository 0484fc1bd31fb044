"""Study files, read and validated. Every human mistake ends here."""
