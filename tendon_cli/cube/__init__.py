"""Any table by its axes: columns by name, filters, units and labels, whether its rows are kept or worked out."""
