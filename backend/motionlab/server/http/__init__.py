"""Requests and answers, before and after the routes: limits, security, problems, documents."""
