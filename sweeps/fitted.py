"""The parameters in a file of `stickslip fit`, from which `sample: {from: FILE}` draws."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stickslip.distributions import DistributionError, Joint, refuse_outside
from stickslip.variables import PARAMETERS
from sweeps.exits import StorageError
from sweeps.human import reason
from sweeps.watch import require_readable

if TYPE_CHECKING:
    import netCDF4

_NEEDED = ("value", "standard_error", "correlation", "determination")


class Fitted(NamedTuple):
    """The parameters of a fit, the name of its file as in the config, and the file's SHA-256."""

    joint: Joint
    file: str
    sha256: str

    def __str__(self) -> str:
        """Return the mean and the covariance of the draws as text for the result file."""
        joint = self.joint
        names = ", ".join(
            f"ln {name}" if is_log else name
            for name, is_log in zip(joint.names, joint.logarithmic, strict=True)
        )
        with np.errstate(divide="ignore"):  # only a parameter on a plain scale may be 0
            logs = np.log(np.abs(joint.middle))
        mean = np.where(joint.logarithmic, logs, joint.middle)
        covariance = joint.correlations * np.outer(joint.deviations, joint.deviations)
        return (
            f"{names} from {self.file} (sha256 {self.sha256}): mean {mean.tolist()}, "
            f"covariance {covariance.tolist()}"
        )


def fitted_parameters(path: Path, name: str) -> Fitted:
    """Return the parameters in the file of a fit; `name` is the name of the file in the config.

    Raises DistributionError if the file cannot be read or holds no fit, or if the data do not
    determine a parameter. The message is the end of a sentence.
    """
    import netCDF4  # reading the schema of configs does not need it

    try:
        require_readable(path)
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        with netCDF4.Dataset(path) as file:
            joint = _joint(file, name)
    except StorageError as error:
        raise DistributionError(f"names a file that cannot be read: {error}") from None
    except (OSError, RuntimeError, ValueError) as error:
        if isinstance(error, DistributionError):
            raise
        raise DistributionError(f"names {name}, which cannot be read: {reason(error)}") from None
    for parameter, probability in joint.outside.items():
        refuse_outside(parameter, probability)
    return Fitted(joint, name, digest)


def _joint(file: netCDF4.Dataset, name: str) -> Joint:
    """Return the distribution in a file of a fit; raises DistributionError."""
    needed = ("free_parameter", *(f"parameter_{what}" for what in _NEEDED))
    if lacking := [each for each in needed if each not in file.variables]:
        raise DistributionError(
            f"must be a file written by `stickslip fit`; {name} has no {lacking[0]}"
        )
    file.set_auto_mask(False)
    names = [str(each) for each in file["free_parameter"][...]]
    values, errors, correlations, codes = (
        np.asarray(file[f"parameter_{what}"][...], dtype=float) for what in _NEEDED
    )
    forms = str(getattr(file["parameter_standard_error"], "form", "")).split()
    count = len(names)
    if (
        not {*names} <= {*PARAMETERS}
        or not values.shape == errors.shape == codes.shape == (count,) == (len(forms),)
        or correlations.shape != (count, count)
    ):
        raise DistributionError(f"names {name}, which is not in the format of `stickslip fit`")
    for parameter, error, code in zip(names, errors, codes, strict=True):
        if code != 0 or not (np.isfinite(error) and error > 0.0):
            raise DistributionError(
                f"names {name}, whose data do not determine {parameter}: fit again with "
                f"{parameter} fixed, and give {parameter} a range here"
            )
    if not (np.isfinite(values).all() and np.isfinite(correlations).all()):
        raise DistributionError(f"names {name}, which lacks values or correlations")
    logarithmic = tuple(form == "logarithmic" for form in forms)
    # The file has errors of the values; the error of a logarithm is relative.
    deviations = np.where(logarithmic, errors / np.abs(np.where(values, values, 1.0)), errors)
    return Joint(tuple(names), values, deviations, correlations, logarithmic)
