"""The pictures of the documentation; a module with a function `make` makes one group of them."""
