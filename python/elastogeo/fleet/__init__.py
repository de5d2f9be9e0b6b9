"""Commands over the campaigns of many robots: ``python -m elastogeo.fleet``; see the page docs/fleet.md."""
