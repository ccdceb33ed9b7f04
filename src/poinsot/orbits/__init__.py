"""Where the body is with respect to what attracts it."""
