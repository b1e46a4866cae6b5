"""The policies that can be compared, by task and name."""
