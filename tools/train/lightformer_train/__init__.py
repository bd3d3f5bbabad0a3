"""Trains the networks of lightformer/net in PyTorch; README.md says which module does what."""
