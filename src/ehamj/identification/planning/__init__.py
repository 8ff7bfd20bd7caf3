"""Which test next: what each of many tests would tell of each parameter, before it is made."""
