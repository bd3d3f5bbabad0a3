"""How good the pictures of a method are: on frames never trained on, against what a user would pick instead."""
