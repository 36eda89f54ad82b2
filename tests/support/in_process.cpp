#include "tests/support/in_process.hpp"

#include <unistd.h>

#include <cstdio>
#include <stdexcept>

#include "app/cli/cli.hpp"
#include "app/cli/commands.hpp"

namespace trammel::tests {

namespace {

/// What is written to a stream of C goes to a file from here on, until the end.
class Caught {
 public:
  explicit Caught(std::FILE* stream)
      : stream_(stream), file_(std::tmpfile()), before_(dup(fileno(stream))) {
    std::fflush(stream_);
    if (file_ == nullptr || dup2(fileno(file_), fileno(stream_)) < 0) {
      throw std::runtime_error("cannot catch what is written");
    }
  }
  ~Caught() {
    release();
    close(before_);
    std::fclose(file_);
  }
  Caught(const Caught&) = delete;
  Caught& operator=(const Caught&) = delete;

  std::string text() {
    release();
    std::string all;
    std::rewind(file_);
    for (int c = std::fgetc(file_); c != EOF; c = std::fgetc(file_)) all += static_cast<char>(c);
    return all;
  }

 private:
  void release() {
    std::fflush(stream_);
    dup2(before_, fileno(stream_));
  }

  std::FILE* stream_;
  std::FILE* file_;
  int before_;
};

class Within {
 public:
  explicit Within(const std::filesystem::path& folder) : before_(std::filesystem::current_path()) {
    if (!folder.empty()) std::filesystem::current_path(folder);
  }
  ~Within() { std::filesystem::current_path(before_); }
  Within(const Within&) = delete;
  Within& operator=(const Within&) = delete;

 private:
  std::filesystem::path before_;
};

}  // namespace

Finished run_here(const std::vector<std::string>& words, const std::filesystem::path& folder) {
  const Within within(folder);
  Caught out(stdout), err(stderr);
  const int code = cli::run_cli(words, cli::commands());
  return {code, out.text(), err.text()};
}

}  // namespace trammel::tests
