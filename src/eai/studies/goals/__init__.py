"""Which goals are found, missed and made up."""
