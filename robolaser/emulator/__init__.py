"""A cell that is not there: an arm's controller and a camera, spoken to as the real ones are."""
