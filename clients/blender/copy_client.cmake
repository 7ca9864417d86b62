# Copies the built Python client without python3's cache files.
file(COPY ${FROM} DESTINATION ${TO} PATTERN __pycache__ EXCLUDE)
