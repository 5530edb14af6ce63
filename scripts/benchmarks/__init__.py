"""What `crowdnav benchmark` measures, one module per section; `timing` says how."""
