"""Every run can be seen: what is drawn of a mechanism, how it moves, and the pages, films and files made of it."""
