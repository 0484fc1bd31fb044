"""What is asked: study files, validated. Every human mistake ends here."""
