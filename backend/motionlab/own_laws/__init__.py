"""Laws of one's own: a file to begin with, and what is checked before a server takes one."""
