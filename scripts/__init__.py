"""The `crowdnav` program: one thin module per subcommand, imported without any heavy library."""
