"""One experiment on many virtual antennas that differ in their numbers."""

from gimbal_hil.campaign.campaign import TABLE_FILE, Campaign, Done, run_campaign
from gimbal_hil.campaign.page import campaign_page
from gimbal_hil.campaign.spreads import NumberSpread, spreads_of

__all__ = [
    "TABLE_FILE",
    "Campaign",
    "Done",
    "NumberSpread",
    "campaign_page",
    "run_campaign",
    "spreads_of",
]
