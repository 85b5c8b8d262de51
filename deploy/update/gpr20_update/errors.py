"""What can go wrong."""


class UpdateError(Exception):
    """An update, a backup or a restore cannot be done; the text says why and what to do."""
