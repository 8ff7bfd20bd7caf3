"""What signals say: spectra, bands, identified modes. No machine in it."""
