"""Types of the names in `variables`. Made by `make generated`; do not edit."""

from typing import Any, ClassVar, Self

from stickslip.regime import Regime
from stickslip.status import Status

class ParameterValues(tuple[float, ...]):
    _fields: ClassVar[tuple[str, ...]]
    def __new__(cls, *args: Any, **kwargs: Any) -> Self: ...
    def _asdict(self) -> dict[str, float]: ...
    @property
    def temperature(self) -> float:
        """lubricant temperature, T [K]"""
    @property
    def viscosity_coefficient(self) -> float:
        """viscosity coefficient, k [Pa s^(gamma+1)]"""
    @property
    def spring_stiffness(self) -> float:
        """stiffness of each of the two springs, K [N m-1]"""
    @property
    def rheological_index(self) -> float:
        """rheological index, gamma [1]"""
    @property
    def angular_frequency(self) -> float:
        """angular frequency of the drive, omega [rad s-1]"""
    @property
    def drive_amplitude(self) -> float:
        """displacement amplitude of the drive, X_m [m]"""
    @property
    def block_mass(self) -> float:
        """mass of the lower block, M [kg]"""
    @property
    def initial_displacement(self) -> float:
        """initial displacement of the lower block, x_0 [m]"""
    @property
    def initial_velocity(self) -> float:
        """initial velocity of the lower block, v_0 [m s-1]"""
    @property
    def initial_order_parameter(self) -> float:
        """initial order parameter, phi_0 [1]"""
    @property
    def film_thickness(self) -> float:
        """thickness of the lubricant film, h [m]"""
    @property
    def strain_relaxation_time(self) -> float:
        """strain relaxation time, tau [s]"""
    @property
    def contact_area(self) -> float:
        """contact area of the blocks, A [m2]"""
    @property
    def kinetic_coefficient(self) -> float:
        """kinetic coefficient, delta [m3 J-1 s-1]"""
    @property
    def thermal_coefficient(self) -> float:
        """thermal coefficient of the free energy, alpha [J K-1 m-3]"""
    @property
    def critical_temperature(self) -> float:
        """critical temperature, T_c [K]"""
    @property
    def elastic_coefficient(self) -> float:
        """elastic coefficient of the free energy, a [Pa]"""
    @property
    def cubic_coefficient(self) -> float:
        """cubic coefficient of the free energy, b [J m-3]"""
    @property
    def quartic_coefficient(self) -> float:
        """quartic coefficient of the free energy, c [J m-3]"""
    @property
    def noise_intensity(self) -> float:
        """noise intensity, D [s-1]"""
    @property
    def quintic_coefficient(self) -> float:
        """quintic coefficient of the free energy, d [J m-3]"""
    @property
    def sextic_coefficient(self) -> float:
        """sextic coefficient of the free energy, e [J m-3]"""
    @property
    def third_harmonic(self) -> float:
        """amplitude of the drive's third harmonic, over X_m, a_3 [1]"""
    @property
    def fifth_harmonic(self) -> float:
        """amplitude of the drive's fifth harmonic, over X_m, a_5 [1]"""

class TypedParameters(ParameterValues):
    def __new__(
        cls,
        temperature: float = 200.0,
        viscosity_coefficient: float = 50000.0,
        spring_stiffness: float = 3000.0,
        rheological_index: float = -0.6666666666666666,
        angular_frequency: float = 10.0,
        drive_amplitude: float = 8e-07,
        block_mass: float = 0.4,
        initial_displacement: float = 0.0,
        initial_velocity: float = 0.0,
        initial_order_parameter: float = 0.0,
        film_thickness: float = 1e-09,
        strain_relaxation_time: float = 1e-08,
        contact_area: float = 6e-10,
        kinetic_coefficient: float = 100.0,
        thermal_coefficient: float = 0.95,
        critical_temperature: float = 290.0,
        elastic_coefficient: float = 4000000000000.0,
        cubic_coefficient: float = 230.0,
        quartic_coefficient: float = 850.0,
        noise_intensity: float = 1e-18,
        quintic_coefficient: float = 0.0,
        sextic_coefficient: float = 0.0,
        third_harmonic: float = 0.0,
        fifth_harmonic: float = 0.0,
        *,
        T: float = ...,
        k: float = ...,
        K: float = ...,
        gamma: float = ...,
        γ: float = ...,
        omega: float = ...,
        ω: float = ...,
        X_m: float = ...,
        M: float = ...,
        x_0: float = ...,
        v_0: float = ...,
        phi_0: float = ...,
        φ_0: float = ...,
        h: float = ...,
        tau: float = ...,
        τ: float = ...,
        A: float = ...,
        delta: float = ...,
        δ: float = ...,
        alpha: float = ...,
        α: float = ...,
        T_c: float = ...,
        a: float = ...,
        b: float = ...,
        c: float = ...,
        D: float = ...,
        d: float = ...,
        e: float = ...,
        a_3: float = ...,
        a_5: float = ...,
    ) -> Self: ...
    def _replace(
        self,
        *,
        temperature: float = ...,
        viscosity_coefficient: float = ...,
        spring_stiffness: float = ...,
        rheological_index: float = ...,
        angular_frequency: float = ...,
        drive_amplitude: float = ...,
        block_mass: float = ...,
        initial_displacement: float = ...,
        initial_velocity: float = ...,
        initial_order_parameter: float = ...,
        film_thickness: float = ...,
        strain_relaxation_time: float = ...,
        contact_area: float = ...,
        kinetic_coefficient: float = ...,
        thermal_coefficient: float = ...,
        critical_temperature: float = ...,
        elastic_coefficient: float = ...,
        cubic_coefficient: float = ...,
        quartic_coefficient: float = ...,
        noise_intensity: float = ...,
        quintic_coefficient: float = ...,
        sextic_coefficient: float = ...,
        third_harmonic: float = ...,
        fifth_harmonic: float = ...,
        T: float = ...,
        k: float = ...,
        K: float = ...,
        gamma: float = ...,
        γ: float = ...,
        omega: float = ...,
        ω: float = ...,
        X_m: float = ...,
        M: float = ...,
        x_0: float = ...,
        v_0: float = ...,
        phi_0: float = ...,
        φ_0: float = ...,
        h: float = ...,
        tau: float = ...,
        τ: float = ...,
        A: float = ...,
        delta: float = ...,
        δ: float = ...,
        alpha: float = ...,
        α: float = ...,
        T_c: float = ...,
        a: float = ...,
        b: float = ...,
        c: float = ...,
        D: float = ...,
        d: float = ...,
        e: float = ...,
        a_3: float = ...,
        a_5: float = ...,
    ) -> Self: ...

