"""Work for several processes or machines, handed out by Dask."""
