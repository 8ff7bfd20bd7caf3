"""The laws that ehamj knows, one file each."""
