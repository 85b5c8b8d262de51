"""The physics that window, visualization and analysis share; the simulator has its own."""
