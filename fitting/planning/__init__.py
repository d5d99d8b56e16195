"""Before the picture is taken: what a fit would know, and where one more lamp or camera would tell most."""
