"""Pictures of a comparison, one file each."""
