"""Parameters that follow from the others: the best of them within their bounds, for many candidates at once."""
