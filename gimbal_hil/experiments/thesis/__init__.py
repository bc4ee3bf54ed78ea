"""The thesis that this project grew from, run again: controller tables, unbalance, friction, and what does not hold."""
