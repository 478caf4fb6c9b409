"""Evidence: closed forms, reference cases and comparisons with other engines, all through the public interface."""
