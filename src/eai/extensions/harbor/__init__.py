"""Tasks as folders for Harbor: written by `eai export harbor`, scored in the verifier's container."""
