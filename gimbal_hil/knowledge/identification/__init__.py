"""Friction identified from measured motion, every number with an interval and a verdict."""

from gimbal_hil.knowledge.identification.averaging import MeanEstimate, mean_with_error
from gimbal_hil.knowledge.identification.axis_identification import (
    AxisIdentification,
    axes_to_identify,
    friction_of,
    identify_axis,
    numbers_of_motion,
)
from gimbal_hil.knowledge.identification.axis_motion import RigidAxisRule, centred_torque, regression_rule
from gimbal_hil.knowledge.identification.axis_response import AxisRecord, simulate_axis
from gimbal_hil.knowledge.identification.consistency import (
    BreakAway,
    break_away,
    break_away_below_sliding,
    break_away_findings,
)
from gimbal_hil.knowledge.identification.estimate import DataWarning, Determination, Estimate, Interval
from gimbal_hil.knowledge.identification.evidence import Evidence, Log, collect
from gimbal_hil.knowledge.identification.model_update import updated_model
from gimbal_hil.knowledge.identification.output_error import OutputErrorFit, OutputErrorRule, fit_output_error
from gimbal_hil.knowledge.identification.over_temperature import (
    TemperatureGroup,
    TemperatureResult,
    as_warm_as,
    at_temperature,
    grouped,
    has_table,
    require_a_table,
    table_csv,
    table_record,
    with_rows,
)
from gimbal_hil.knowledge.identification.over_temperature_page import over_temperature_page
from gimbal_hil.knowledge.identification.over_temperature_text import over_temperature_lines
from gimbal_hil.knowledge.identification.pages import identification_page, identification_record
from gimbal_hil.knowledge.identification.presliding import PreslidingFit, PreslidingRun, fit_presliding
from gimbal_hil.knowledge.identification.reading import read_logs
from gimbal_hil.knowledge.identification.rigid_axis import RigidAxisFit, fit_rigid_axis
from gimbal_hil.knowledge.identification.segments import Stretch, TorqueSource, stretches_of_run, stretches_of_table
from gimbal_hil.knowledge.identification.sliding import MapHalf, StaticFit, fit_static
from gimbal_hil.knowledge.identification.steadiness import SteadyRule, SteadyWindow, find_steady_window
from gimbal_hil.knowledge.identification.stribeck import LUGRE_NAMES, LugreFriction, StaticFriction
from gimbal_hil.knowledge.identification.timing import Timing
from gimbal_hil.knowledge.identification.torque_scale import IN_TURNS
from gimbal_hil.knowledge.identification.unsmoothed import Unsmoothed, unsmoothed
from gimbal_hil.knowledge.identification.velocity_map import (
    Plateau,
    VelocityMap,
    VelocityPoint,
    measure_velocity_map,
    rate_jitter,
)

__all__ = [
    "IN_TURNS",
    "LUGRE_NAMES",
    "AxisIdentification",
    "AxisRecord",
    "BreakAway",
    "DataWarning",
    "Determination",
    "Estimate",
    "Evidence",
    "Interval",
    "Log",
    "LugreFriction",
    "MapHalf",
    "MeanEstimate",
    "OutputErrorFit",
    "OutputErrorRule",
    "Plateau",
    "PreslidingFit",
    "PreslidingRun",
    "RigidAxisFit",
    "RigidAxisRule",
    "StaticFit",
    "StaticFriction",
    "SteadyRule",
    "SteadyWindow",
    "Stretch",
    "TemperatureGroup",
    "TemperatureResult",
    "Timing",
    "TorqueSource",
    "Unsmoothed",
    "VelocityMap",
    "VelocityPoint",
    "as_warm_as",
    "at_temperature",
    "axes_to_identify",
    "break_away",
    "break_away_below_sliding",
    "break_away_findings",
    "centred_torque",
    "collect",
    "find_steady_window",
    "fit_output_error",
    "fit_presliding",
    "fit_rigid_axis",
    "fit_static",
    "friction_of",
    "grouped",
    "has_table",
    "identification_page",
    "identification_record",
    "identify_axis",
    "mean_with_error",
    "measure_velocity_map",
    "numbers_of_motion",
    "over_temperature_lines",
    "over_temperature_page",
    "rate_jitter",
    "read_logs",
    "regression_rule",
    "require_a_table",
    "simulate_axis",
    "stretches_of_run",
    "stretches_of_table",
    "table_csv",
    "table_record",
    "unsmoothed",
    "updated_model",
    "with_rows",
]
