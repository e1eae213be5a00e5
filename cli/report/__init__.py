"""HTML reports: each page is one file that needs no other."""
