#include "tests/stress/power_loss.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "tests/stress/recorder.hpp"
#include "tests/support/temporary.hpp"

namespace trammel::test {

namespace {

using Kind = DiskOperation::Kind;

void put(std::string& content, std::size_t at, const std::string& bytes) {
  if (content.size() < at + bytes.size()) content.resize(at + bytes.size(), '\0');
  content.replace(at, bytes.size(), bytes);
}

void apply_to(std::string& content, const DiskOperation& operation) {
  const auto at = static_cast<std::size_t>(operation.offset);
  operation.kind == Kind::truncate ? content.resize(at, '\0') : put(content, at, operation.bytes);
}

/// Some of the device's sectors of a write; a truncate happens or not.
void apply_torn(std::string& content, const DiskOperation& operation, std::size_t sector,
                Random& random) {
  if (operation.kind == Kind::truncate) {
    if (random.below(2) == 0) apply_to(content, operation);
    return;
  }
  const auto begin = static_cast<std::size_t>(operation.offset);
  const std::size_t end = begin + operation.bytes.size();
  for (std::size_t at = begin, next = 0; at < end; at = next) {
    next = std::min(end, (at / sector + 1) * sector);
    if (random.below(2) == 0) continue;
    put(content, at, operation.bytes.substr(at - begin, next - at));
  }
}

// The log in memory between processes is gone with them.
bool is_memory(const std::string& file) { return file.ends_with("-shm"); }

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

std::vector<LogEntry> record_log(const std::filesystem::path& folder,
                                 const RecordOptions& options) {
  std::vector<LogEntry> log;
  int told = 0;
  const auto tell = [&](int n) {
    if (n > told) log.push_back({{}, told = n});
  };
  int syncs = 0;  // of the database's log once it is to be full: the first is that of the intent
  const WatchedDisk disk([&](const DiskOperation& operation) {
    const bool of_log = operation.file.ends_with("-wal");
    if (of_log && operation.kind == Kind::write && syncs > 0) return SQLITE_FULL;
    if (of_log && operation.kind == Kind::sync && options.full_after > 0) {
      syncs += told >= options.full_after ? 1 : 0;
    }
    const bool changes = operation.kind == Kind::write || operation.kind == Kind::truncate ||
                         operation.kind == Kind::sync || operation.kind == Kind::names ||
                         operation.kind == Kind::remove;
    if (changes && !is_memory(operation.file)) log.push_back({operation, 0});
    return SQLITE_OK;
  });
  const Recording recording =
      record(folder / "lab.db", options.n_points, tell, [&options](store::Connection& db) {
        sqlite3_set_authorizer(db.handle(), nullptr, nullptr);
        if (options.durability == Durability::normal) db.execute("PRAGMA synchronous = NORMAL");
        if (options.durability == Durability::off) db.execute("PRAGMA synchronous = OFF");
        if (options.checkpoint_pages > 0) {
          sqlite3_wal_autocheckpoint(db.handle(), options.checkpoint_pages);
        }
      });
  const bool kept = recording.error.find("is kept in") != std::string::npos;
  if (kept) tell(told + 1);
  if (options.full_after > 0 ? !kept : told != options.n_points) {
    throw std::runtime_error("the session was not recorded: " + recording.error);
  }
  return log;
}

void CachedDisk::apply(const DiskOperation& operation) {
  ++n_;
  if (operation.kind == Kind::names) {
    if (lie_ == Lie::names) return;
    const auto folder = std::filesystem::path(operation.file).parent_path();
    for (auto at = files_.begin(); at != files_.end();) {
      const bool here = std::filesystem::path(at->first).parent_path() == folder;
      at->second.there |= here;
      at = here && at->second.removed ? files_.erase(at) : std::next(at);
    }
    return;
  }
  File& file = files_[operation.file];
  switch (operation.kind) {
    case Kind::sync:
      if (lie_ == Lie::sync) return;
      for (const Pending& write : file.unsynced) apply_to(file.durable, write.operation);
      file.unsynced.clear();
      break;
    case Kind::remove:
      file.removed = true;
      break;
    default:
      if (file.removed) file = {};
      file.unsynced.push_back({operation, n_});
  }
}

bool CachedDisk::has_unsynced() const {
  return std::ranges::any_of(files_, [](const auto& entry) {
    return !entry.second.unsynced.empty() || entry.second.removed || !entry.second.there;
  });
}

/// What the cache had when the power went, in the order in which it came to the disk.
std::string CachedDisk::survived(const File& file, int kind, std::uint64_t until, Random& random) {
  std::string content = file.durable;
  std::vector<Pending> cache = file.unsynced;
  const std::size_t sector = random.below(2) == 0 ? 512 : 4096;
  const bool whole = kind == 9 && random.below(2) == 0;
  if (kind == 4 || kind == 7) {
    for (std::size_t k = cache.size(); k > 1; --k) std::swap(cache[k - 1], cache[random.below(k)]);
  }
  for (std::size_t k = 0; k < cache.size(); ++k) {
    const DiskOperation& operation = cache[k].operation;
    const bool last = k + 1 == cache.size();
    if (kind == 0 || (kind == 8 && cache[k].at > until) || (kind == 9 && !whole)) continue;
    if (kind >= 2 && kind <= 4 && random.below(2) == 0) continue;
    if (kind == 6 || kind == 7) {
      apply_torn(content, operation, sector, random);
    } else if (kind == 5 && last && operation.kind == Kind::write) {
      put(content, static_cast<std::size_t>(operation.offset),
          operation.bytes.substr(0, random.below(operation.bytes.size() + 1)));
    } else {
      apply_to(content, operation);
    }
  }
  return content;
}

std::map<std::string, std::string> CachedDisk::image(int kind, Random& random) const {
  std::uint64_t first = n_;
  for (const auto& [path, file] : files_) {
    if (!file.unsynced.empty()) first = std::min(first, file.unsynced.front().at);
  }
  const std::uint64_t until = first + random.below(n_ - first + 1);
  std::map<std::string, std::string> files;
  for (const auto& [path, file] : files_) {
    const bool luck = random.below(2) == 0;
    if (file.removed && (kind == 1 || luck)) continue;
    if (!file.there && (kind == 0 || (kind != 1 && luck))) continue;
    files[path] = survived(file, kind, until, random);
  }
  return files;
}

PowerLossCount lose_power(const std::filesystem::path& folder, const PowerLossOptions& options) {
  const std::vector<LogEntry> log = record_log(folder, options.record);
  PowerLossCount count;
  Random random(options.seed);
  CachedDisk disk(options.lie);
  int told = 0;
  for (const LogEntry& entry : log) {
    if (entry.told > 0) {
      told = entry.told;
    } else {
      disk.apply(entry.operation);
      const bool back = entry.operation.kind == Kind::write && told > 0;
      count.written_back += back && entry.operation.file.ends_with(".db") ? 1 : 0;
      if (count.operations++ % options.every != 0) continue;
    }
    if (told < options.from_told) continue;
    const int kinds = disk.has_unsynced() ? CachedDisk::kKinds : 1;
    for (int kind = 0; kind < kinds; ++kind) {
      const auto file = write_image(folder / "image", disk.image(kind, random));
      const Found found = look_at(file);
      const bool sound = found.opens && found.verifies;
      ++count.images;
      count.corrupt += sound ? 0 : 1;
      count.lost_images += found.n_points < told ? 1 : 0;
      count.lost_points = std::max(count.lost_points, told - found.n_points);
      if (count.first_problem.empty() && (found.n_points < told || !sound)) {
        count.first_problem = "operation " + std::to_string(count.operations) + ", kind " +
                              std::to_string(kind) + ": " + std::to_string(found.n_points) +
                              " of " + std::to_string(told) + " readings; " + found.problem;
      }
      using Until = PowerLossOptions::Until;
      if (options.until == Until::loss && count.lost_images > 0) return count;
      if (options.until == Until::corruption && count.corrupt > 0) return count;
      if (options.resume_every == 0 || count.images % options.resume_every != 0) continue;
      ++count.resumed;
      const Recording rest = record(file, options.record.n_points);
      const Found whole = look_at(file);
      const bool right = rest.state == session::State::done && whole.verifies &&
                         whole.n_points == options.record.n_points;
      count.wrong_resumes += right ? 0 : 1;
      if (!right && count.first_problem.empty()) count.first_problem = rest.error + whole.problem;
    }
  }
  return count;
}

}  // namespace trammel::test
