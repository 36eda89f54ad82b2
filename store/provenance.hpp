#pragma once

#include <string>

namespace trammel::store {

/// Which program made a row. Recorded, never part of a key.
struct Provenance {
  std::string tool_version;
  std::string git_revision;
  std::string compiler;
  std::string libraries;
  std::string cpu_level;  // x86-64-v3 where AVX2, FMA and BMI2 are there, else x86-64
};
Provenance this_program();

}  // namespace trammel::store
