"""The scorer as an environment, a reward function, and a batch job."""
