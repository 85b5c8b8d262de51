"""Driver of the network analyzer."""
