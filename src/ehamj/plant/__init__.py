"""What is simulated: the machine, where its isolators stand, and how its points move."""
