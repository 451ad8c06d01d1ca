"""The typed core: objects, predicates, states, operators, domains; execution, diagnosis and search."""
