"""`tendon state`: one state worked out line by line, and a figure of its motor."""
