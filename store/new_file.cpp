#include "store/new_file.hpp"

#include <fcntl.h>
#include <unistd.h>

namespace trammel::store {

Partial::~Partial() {
  std::error_code ignored;
  for (const char* suffix : {"", "-wal", "-shm", "-journal"}) {
    std::filesystem::remove(path.string() + suffix, ignored);
  }
}

void sync(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = descriptor >= 0 && ::fsync(descriptor) == 0;
  if (descriptor >= 0) ::close(descriptor);
  if (!synced) {
    throw StoreError({.what = "the copy could not be synced", .where = {.file = path.string()}});
  }
}

CheckReport whole(Connection& connection, const std::filesystem::path& file) {
  CheckReport report = verify(connection);
  if (report.ok()) return report;
  throw StoreError({.what = "the database is damaged, and so would be its copy",
                    .where = {.file = file.string()},
                    .got = report.findings.front(),
                    .hint = "see `trammel db verify`"});
}

}  // namespace trammel::store
