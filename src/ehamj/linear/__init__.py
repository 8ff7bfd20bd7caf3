"""The machine about rest as one linear system: by itself, from sample to sample under a law, and its loop gains."""
