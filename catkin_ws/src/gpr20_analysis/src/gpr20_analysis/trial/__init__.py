"""Blind trials: lanes with known targets, sealed lists of candidates, and their score."""
