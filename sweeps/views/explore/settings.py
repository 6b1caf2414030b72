"""The page's settings: tolerance, treatment of the noise, friction law, strain."""

from __future__ import annotations

from collections.abc import Callable

from bokeh.layouts import column
from bokeh.models import Column, Select

from stickslip.options import FRICTION_LAWS, METHODS, NOISE_TREATMENTS, STRAINS
from sweeps.config.load import Config, with_noise
from sweeps.config.schema import Noise, Section
from sweeps.views.explore.ranges import exact_text

_TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)
_WIDTH = 340  # pixels


class Settings:
    """Small controls for what a config says of the integration; `changed` is told of each."""

    def __init__(self, config: Config, changed: Callable[[], None]) -> None:
        self._changed, self._quiet = changed, False
        options = [exact_text(value) for value in _TOLERANCES]
        self.tolerance = self._select("tolerance (rtol), also of stationarity", options)
        self.noise = self._select("noise", list(NOISE_TREATMENTS))
        self.friction = self._select("friction law", list(FRICTION_LAWS))
        self.friction.visible = len(FRICTION_LAWS) > 1
        self.strain = self._select("strain", list(STRAINS))
        self._config = config
        self.show(config)

    @property
    def column(self) -> Column:
        """The controls, one below the other."""
        parts = self.tolerance, self.noise, self.friction, self.strain
        return column(*parts, name="settings", sizing_mode="stretch_width")

    def show(self, config: Config) -> None:
        """Stand at what a config says, without telling of it."""
        self._config, self._quiet = config, True
        rtol = exact_text(config.integrator.rtol)
        if rtol not in self.tolerance.options:
            self.tolerance.options = [*self.tolerance.options, rtol]
        self.tolerance.value, self.noise.value = rtol, config.noise.treatment
        self.friction.value, self.strain.value = config.film.friction, config.film.strain
        known = METHODS[config.integrator.method].strains
        self.strain.visible = config.film.strain in known and len(known) > 1
        self._quiet = False

    def applied(self, config: Config) -> Config:
        """A config with these settings; what was not changed stays as it is there."""
        rtol, update = float(self.tolerance.value), dict[str, Section]()
        stationary = config.stationary
        if rtol != config.integrator.rtol:
            update["integrator"] = config.integrator.model_copy(update={"rtol": rtol})
            update["stationary"] = stationary = stationary.model_copy(update={"rtol": rtol})
        if self.noise.value != config.noise.treatment:
            update |= with_noise(stationary, Noise(treatment=self.noise.value))
        film = {"friction": self.friction.value, "strain": self.strain.value}
        update["film"] = config.film.model_copy(update=film)
        return config.model_copy(update=update)

    def _select(self, title: str, options: list[str]) -> Select:
        select = Select(
            title=title,
            options=options,
            max_width=_WIDTH,
            name=title.split()[0],
            sizing_mode="stretch_width",
        )
        select.on_change("value", self._chosen)
        return select

    def _chosen(self, _attribute: str, _old: object, _new: object) -> None:
        if not self._quiet:
            self._changed()
