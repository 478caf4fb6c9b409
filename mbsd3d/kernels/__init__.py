"""Compiled kernels: free functions of ``(model, data)`` that know row primitives and force kinds, never joint types."""
