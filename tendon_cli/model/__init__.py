"""The physics: pure functions on arrays that broadcast, without files, units or column names."""
