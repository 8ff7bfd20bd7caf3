"""A law as C99: all that happens between readings and valves' commands, from the tables of the stepping loop."""
