"""An emulated cell: an arm's controller and a camera with the interfaces of real ones."""
