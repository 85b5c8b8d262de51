"""The RADAR tab: A-, B- and C-scan."""
