"""External things of the height sensor: the SPI bus and the converter on it."""
