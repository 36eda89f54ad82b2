#include "app/files/files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>

#include "core/error.hpp"

namespace trammel {

namespace {

[[noreturn]] void refuse_writing(const std::filesystem::path& path, int error) {
  throw StoreError({.what = std::string("could not write the file: ") + std::strerror(error),
                    .where = {.file = path.string()},
                    .hint = "is there space, and may this user write there?"});
}

/// 0, or errno.
int write_all(int descriptor, std::string_view content) {
  while (!content.empty()) {
    const ssize_t n = ::write(descriptor, content.data(), content.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    content.remove_prefix(static_cast<std::size_t>(n));
  }
  return ::fsync(descriptor) == 0 ? 0 : errno;
}

void sync_folder(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);  // some file systems can't: the rename itself stays atomic
  ::close(descriptor);
}

}  // namespace

std::string read_file(const std::filesystem::path& path, std::size_t max_bytes) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    throw NotFoundError({.what = "no such file", .where = {.file = path.string()}});
  }
  if (std::filesystem::is_directory(path, error)) {
    throw InputError(
        {.what = "this is a folder", .where = {.file = path.string()}, .expected = "a file"});
  }
  std::ifstream in(path, std::ios::binary);
  std::string content;
  content.reserve(4096);
  for (char block[65536]; in.read(block, sizeof block) || in.gcount() > 0;) {
    content.append(block, static_cast<std::size_t>(in.gcount()));
    if (content.size() > max_bytes) {
      throw InputError({.what = "the file is too large",
                        .where = {.file = path.string()},
                        .expected = "at most " + std::to_string(max_bytes) + " bytes"});
    }
  }
  if (in.bad() || !in.eof()) {
    throw InputError({.what = "could not read the file", .where = {.file = path.string()}});
  }
  return content;
}

void write_file_atomically(const std::filesystem::path& path, std::string_view content) {
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  std::string temporary = (folder / ("." + path.filename().string() + ".XXXXXX")).string();
  const int descriptor = ::mkostemp(temporary.data(), O_CLOEXEC);
  if (descriptor < 0) refuse_writing(path, errno);
  int error = write_all(descriptor, content);
  if (::fchmod(descriptor, 0644) != 0 && error == 0) error = errno;
  if (::close(descriptor) != 0 && error == 0) error = errno;
  if (error == 0 && std::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
  if (error != 0) {
    ::unlink(temporary.c_str());
    refuse_writing(path, error);
  }
  sync_folder(folder);
}

void append_line_durably(const std::filesystem::path& path, std::string_view line) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor < 0) refuse_writing(path, errno);
  int error = write_all(descriptor, std::string(line) + "\n");
  if (::close(descriptor) != 0 && error == 0) error = errno;
  if (error != 0) refuse_writing(path, error);
  sync_folder(path.has_parent_path() ? path.parent_path() : ".");
}

}  // namespace trammel
