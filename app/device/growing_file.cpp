#include "app/device/growing_file.hpp"

#include <algorithm>
#include <chrono>
#include <system_error>

#include "app/files/files.hpp"
#include "core/error.hpp"

namespace trammel::device {

namespace {

constexpr std::size_t kMaxGrowingBytes = 256u << 20;

[[noreturn]] void unreadable_file(const std::filesystem::path& file, const std::string& what) {
  throw DeviceError({.what = what, .where = {.file = file.string()}});
}

std::uintmax_t size_of(const std::filesystem::path& file) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (!error) return size;
  if (error == std::errc::no_such_file_or_directory) return 0;
  unreadable_file(file, error.message());
}

std::string all_bytes(const std::filesystem::path& file) {
  try {
    return size_of(file) == 0 ? "" : read_file(file, kMaxGrowingBytes);
  } catch (const InputError& error) {
    unreadable_file(file, error.what());
  }
}

}  // namespace

std::string complete_lines(const std::filesystem::path& file) {
  std::string text = all_bytes(file);
  text.resize(text.rfind('\n') + 1);  // npos + 1 is 0: no line at all
  return text;
}

void GrowingFile::mark() {
  const std::string text = all_bytes(file_);
  seen_bytes_ = text.size();
  lines_before_ = static_cast<int>(std::count(text.begin(), text.end(), '\n'));
  if (!text.empty() && !text.ends_with('\n')) ++lines_before_;
}

std::optional<std::string> GrowingFile::grown() {
  const std::uintmax_t size = size_of(file_);
  if (size < seen_bytes_) {
    unreadable_file(file_, "the file has become shorter: replaced, or begun anew");
  }
  if (size == seen_bytes_) return std::nullopt;
  seen_bytes_ = size;
  return complete_lines(file_);
}

std::optional<double> age_s(const std::filesystem::path& file) {
  std::error_code error;
  const auto written = std::filesystem::last_write_time(file, error);
  if (error == std::errc::no_such_file_or_directory) return std::nullopt;
  if (error) unreadable_file(file, error.message());
  const auto now = std::filesystem::file_time_type::clock::now();
  return std::chrono::duration<double>(now - written).count();
}

}  // namespace trammel::device
