"""What a command does from a design to the files that it writes; joins the build with the report of it."""
