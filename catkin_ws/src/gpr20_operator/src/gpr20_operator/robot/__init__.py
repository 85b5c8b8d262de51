"""The robot and its survey as a screen knows them: states, faults, cards, requests."""
