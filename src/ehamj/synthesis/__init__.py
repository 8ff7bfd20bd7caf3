"""Laws that are found on the linearised machine, under stated margins."""
