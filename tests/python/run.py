# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""pytest on the words; 77, and a word, where there is none."""
import sys

try:
    import pytest
except ImportError:
    print("skipped: pytest (python3-pytest) is not here")
    sys.exit(77)
sys.exit(pytest.main(["-q", "-p", "no:cacheprovider", *sys.argv[1:]]))
