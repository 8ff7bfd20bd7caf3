"""Records: files as loggers write them, read into channels of samples on one clock."""
