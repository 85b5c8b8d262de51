"""Probes of one computer: one external thing each."""
