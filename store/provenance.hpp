#pragma once

#include <string>

namespace trammel::store {

/// Which program made a row. Recorded, never part of a key.
struct Provenance {
  std::string tool_version;
  std::string git_revision;
  std::string compiler;
  std::string libraries;
  std::string cpu_level;  // x86-64-v4, x86-64-v3 or x86-64: the kernels that ran
};
Provenance this_program();

}  // namespace trammel::store
