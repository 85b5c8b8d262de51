"""The command gpr20: one module a subcommand."""
