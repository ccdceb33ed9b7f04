/* Pages from disk may not fetch one another: the search there lists titles without summaries. */
if (location.protocol === "file:") DOCUMENTATION_OPTIONS.SHOW_SEARCH_SUMMARY = false;
