"""Mathematics without mechanics: kernels, vectors, rotations, tables, sparse factorisation and eigenmodes."""
