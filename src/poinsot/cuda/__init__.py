"""Integration of ensembles on a GPU: kernels in CUDA C and their runs."""
