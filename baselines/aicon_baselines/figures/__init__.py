"""Figures and films of real rollouts."""
