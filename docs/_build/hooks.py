"""MkDocs reads its hooks from here; what they do stands in the package beside."""

from handbook.site import on_files, on_page_content, on_page_markdown, on_post_build

__all__ = ["on_files", "on_page_content", "on_page_markdown", "on_post_build"]
