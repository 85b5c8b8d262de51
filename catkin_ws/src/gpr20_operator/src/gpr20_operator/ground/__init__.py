"""The ground of a survey: what is measured of it, its echoes, images and marks."""
