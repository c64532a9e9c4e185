"""Neutral readers that several rooms share: JSON documents and the VRML/BT text form."""
