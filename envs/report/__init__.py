"""The report of an evaluation as one HTML file, and pictures and videos of single episodes."""

from envs.report.page import build_report
from envs.report.replay import write_picture, write_video

__all__ = ["build_report", "write_picture", "write_video"]
