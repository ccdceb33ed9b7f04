"""Side-by-side measurements of poinsot and its peers; `make bench` writes docs/benchmarks.md."""
