"""Recipes by topic; `recipe.TOPICS` lists the modules."""
