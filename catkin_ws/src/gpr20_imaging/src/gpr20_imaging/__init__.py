"""Focused images, candidates and exports of stored surveys, beside the storage."""