class TypedOrbit(tuple[Any, ...]):
    _fields: ClassVar[tuple[str, ...]]
    def __new__(cls, *args: Any, **kwargs: Any) -> Self: ...
    def _asdict(self) -> dict[str, Any]: ...
    def _replace(self, **kwargs: Any) -> Self: ...
    @property
    def elastic_stress_amplitude(self) -> float:
        """amplitude of the elastic stress, sigma_el,max [Pa]"""
    @property
    def friction_force_amplitude(self) -> float:
        """amplitude of the friction force, F_max [N]"""
    @property
    def elastic_stress_max(self) -> float:
        """maximum of the elastic stress over the stationary orbit, max sigma_el [Pa]"""
    @property
    def elastic_stress_min(self) -> float:
        """minimum of the elastic stress over the stationary orbit, min sigma_el [Pa]"""
    @property
    def friction_force_max(self) -> float:
        """maximum of the friction force over the stationary orbit, max F [N]"""
    @property
    def friction_force_min(self) -> float:
        """minimum of the friction force over the stationary orbit, min F [N]"""
    @property
    def dissipated_energy(self) -> float:
        """work of the drive per drive period, over the stationary orbit, W [J]"""
    @property
    def dissipated_energy_error(self) -> float:
        """estimated error of the dissipated energy, error of W [J]"""
    @property
    def amplitude_error(self) -> float:
        """estimated relative error of the worse of the two amplitudes, error [1]"""
    @property
    def power_balance_error(self) -> float:
        """relative violation of the power balance over the stationary orbit, power balance [1]"""
    @property
    def orbit_periods(self) -> int:
        """drive periods after which the stationary orbit closes, n [1]"""
    @property
    def melting_count(self) -> int:
        """number of solid to liquid transitions over the stationary orbit, meltings [1]"""
    @property
    def solid_transition_count(self) -> int:
        """number of changes between a soft and a hard solid over the stationary orbit, solid transitions [1]"""
    @property
    def asymmetry(self) -> float:
        """asymmetry of the elastic stress: |max + min| / (max - min), asymmetry [1]"""
    @property
    def periods_integrated(self) -> int:
        """drive periods integrated for this point, periods [1]"""
    @property
    def solid_fraction(self) -> float:
        """fraction of the time in which the film is solid, over the stationary orbit, solid fraction [1]"""
    @property
    def regime(self) -> Regime:
        """kind of motion of the orbit, regime [1]"""
    @property
    def floquet_multiplier(self) -> float:
        """modulus of the largest Floquet multiplier of the orbit, multiplier [1]"""
    @property
    def lyapunov_exponent(self) -> float:
        """largest Lyapunov exponent of an aperiodic orbit, per drive period, Lyapunov exponent [1]"""
    @property
    def elastic_stress_amplitude_spread(self) -> float:
        """standard deviation of the elastic stress amplitudes of single drive periods, spread of sigma_el,max [Pa]"""
    @property
    def friction_force_amplitude_spread(self) -> float:
        """standard deviation of the friction force amplitudes of single drive periods, spread of F_max [N]"""
    @property
    def friction_force_in_phase(self) -> float:
        """first harmonic of the friction force, in phase with the drive, F' [N]"""
    @property
    def friction_force_in_phase_error(self) -> float:
        """estimated error of the first harmonic in phase with the drive, error of F' [N]"""
    @property
    def friction_force_out_of_phase(self) -> float:
        """first harmonic of the friction force, in phase with the velocity of the drive, F'' [N]"""
    @property
    def friction_force_out_of_phase_error(self) -> float:
        """estimated error of the first harmonic in phase with the velocity of the drive, error of F'' [N]"""
    @property
    def friction_force_rms(self) -> float:
        """root mean square of the friction force over the stationary orbit, F_rms [N]"""
    @property
    def friction_force_mean_abs(self) -> float:
        """mean absolute value of the friction force over the stationary orbit, mean |F| [N]"""
    @property
    def status(self) -> Status:
        """how the computation of the point ended, status [1]"""
    @property
    def state(self) -> tuple[float, ...]: ...
