"""Description without an integrator: body, state, attitude, frames, forces, events, the system and its environment."""
