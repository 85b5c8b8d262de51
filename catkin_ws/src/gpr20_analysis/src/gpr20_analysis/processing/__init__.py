"""Steps on the Dataset of a survey, each a plain function, and chains of them."""
