"""Machines by the hundred that are drawn, measured and identified: `make draws`, see CONTRIBUTING."""
