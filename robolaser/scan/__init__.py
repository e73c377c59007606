"""From stripes and a calibration to a cloud of points."""
