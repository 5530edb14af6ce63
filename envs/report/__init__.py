"""Reports of evaluations and stress tests as one HTML file, pictures and videos of episodes."""

from envs.report.page import build_report
from envs.report.replay import write_picture, write_video
from envs.report.stress_files import write_stress
from envs.report.stress_page import build_stress_report

__all__ = ["build_report", "build_stress_report", "write_picture", "write_stress", "write_video"]
