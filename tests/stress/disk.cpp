#include "tests/stress/disk.hpp"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>

namespace trammel::test {

namespace {

constexpr const char* kName = "trammel-watched";

DiskHook hook_now;
sqlite3_vfs* real_vfs = nullptr;
sqlite3_vfs watched;

struct File {
  sqlite3_file base;
  std::string* name;
  sqlite3_file* real() { return reinterpret_cast<sqlite3_file*>(this + 1); }
};

File* of(sqlite3_file* file) { return reinterpret_cast<File*>(file); }

int ask(DiskOperation::Kind kind, const std::string& file, std::int64_t offset = 0,
        std::string bytes = {}) {
  return hook_now({kind, file, offset, std::move(bytes)});
}

using Kind = DiskOperation::Kind;

int close_file(sqlite3_file* file) {
  File* f = of(file);
  const int code = f->real()->pMethods->xClose(f->real());
  delete f->name;
  return code;
}

int read_file(sqlite3_file* file, void* to, int n, sqlite3_int64 offset) {
  File* f = of(file);
  const int code = ask(Kind::read, *f->name, offset);
  return code != SQLITE_OK ? code : f->real()->pMethods->xRead(f->real(), to, n, offset);
}

int write_file(sqlite3_file* file, const void* from, int n, sqlite3_int64 offset) {
  File* f = of(file);
  const int code = ask(Kind::write, *f->name, offset,
                       std::string(static_cast<const char*>(from), static_cast<std::size_t>(n)));
  return code != SQLITE_OK ? code : f->real()->pMethods->xWrite(f->real(), from, n, offset);
}

int truncate_file(sqlite3_file* file, sqlite3_int64 size) {
  File* f = of(file);
  const int code = ask(Kind::truncate, *f->name, size);
  return code != SQLITE_OK ? code : f->real()->pMethods->xTruncate(f->real(), size);
}

int sync_file(sqlite3_file* file, int flags) {
  File* f = of(file);
  const int code = ask(Kind::sync, *f->name);
  return code != SQLITE_OK ? code : f->real()->pMethods->xSync(f->real(), flags);
}

int file_size(sqlite3_file* file, sqlite3_int64* size) {
  return of(file)->real()->pMethods->xFileSize(of(file)->real(), size);
}

int lock_file(sqlite3_file* file, int level) {
  File* f = of(file);
  const int code = ask(Kind::lock, *f->name);
  return code != SQLITE_OK ? code : f->real()->pMethods->xLock(f->real(), level);
}

int unlock_file(sqlite3_file* file, int level) {
  return of(file)->real()->pMethods->xUnlock(of(file)->real(), level);
}

int reserved_lock(sqlite3_file* file, int* held) {
  return of(file)->real()->pMethods->xCheckReservedLock(of(file)->real(), held);
}

int file_control(sqlite3_file* file, int what, void* argument) {
  return of(file)->real()->pMethods->xFileControl(of(file)->real(), what, argument);
}

int sector_size(sqlite3_file* file) {
  return of(file)->real()->pMethods->xSectorSize(of(file)->real());
}

int characteristics(sqlite3_file* file) {
  return of(file)->real()->pMethods->xDeviceCharacteristics(of(file)->real());
}

int map_memory(sqlite3_file* file, int page, int size, int extend, void volatile** memory) {
  File* f = of(file);
  const int code = ask(Kind::map, *f->name);
  return code != SQLITE_OK ? code
                           : f->real()->pMethods->xShmMap(f->real(), page, size, extend, memory);
}

int lock_memory(sqlite3_file* file, int offset, int n, int flags) {
  File* f = of(file);
  // An unlock can not fail.
  const int code = (flags & SQLITE_SHM_LOCK) != 0 ? ask(Kind::lock, *f->name) : SQLITE_OK;
  return code != SQLITE_OK ? code : f->real()->pMethods->xShmLock(f->real(), offset, n, flags);
}

void memory_barrier(sqlite3_file* file) {
  of(file)->real()->pMethods->xShmBarrier(of(file)->real());
}

int unmap_memory(sqlite3_file* file, int remove) {
  return of(file)->real()->pMethods->xShmUnmap(of(file)->real(), remove);
}

const sqlite3_io_methods kMethods = {
    .iVersion = 2,  // no memory-mapped reads: every read is seen
    .xClose = close_file,
    .xRead = read_file,
    .xWrite = write_file,
    .xTruncate = truncate_file,
    .xSync = sync_file,
    .xFileSize = file_size,
    .xLock = lock_file,
    .xUnlock = unlock_file,
    .xCheckReservedLock = reserved_lock,
    .xFileControl = file_control,
    .xSectorSize = sector_size,
    .xDeviceCharacteristics = characteristics,
    .xShmMap = map_memory,
    .xShmLock = lock_memory,
    .xShmBarrier = memory_barrier,
    .xShmUnmap = unmap_memory,
    .xFetch = nullptr,
    .xUnfetch = nullptr,
};

int open_file(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  File* f = of(file);
  f->base.pMethods = nullptr;
  const std::string path = name != nullptr ? name : "";
  const int code = ask(Kind::open, path);
  if (code != SQLITE_OK) return code;
  const int opened = real_vfs->xOpen(real_vfs, name, f->real(), flags, out_flags);
  if (f->real()->pMethods == nullptr) return opened;
  f->name = new std::string(path);
  f->base.pMethods = &kMethods;
  return opened;
}

int remove_file(sqlite3_vfs*, const char* name, int sync_folder) {
  const int code = ask(Kind::remove, name);
  return code != SQLITE_OK ? code : real_vfs->xDelete(real_vfs, name, sync_folder);
}

// SQLite opens a folder for one purpose: to sync it.
using OpenFolder = int (*)(const char* file, int* descriptor);
OpenFolder real_open_folder = nullptr;

int open_folder(const char* file, int* descriptor) {
  const int code = ask(Kind::names, file);
  return code != SQLITE_OK ? code : real_open_folder(file, descriptor);
}

void set_open_folder(OpenFolder how) {
  real_vfs->xSetSystemCall(real_vfs, "openDirectory", reinterpret_cast<sqlite3_syscall_ptr>(how));
}

std::string path_of(int descriptor) {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(descriptor), error);
}

bool is_watched(const std::string& path) { return hook_now && path.ends_with(".unsaved.jsonl"); }

// Memory: SQLite's own allocator behind a count.
sqlite3_mem_methods own_memory;
std::int64_t n_asked = 0, fails_at = 0;
bool fails_on = false;

bool refused() {
  ++n_asked;
  return n_asked == fails_at || (fails_on && n_asked > fails_at);
}

void* give(int n) { return refused() ? nullptr : own_memory.xMalloc(n); }
void* give_more(void* memory, int n) {
  return refused() ? nullptr : own_memory.xRealloc(memory, n);
}

void use_memory(const sqlite3_mem_methods& methods) {
  sqlite3_shutdown();
  if (sqlite3_config(SQLITE_CONFIG_MALLOC, &methods) != SQLITE_OK ||
      sqlite3_initialize() != SQLITE_OK) {
    throw std::runtime_error("SQLite takes no other allocator while a database is open");
  }
}

}  // namespace

