// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/support/scratch.h"

namespace octant {
namespace {

thread_local std::pmr::memory_resource* innermost = nullptr;

}  // namespace

Scratch::Scratch(std::size_t bytes)
    : buffer_(std::make_unique<std::byte[]>(bytes)), resource_(buffer_.get(), bytes) {}

ScratchScope::ScratchScope(Scratch& scratch) : scratch_(scratch), outer_(innermost) {
  innermost = &scratch.resource_;
}

ScratchScope::~ScratchScope() {
  innermost = outer_;
  scratch_.resource_.release();
}

std::pmr::memory_resource* scratch() { return innermost ? innermost : std::pmr::new_delete_resource(); }

}  // namespace octant
