"""Files of users, the data store, published archives, and entry points."""