WatchedDisk::WatchedDisk(DiskHook hook) {
  hook_now = std::move(hook);
  real_vfs = sqlite3_vfs_find("unix");
  watched = *real_vfs;
  watched.zName = kName;
  watched.szOsFile = static_cast<int>(sizeof(File)) + real_vfs->szOsFile;
  watched.xOpen = open_file;
  watched.xDelete = remove_file;
  sqlite3_vfs_register(&watched, 1);
  real_open_folder =
      reinterpret_cast<OpenFolder>(real_vfs->xGetSystemCall(real_vfs, "openDirectory"));
  set_open_folder(&open_folder);
}

WatchedDisk::~WatchedDisk() {
  set_open_folder(real_open_folder);
  hook_now = {};
  sqlite3_vfs_unregister(&watched);
  sqlite3_vfs_register(real_vfs, 1);
}

ScarceMemory::ScarceMemory(std::int64_t nth, bool for_good) {
  sqlite3_initialize();
  if (sqlite3_config(SQLITE_CONFIG_GETMALLOC, &own_memory) != SQLITE_OK) {
    sqlite3_shutdown();
    sqlite3_config(SQLITE_CONFIG_GETMALLOC, &own_memory);
  }
  sqlite3_mem_methods counted = own_memory;
  counted.xMalloc = give;
  counted.xRealloc = give_more;
  fails_at = 0;
  fails_on = false;
  use_memory(counted);
  n_asked = 0;
  fails_at = nth;
  fails_on = for_good;
}

ScarceMemory::~ScarceMemory() {
  fails_at = 0;
  fails_on = false;
  use_memory(own_memory);
}

std::int64_t ScarceMemory::asked() { return n_asked; }

}  // namespace trammel::test

// The side file is written without SQLite: calls of write and fsync from our own code come here
// (the linker's --wrap, CMakeLists.txt).
extern "C" {
ssize_t __real_write(int descriptor, const void* from, size_t n);
int __real_fsync(int descriptor);

ssize_t __wrap_write(int descriptor, const void* from, size_t n) {
  using namespace trammel::test;
  struct stat before {};
  if (hook_now) ::fstat(descriptor, &before);
  const ssize_t written = __real_write(descriptor, from, n);
  if (!hook_now || written <= 0) return written;
  if (const std::string path = path_of(descriptor); is_watched(path)) {
    hook_now({DiskOperation::Kind::write, path, before.st_size,
              std::string(static_cast<const char*>(from), static_cast<std::size_t>(written))});
  }
  return written;
}

int __wrap_fsync(int descriptor) {
  using namespace trammel::test;
  const int code = __real_fsync(descriptor);
  if (!hook_now || code != 0) return code;
  const std::string path = path_of(descriptor);
  if (is_watched(path)) hook_now({DiskOperation::Kind::sync, path});
  if (std::filesystem::is_directory(path)) {
    hook_now({DiskOperation::Kind::names, path + "/."});
  }
  return code;
}
}
