"""The folder of a survey: names, metadata, manifest, trace files."""
