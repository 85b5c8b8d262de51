"""The result of a survey: its places on one image, and what is done with them."""
