"""One experiment on many virtual antennas that differ in their numbers."""

from gimbal_hil.proof.campaign.campaign import TABLE_FILE, Campaign, Done, run_campaign
from gimbal_hil.proof.campaign.page import campaign_page
from gimbal_hil.proof.campaign.spreads import NumberSpread, spreads_of

__all__ = [
    "TABLE_FILE",
    "Campaign",
    "Done",
    "NumberSpread",
    "campaign_page",
    "run_campaign",
    "spreads_of",
]
