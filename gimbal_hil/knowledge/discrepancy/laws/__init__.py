"""Laws where no name fits: what a gap looks like, as measured curves that a model file can hold."""

from gimbal_hil.knowledge.discrepancy.laws.curve import Curve
from gimbal_hil.knowledge.discrepancy.laws.finding import Described, DescribedLaw, described
from gimbal_hil.knowledge.discrepancy.laws.formula import Formula
from gimbal_hil.knowledge.discrepancy.laws.plug_in import effect_source
from gimbal_hil.knowledge.discrepancy.laws.shape import LawShape

__all__ = ["Curve", "Described", "DescribedLaw", "Formula", "LawShape", "described", "effect_source"]
