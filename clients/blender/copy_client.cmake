# The Python client as it was built, without what python3 left beside it.
file(COPY ${FROM} DESTINATION ${TO} PATTERN __pycache__ EXCLUDE)
