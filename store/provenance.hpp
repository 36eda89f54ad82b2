#pragma once

#include <string>

namespace trammel::store {

/// Which program made a row. Recorded, never part of a key.
struct Provenance {
  std::string tool_version;
  std::string git_revision;
  std::string compiler;
  std::string libraries;
  std::string cpu_level;  // of the kernels that ran: name_of(CpuLevel)
};
Provenance this_program();

}  // namespace trammel::store
