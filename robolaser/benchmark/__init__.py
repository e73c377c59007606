"""Optimisers side by side on the same problems: who is better, by how much, and how sure is that?"""
