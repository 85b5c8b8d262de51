"""Blind trials: lanes with known targets, lists of candidates, and their score."""
