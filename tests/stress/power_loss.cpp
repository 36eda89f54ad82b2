#include "tests/stress/power_loss.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <fstream>

#include "tests/stress/recorder.hpp"
#include "tests/support/temporary.hpp"

namespace trammel::test {

namespace {

constexpr std::size_t kSectorBytes = 512;
using Kind = DiskOperation::Kind;

void put(std::string& content, std::size_t at, const std::string& bytes) {
  if (content.size() < at + bytes.size()) content.resize(at + bytes.size(), '\0');
  content.replace(at, bytes.size(), bytes);
}

void apply_to(std::string& content, const DiskOperation& operation) {
  const auto at = static_cast<std::size_t>(operation.offset);
  operation.kind == Kind::truncate ? content.resize(at, '\0') : put(content, at, operation.bytes);
}

/// Some sectors of a write; a truncate happens or not.
void apply_torn(std::string& content, const DiskOperation& operation, Random& random) {
  if (operation.kind == Kind::truncate) {
    if (random.below(2) == 0) apply_to(content, operation);
    return;
  }
  for (std::size_t at = 0; at < operation.bytes.size(); at += kSectorBytes) {
    if (random.below(2) == 0) continue;
    put(content, static_cast<std::size_t>(operation.offset) + at,
        operation.bytes.substr(at, kSectorBytes));
  }
}

/// What the cache had when the power went, in the order in which it came to the disk.
std::string survived(std::string content, std::vector<DiskOperation> cache, int kind,
                     Random& random) {
  const bool any_order = kind == 4 || kind == 7;
  if (any_order) {
    for (std::size_t k = cache.size(); k > 1; --k) std::swap(cache[k - 1], cache[random.below(k)]);
  }
  for (std::size_t k = 0; k < cache.size(); ++k) {
    const DiskOperation& operation = cache[k];
    const bool last = k + 1 == cache.size();
    if (kind == 0) continue;
    if (kind >= 2 && kind <= 4 && random.below(2) == 0) continue;
    if (kind == 6 || kind == 7) {
      apply_torn(content, operation, random);
    } else if (kind == 5 && last && operation.kind == Kind::write) {
      put(content, static_cast<std::size_t>(operation.offset),
          operation.bytes.substr(0, random.below(operation.bytes.size() + 1)));
    } else {
      apply_to(content, operation);
    }
  }
  return content;
}

// The log in memory between processes is gone with them.
bool is_memory(const std::string& file) { return file.ends_with("-shm"); }

bool is_log(const std::string& file) {
  return file.ends_with("-wal") || file.ends_with("-journal");
}

std::filesystem::path write_image(const std::filesystem::path& folder,
                                  const std::map<std::string, std::string>& image) {
  std::filesystem::remove_all(folder);
  std::filesystem::create_directory(folder);
  for (const auto& [path, content] : image) {
    std::ofstream(folder / std::filesystem::path(path).filename(), std::ios::binary) << content;
  }
  return folder / "lab.db";
}

}  // namespace

std::vector<LogEntry> record_log(const std::filesystem::path& folder, int n_points,
                                 Durability durability) {
  std::vector<LogEntry> log;
  const WatchedDisk disk([&log](const DiskOperation& operation) {
    const bool changes = operation.kind == Kind::write || operation.kind == Kind::truncate ||
                         operation.kind == Kind::sync || operation.kind == Kind::remove;
    if (changes && !is_memory(operation.file)) log.push_back({operation, 0});
    return SQLITE_OK;
  });
  const Recording recording = record(
      folder / "lab.db", n_points,
      [&log, last = 0](int told) mutable {
        if (told > last) log.push_back({{}, last = told});
      },
      [durability](store::Connection& db) {
        if (durability == Durability::full) return;
        sqlite3_set_authorizer(db.handle(), nullptr, nullptr);
        db.execute("PRAGMA synchronous = NORMAL");
      });
  if (recording.reported || recording.acknowledged != n_points) {
    throw std::runtime_error("the session was not recorded: " + recording.error);
  }
  return log;
}

void CachedDisk::apply(const DiskOperation& operation) {
  File& file = files_[operation.file];
  switch (operation.kind) {
    case Kind::sync:
      if (lies_) return;
      for (const DiskOperation& write : file.unsynced) apply_to(file.durable, write);
      file.unsynced.clear();
      // With the first sync of a log or journal SQLite syncs the folder: what was removed is gone.
      if (!file.there && is_log(operation.file)) forget_removed();
      file.there = true;
      break;
    case Kind::remove:
      file.removed = true;
      break;
    default:
      if (file.removed) file = {};
      file.unsynced.push_back(operation);
  }
}

void CachedDisk::forget_removed() {
  std::erase_if(files_, [](const auto& entry) { return entry.second.removed; });
}

bool CachedDisk::has_unsynced() const {
  return std::ranges::any_of(files_, [](const auto& entry) {
    return !entry.second.unsynced.empty() || entry.second.removed;
  });
}

std::map<std::string, std::string> CachedDisk::image(int kind, Random& random) const {
  std::map<std::string, std::string> files;
  for (const auto& [path, file] : files_) {
    if (file.removed && (kind == 1 || random.below(2) == 0)) continue;
    if (!file.there && kind == 0) continue;
    files[path] = survived(file.durable, file.unsynced, kind, random);
  }
  return files;
}

PowerLossCount lose_power(const std::filesystem::path& folder, const PowerLossOptions& options) {
  const std::vector<LogEntry> log = record_log(folder, options.n_points, options.durability);
  PowerLossCount count;
  Random random(options.seed);
  CachedDisk disk(options.lies);
  int told = 0;
  for (const LogEntry& entry : log) {
    if (entry.told > 0) {
      told = entry.told;
      continue;
    }
    disk.apply(entry.operation);
    if (count.operations++ % options.every != 0) continue;
    const int kinds = disk.has_unsynced() ? CachedDisk::kKinds : 1;
    for (int kind = 0; kind < kinds; ++kind) {
      const auto file = write_image(folder / "image", disk.image(kind, random));
      const Found found = look_at(file);
      ++count.images;
      count.corrupt += found.opens && found.verifies ? 0 : 1;
      count.lost_images += found.n_points < told ? 1 : 0;
      count.lost_points = std::max(count.lost_points, told - found.n_points);
      if (count.first_problem.empty() && (found.n_points < told || !found.problem.empty())) {
        count.first_problem = "operation " + std::to_string(count.operations) + ", kind " +
                              std::to_string(kind) + ": " + std::to_string(found.n_points) +
                              " of " + std::to_string(told) + " points; " + found.problem;
      }
      if (options.first_loss && count.lost_images > 0) return count;
      if (options.resume_every == 0 || count.images % options.resume_every != 0) continue;
      ++count.resumed;
      const Recording rest = record(file, options.n_points);
      const Found whole = look_at(file);
      const bool right = rest.state == session::State::done && whole.verifies &&
                         whole.n_points == options.n_points;
      count.wrong_resumes += right ? 0 : 1;
      if (!right && count.first_problem.empty()) count.first_problem = rest.error + whole.problem;
    }
  }
  return count;
}

}  // namespace trammel::test
