"""The paper's mechanics: quaternions, attitude, Euler variables, body, state, frame, forces' base, system."""
