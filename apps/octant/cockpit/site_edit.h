// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "models/site.h"
#include "models/support/result.h"

namespace octant::app {

/// Writes a text next to the site file, so that imports of its scene are found, and reads it as a site.
[[nodiscard]] Result<Site> read_text_as_site(const std::string& path, const std::string& text);

/// Changes to a site file that the operator accepts, with undo. The text of the file stays as it is, with
/// comments and scene; only what is changed differs.
class SiteEdit {
 public:
  explicit SiteEdit(std::string path) : path_(std::move(path)) {}

  /// Exchanges the ids of two beacons, so that each is at the other's place. The new text is read before it
  /// replaces the file. Errors: no such beacon, or an id that cannot be found in the text.
  [[nodiscard]] Result<void> exchange(const std::string& a, const std::string& b);
  /// Adds beacons of which only the names are known, after the last one.
  [[nodiscard]] Result<void> append(const std::vector<std::string>& names);
  /// Restores the file before the last change. Error: there is no change.
  [[nodiscard]] Result<void> undo();
  /// Changes that can be undone, oldest first, in words.
  [[nodiscard]] std::vector<std::string> changes() const;

 private:
  struct Change {
    std::string words, before, after;
  };
  std::string path_;
  std::vector<Change> changes_;
};

}  // namespace octant::app
