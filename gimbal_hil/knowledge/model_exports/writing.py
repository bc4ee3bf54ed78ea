"""The formats by name, and a model in one of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from gimbal_hil.knowledge.model_exports.account import ExportedModel, items_of
from gimbal_hil.knowledge.model_exports.bam import bam_of
from gimbal_hil.knowledge.model_exports.curves import curves_of
from gimbal_hil.knowledge.model_exports.formats import ModelFormat
from gimbal_hil.knowledge.model_exports.isaac import isaac_of
from gimbal_hil.knowledge.model_exports.mjcf import mjcf_of
from gimbal_hil.knowledge.model_exports.urdf import urdf_of
from sim_backend.model import AntennaModel


def whole_antenna(model: AntennaModel) -> ExportedModel:
    """The virtual antenna itself as an FMU: it holds everything."""
    from sim_backend.fmu import fmu_of

    return ExportedModel(fmu_of(model), items_of(model), (), ())


FORMATS: Mapping[ModelFormat, Callable[[AntennaModel], ExportedModel]] = {
    ModelFormat.MJCF: lambda model: mjcf_of(model, has_dcmotor()),
    ModelFormat.URDF: urdf_of,
    ModelFormat.ISAAC: isaac_of,
    ModelFormat.BAM: bam_of,
    ModelFormat.CSV: curves_of,
    ModelFormat.FMU: whole_antenna,
}

#: what a MuJoCo without passive motors refuses
_PROBE = (
    '<mujoco><worldbody><body><joint name="a"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody>'
    '<actuator><dcmotor joint="a" input="none" motorconst="0 0" resistance="1" lugre="1 1 1 1 1"/></actuator></mujoco>'
)


def export_model(model: AntennaModel, wanted: ModelFormat) -> ExportedModel:
    """A model in another format, with what became of each of its numbers and effects."""
    return FORMATS[wanted](model)


def has_dcmotor() -> bool:
    """Whether the installed MuJoCo knows passive `dcmotor` actuators; true where none is installed: the newest does."""
    try:
        import mujoco
    except ImportError:
        return True
    try:
        mujoco.MjModel.from_xml_string(_PROBE)
    except ValueError:
        return False
    return True
