"""What all tests of the package share."""
import signal

# Whoever is started in the background by a shell without job control has SIGINT ignored, and Python
# then leaves it so: tests of Ctrl-C need the handler that a terminal's programs have.
signal.signal(signal.SIGINT, signal.default_int_handler)
