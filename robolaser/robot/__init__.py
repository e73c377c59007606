"""The arm: where its joints and its flange are, what they bear, what it could hit; arms by name."""
