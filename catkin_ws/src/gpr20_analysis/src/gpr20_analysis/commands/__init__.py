"""The command gpr20: one module for each subcommand."""
