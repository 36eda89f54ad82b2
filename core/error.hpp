#pragma once
// One base for everything that stops a command: what, where, got, expected, and what to do next.
// Expected outcomes (unreachable, not converged, beam lost) are values, not exceptions.

#include <stdexcept>
#include <string>

namespace trammel {

/// Documented in --help and the README; CLI11's own codes are mapped to these.
enum class ExitCode {
  ok = 0,
  error = 1,
  usage = 2,
  not_found = 3,
  invalid_data = 4,
  not_acceptable = 5,
  safety_stop = 6,
  device = 7,
  storage = 8,
  interrupted = 130,
};

/// Where bad input stands. Fields that do not apply stay empty or 0.
struct Where {
  std::string file = {};
  int line = 0;    // from 1
  int column = 0;  // from 1
  std::string field = {};
  std::string point = {};
};

/// The parts of a message for a person. Only `what` is always there.
struct ErrorText {
  std::string what;
  Where where = {};
  std::string got = {};
  std::string expected = {};
  std::string hint = {};
};

class Error : public std::runtime_error {
 public:
  Error(ExitCode code, ErrorText text);
  [[nodiscard]] ExitCode code() const noexcept { return code_; }
  [[nodiscard]] const ErrorText& text() const noexcept { return text_; }

 private:
  ExitCode code_;
  ErrorText text_;
};

struct UsageError : Error {
  explicit UsageError(ErrorText text) : Error(ExitCode::usage, std::move(text)) {}
};
struct NotFoundError : Error {
  explicit NotFoundError(ErrorText text) : Error(ExitCode::not_found, std::move(text)) {}
};
struct InputError : Error {
  explicit InputError(ErrorText text) : Error(ExitCode::invalid_data, std::move(text)) {}
};
struct SafetyError : Error {
  explicit SafetyError(ErrorText text) : Error(ExitCode::safety_stop, std::move(text)) {}
};
struct DeviceError : Error {
  explicit DeviceError(ErrorText text) : Error(ExitCode::device, std::move(text)) {}
};
struct StoreError : Error {
  explicit StoreError(ErrorText text) : Error(ExitCode::storage, std::move(text)) {}
};

/// One line: "file:line:column: what (field f, point p): got g, expected e; hint".
std::string describe(const ErrorText& text);

/// A broken promise inside the program, never of its input: says where and aborts.
[[noreturn]] void assertion_failed(const char* condition, const char* file, int line);

}  // namespace trammel

#define TRAMMEL_ASSERT(condition) \
  ((condition) ? static_cast<void>(0) : ::trammel::assertion_failed(#condition, __FILE__, __LINE__))
