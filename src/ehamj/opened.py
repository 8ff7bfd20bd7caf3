"""What reads the channels of a NetCDF file as they are asked for; importing it takes as long as importing xarray."""

from xarray.backends import H5NetCDFStore


class Store(H5NetCDFStore):
    """Tells when nobody reads from it any more; of a module, so that a result that holds it can be pickled."""

    __slots__ = ("__weakref__",)
