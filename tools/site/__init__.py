"""The pages of the site that follow from the package: API, scenarios, examples."""
