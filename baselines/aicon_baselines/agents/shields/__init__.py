"""Policies of others behind a shield: who proposes, what guards it, and the worlds for both."""
