# Debian packages by component: cpack -G DEB.
