#pragma once
// A text file that another program is writing.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace trammel::device {

/// A last line without its newline is still being written and is no line yet.
/// Proof: file_tracker_test.cpp.
class GrowingFile {
 public:
  explicit GrowingFile(std::filesystem::path file) : file_(std::move(file)) {}

  /// From now on, `new text` is what begins after this moment: the rest of a line that is
  /// half-written now belongs to the old ones. Throws DeviceError when the file can't be read; a
  /// file that does not exist yet is empty.
  void mark();
  /// Lines before the mark, a half-written one included.
  [[nodiscard]] int lines_before() const { return lines_before_; }
  /// All complete lines from the file's beginning; nothing when there are no more than at the last
  /// call or the mark. Throws DeviceError: the file can't be read, or has become shorter (replaced,
  /// or begun anew).
  std::optional<std::string> grown();

  [[nodiscard]] const std::filesystem::path& path() const { return file_; }

 private:
  std::filesystem::path file_;
  std::uintmax_t seen_bytes_ = 0;
  int lines_before_ = 0;
};

/// All complete lines of a file; empty where it is not there. Throws DeviceError.
std::string complete_lines(const std::filesystem::path& file);

/// Seconds since a file was written last; nothing where it is not there. Throws DeviceError.
std::optional<double> age_s(const std::filesystem::path& file);

}  // namespace trammel::device
