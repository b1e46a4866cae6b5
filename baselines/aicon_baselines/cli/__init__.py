"""The command `aicon`, and the skeleton that the scripts of the repository share with it."""
