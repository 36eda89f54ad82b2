#pragma once

#include <cstdio>
#include <filesystem>

#include "app/files/files.hpp"

namespace trammel::cli {

/// --out FILE of every command: what it prints to stdout goes into the file, whole or not at all.
///
/// From here on stdout is a file without a name; deliver() puts what was printed under `path` by
/// the rules of write_output. Without deliver() nothing is written. A name that would be refused is
/// refused before the command runs. Proof: sink_test.cpp.
class Sink {
 public:
  Sink(std::filesystem::path path, Existing existing);
  ~Sink();
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;

  void deliver();

 private:
  void restore();

  std::filesystem::path path_;
  Existing existing_;
  std::FILE* caught_;
  int before_;
};

}  // namespace trammel::cli
