"""The parts of the comparison with other libraries: the arm, the libraries, and one module per thing measured."""
