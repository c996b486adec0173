"""Figures of a campaign: which laws converge to which references, from where, how fast, and what is left.

They are drawn from the two tables that a campaign leaves: `starts`, a row a run, and `cells`, a row for every law and
family of references; both in scenario units. Laws and families stand in the order of the tables.
"""

from nhtrack.studies.campaign.plots.distributions import late_errors, settling
from nhtrack.studies.campaign.plots.files import save_campaign_figures
from nhtrack.studies.campaign.plots.maps import grid_map
from nhtrack.studies.campaign.plots.shares import share_map
from nhtrack.studies.campaign.plots.starts import start_map

__all__ = ["grid_map", "late_errors", "save_campaign_figures", "settling", "share_map", "start_map"]
