"""The frame of the window: the band, STOP, the tabs, and where it is on the screen."""
