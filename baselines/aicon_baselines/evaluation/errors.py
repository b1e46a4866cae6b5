"""The one error of this package that a user can cause and mend."""


class ComparisonError(ValueError):
    """Something was asked for that does not exist or does not fit; the message says what would."""
