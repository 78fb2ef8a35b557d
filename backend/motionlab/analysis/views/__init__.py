"""Views of a recording: circular test, errors along the path, friction, cost, positioning."""
