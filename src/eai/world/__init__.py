"""The typed core: objects, predicates, states, operators, domains; execution and diagnosis."""
