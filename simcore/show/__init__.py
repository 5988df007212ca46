"""What people look at: pictures, pages, the browser view and replays."""
