"""Figures of surveys and images."""
