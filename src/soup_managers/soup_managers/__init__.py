"""The managers of the warehouse: word, letter and fleet manager, their policies, and the router."""
