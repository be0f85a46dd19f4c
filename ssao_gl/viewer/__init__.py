"""A scene in the browser: what is sent there, the page that shows it, and the widget of notebooks."""
