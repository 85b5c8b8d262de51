"""Updates of a robot in the field: `gpr20-update`, see docs/maintain.md.

It needs Python 3.8 and nothing else, so that it works whatever the update does to the rest.
"""
