"""What replaces the wires: pins, SPI, VXI-11, the shared record of the truth."""
