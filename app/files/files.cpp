#include "app/files/files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>

#include "app/files/output_name.hpp"
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

/// What is opened is closed.
struct Descriptor {
  explicit Descriptor(int n) : number(n) {}
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number;
};

bool is_pipe(int descriptor) {
  struct stat is = {};
  return ::fstat(descriptor, &is) == 0 && S_ISFIFO(is.st_mode);
}

// How long a pipe may have nobody at its other end, and how long somebody there may be silent.
constexpr int kWriterMs = 2'000;
constexpr int kSilenceMs = 60'000;

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
  const Descriptor in(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  std::string content;
  content.reserve(4096);
  for (char block[65536];;) {
    const ssize_t n = ::read(in.number, block, sizeof block);
    if (n > 0) content.append(block, static_cast<std::size_t>(n));
    if (content.size() > max_bytes) {
      throw InputError({.what = "the file is too large",
                        .where = {.file = path.string()},
                        .expected = "at most " + std::to_string(max_bytes) + " bytes"});
    }
    if (n > 0 || (n < 0 && errno == EINTR)) continue;
    const bool silent = n < 0 && errno == EAGAIN;
    if (n < 0 && !silent) {
      throw InputError({.what = "could not read the file", .where = {.file = path.string()}});
    }
    if (!silent && (!content.empty() || !is_pipe(in.number))) break;
    pollfd end{in.number, POLLIN, 0};
    if (::poll(&end, 1, silent ? kSilenceMs : kWriterMs) == 0) {
      throw InputError({.what = "nothing comes out of this pipe",
                        .where = {.file = path.string()},
                        .expected = "a file, or a pipe that another program writes into"});
    }
    if ((end.revents & POLLIN) == 0) break;  // who was there is gone
  }
  return content;
}

namespace {

constexpr std::string_view kDatabase = "database";
constexpr std::size_t kHeadBytes = 4096;  // "schema" and "format" stand at the beginning

/// What a file's first bytes show it to be: "database", "page", "JSON trammel/plan/1", "table".
std::string format_of(std::string_view content) {
  if (content.starts_with("SQLite format 3")) return std::string(kDatabase);
  const std::size_t first = content.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return "empty";
  content.remove_prefix(first);
  if (content.starts_with("<!") || content.starts_with("<html")) return "page";
  if (content[0] != '{' && content[0] != '[') return "text or table";
  content = content.substr(0, kHeadBytes);
  for (const std::string_view key : {"\"schema\"", "\"format\""}) {
    const std::size_t at = content.find(key);
    if (at == std::string_view::npos) continue;
    const std::size_t begin = content.find('"', at + key.size());
    const std::size_t end = begin == std::string_view::npos ? begin : content.find('"', begin + 1);
    if (end == std::string_view::npos) continue;
    return "JSON " + std::string(content.substr(begin + 1, end - begin - 1));
  }
  return "JSON";
}

bool is_journal(const std::filesystem::path& path) {
  for (const std::string_view suffix : {"-wal", "-shm", "-journal"}) {
    const std::string name = path.filename().string();
    if (!name.ends_with(suffix)) continue;
    std::error_code error;
    const std::string base = name.substr(0, name.size() - suffix.size());
    if (std::filesystem::exists(path.parent_path() / base, error)) return true;
  }
  return false;
}

std::string head_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string head(kHeadBytes, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  return head;
}

/// Refuses a regular file that output must not replace, whatever the output.
void require_free_file(const std::filesystem::path& path, Existing existing) {
  if (format_of(head_of(path)) == kDatabase || is_journal(path)) {
    throw InputError({.what = "a database is never replaced by output",
                      .where = {.file = path.string()},
                      .expected = "the name of a new file"});
  }
  if (existing == Existing::refuse) {
    throw InputError({.what = "the file is there already",
                      .where = {.file = path.string()},
                      .expected = "the name of a new file",
                      .hint = "--overwrite replaces it"});
  }
}

void require_same_format(const std::filesystem::path& path, std::string_view content) {
  const std::string is = format_of(head_of(path)), becomes = format_of(content);
  if (is == "empty" || is == becomes) return;
  throw InputError({.what = "a file of another format is not replaced",
                    .where = {.file = path.string()},
                    .got = is,
                    .expected = becomes + ", or the name of a new file"});
}

/// Devices and pipes: nothing to rename, and not all of them can be synced.
void write_through(const std::filesystem::path& path, std::string_view content) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) refuse_writing(path, errno);
  int error = write_all(descriptor, content);
  if (error == EINVAL || error == EROFS) error = 0;  // fsync of what has no disk
  if (::close(descriptor) != 0 && error == 0) error = errno;
  if (error != 0) refuse_writing(path, error);
}

/// A new file beside `path`, made under the umask; its name in `name`.
int open_beside(const std::filesystem::path& path, std::string& name) {
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  for (int k = 0;; ++k) {
    name = (folder / fmt::format(".{}.{}.{}", path.filename().string(), ::getpid(), k)).string();
    const int descriptor = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0 || errno != EEXIST) return descriptor;
  }
}

}  // namespace

void require_free(const std::filesystem::path& path, Existing existing) {
  if (path.empty()) {
    throw InputError({.what = "the name of the output file is empty", .expected = "a file's name"});
  }
  struct stat was = {};
  if (::stat(path.c_str(), &was) != 0) return;
  if (S_ISDIR(was.st_mode)) {
    throw InputError(
        {.what = "this is a folder", .where = {.file = path.string()}, .expected = "a file"});
  }
  if (S_ISREG(was.st_mode)) require_free_file(path, existing);
}

void write_output(const std::filesystem::path& given, std::string_view content, Existing existing) {
  require_free(given, existing);
  struct stat was = {};
  const bool there = ::stat(given.c_str(), &was) == 0;
  if (there && !S_ISREG(was.st_mode)) return write_through(given, content);
  std::error_code code;
  const auto resolved = std::filesystem::weakly_canonical(given, code);  // through symbolic links
  const std::filesystem::path path = code ? given : resolved;
  if (there) require_same_format(path, content);
  std::string temporary;
  const int descriptor = open_beside(path, temporary);
  if (descriptor < 0) refuse_writing(path, errno);
  int error = write_all(descriptor, content);
  if (there && ::fchmod(descriptor, was.st_mode & 07777) != 0 && error == 0) error = errno;
  if (::close(descriptor) != 0 && error == 0) error = errno;
  if (error == 0) {
    // A name that was free must still be free: link() does not replace, rename() does.
    if (there) {
      if (std::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
    } else if (::link(temporary.c_str(), path.c_str()) == 0) {
      ::unlink(temporary.c_str());
    } else if (errno == EEXIST || std::rename(temporary.c_str(), path.c_str()) != 0) {
      error = errno;  // file systems without links: renamed
    }
  }
  if (error != 0) {
    ::unlink(temporary.c_str());
    refuse_writing(path, error);
  }
  sync_folder(path.has_parent_path() ? path.parent_path() : ".");
}

void reserve_room(const std::filesystem::path& path, std::size_t n_bytes) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor < 0) refuse_writing(path, errno);
  const auto n = static_cast<off_t>(n_bytes);
  int error = ::fallocate(descriptor, FALLOC_FL_KEEP_SIZE, 0, n) == 0 ? 0 : errno;
  if (error == EOPNOTSUPP || error == ENOSYS) error = 0;
  if (error == 0 && ::fsync(descriptor) != 0) error = errno;
  ::close(descriptor);
  if (error != 0) refuse_writing(path, error);
  sync_folder(path.has_parent_path() ? path.parent_path() : ".");
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
