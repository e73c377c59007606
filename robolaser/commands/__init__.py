"""What can be typed after `robolaser`, one file each; a command gathers, calls one function and prints."""
