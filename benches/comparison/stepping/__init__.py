"""One step of resolved rate towards a pose, as each library takes it: pose in, joint rates out.

Every step is Panda's, of the same joint positions and goals: error of the pose, rates that take it away in 0.1 s,
within the velocity limits where the library has them.
"""
