"""Optimisers side by side on the same questions: who is better, by how much, and how sure is that?"""
