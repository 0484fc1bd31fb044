"""`tendon state`: one state worked out line by line, and the motor drawn."""
