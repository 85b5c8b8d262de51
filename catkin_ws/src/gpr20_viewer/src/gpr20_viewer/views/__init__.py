"""The window of the viewer: only this folder imports Qt."""
