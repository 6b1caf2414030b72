"""From a result back to its points: replay, the xarray accessor, pages to look around in."""
