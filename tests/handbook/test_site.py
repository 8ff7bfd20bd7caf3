"""The built site: it holds together by itself, and a reader finds what he came for."""
