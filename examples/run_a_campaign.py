"""Tries laws against references from a few random starts; the second call finds everything done."""

import nhtrack

few = {"tuning": None, "starts.count": 8, "families": ["rest", "sinus"], "duration": 40}
results = nhtrack.campaign("campaign/small", out="runs/few", set=few, processes=1)
print(results.cells[["law", "family", "converged", "starts", "share_low", "share_high"]].to_string(index=False))
again = nhtrack.campaign("campaign/small", out="runs/few", set=few, processes=1, figures=True)
print([path.name for path in again.files])
