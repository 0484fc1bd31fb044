"""Any table by its axes: columns, filters, units and labels, its rows kept or worked out."""
