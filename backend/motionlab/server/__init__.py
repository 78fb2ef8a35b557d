"""The lab over HTTP: REST, errors, security."""
