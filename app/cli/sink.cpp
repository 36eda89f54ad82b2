#include "app/cli/sink.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "app/files/output_name.hpp"
#include "core/error.hpp"

namespace trammel::cli {

Sink::Sink(std::filesystem::path path, Existing existing)
    : path_(std::move(path)), existing_(existing), caught_(nullptr), before_(-1) {
  require_free(path_, existing_);
  std::fflush(stdout);
  caught_ = std::tmpfile();
  before_ = ::dup(STDOUT_FILENO);
  if (caught_ != nullptr && before_ >= 0 && ::dup2(::fileno(caught_), STDOUT_FILENO) >= 0) return;
  throw StoreError({.what = std::string("no place for what is printed: ") + std::strerror(errno),
                    .where = {.file = path_.string()}});
}

Sink::~Sink() {
  restore();
  std::fclose(caught_);
}

void Sink::restore() {
  if (before_ < 0) return;
  std::fflush(stdout);
  ::dup2(before_, STDOUT_FILENO);
  ::close(std::exchange(before_, -1));
}

void Sink::deliver() {
  const bool whole = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  std::clearerr(stdout);
  restore();
  if (!whole) {
    throw StoreError({.what = "could not keep all of what is printed",
                      .where = {.file = path_.string()},
                      .hint = "is there space for temporary files?"});
  }
  std::string content;
  std::rewind(caught_);
  for (char block[65536]; const std::size_t n = std::fread(block, 1, sizeof block, caught_);) {
    content.append(block, n);
  }
  write_output(path_, content, existing_);
}

}  // namespace trammel::cli
