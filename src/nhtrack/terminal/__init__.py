"""What commands share: the application they register with, tables, progress bars."""
