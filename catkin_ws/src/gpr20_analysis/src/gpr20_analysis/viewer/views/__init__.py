"""The window of the viewer: only this folder of the analysis imports Qt."""
