"""The paper's benchmarks: what VirtualHome and BEHAVIOR declare, and what their published files bring."""
