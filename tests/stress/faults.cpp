#include "tests/stress/faults.hpp"

#include <sqlite3.h>

#include <limits>
#include <optional>

#include "tests/stress/disk.hpp"

namespace trammel::test {

namespace {

using Kind = DiskOperation::Kind;
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

/// SQLITE_FULL can only come of what takes room.
bool concerns(Fault fault, Kind kind) {
  return fault == Fault::io_error || kind == Kind::write || kind == Kind::truncate ||
         kind == Kind::map;
}

int code_of(Fault fault, Kind kind) {
  if (fault == Fault::disk_full) return SQLITE_FULL;
  switch (kind) {
    case Kind::open:
      return SQLITE_CANTOPEN;
    case Kind::read:
      return SQLITE_IOERR_READ;
    case Kind::write:
      return SQLITE_IOERR_WRITE;
    case Kind::truncate:
      return SQLITE_IOERR_TRUNCATE;
    case Kind::sync:
      return SQLITE_IOERR_FSYNC;
    case Kind::remove:
      return SQLITE_IOERR_DELETE;
    case Kind::map:
      return SQLITE_IOERR_SHMMAP;
    default:
      return SQLITE_IOERR_LOCK;
  }
}

struct Run {
  Recording recording;
  std::int64_t while_recording = 0;  // operations until the runner was done: later ones close
};

Run run_with_fault(const std::filesystem::path& file, const FaultOptions& options,
                   std::int64_t nth) {
  Run run;
  if (options.fault == Fault::out_of_memory) {
    const ScarceMemory memory(nth, options.for_good);
    run.recording = options.recorder.record(
        file, options.n_points, [&run](int) { run.while_recording = ScarceMemory::asked(); });
    return run;
  }
  std::int64_t n = 0;
  const WatchedDisk disk([&](const DiskOperation& operation) {
    if (!concerns(options.fault, operation.kind)) return SQLITE_OK;
    ++n;
    const bool fails = options.for_good ? n >= nth : n == nth;
    return fails ? code_of(options.fault, operation.kind) : SQLITE_OK;
  });
  run.recording =
      options.recorder.record(file, options.n_points, [&](int) { run.while_recording = n; });
  return run;
}

void count_run(const std::filesystem::path& file, const FaultOptions& options, std::int64_t nth,
               const Run& run, FaultCount& count) {
  const std::string at = "n = " + std::to_string(nth) + ": ";
  const auto problem = [&](bool is, int& counter, const std::string& what) {
    if (!is) return;
    ++counter;
    if (count.first_problem.empty()) count.first_problem = at + what;
  };
  ++count.runs;
  count.reported += run.recording.reported ? 1 : 0;
  problem(options.for_good && nth <= run.while_recording && !run.recording.reported,
          count.unreported, "not reported");
  const Found found = options.recorder.look(file);
  problem(!found.opens || !found.verifies, count.corrupt, found.problem);
  problem(found.n_points < run.recording.acknowledged, count.lost,
          std::to_string(run.recording.acknowledged) + " acknowledged, " +
              std::to_string(found.n_points) + " there");
  const Recording rest = options.recorder.record(file, options.n_points, {});
  const Found whole = options.recorder.look(file);
  problem(
      rest.state != session::State::done || !whole.verifies || whole.n_points != options.n_points,
      count.unfinished, rest.error + whole.problem);
}

}  // namespace

FaultCount sweep_faults(const std::filesystem::path& folder, const FaultOptions& options) {
  FaultCount count;
  const auto fresh = [&] {
    std::filesystem::remove_all(folder / "fault");
    std::filesystem::create_directory(folder / "fault");
    return folder / "fault/lab.db";
  };
  count.operations = run_with_fault(fresh(), options, kNever).while_recording;
  for (std::int64_t nth = 1; nth <= count.operations; nth += options.every) {
    const auto file = fresh();
    count_run(file, options, nth, run_with_fault(file, options, nth), count);
  }
  return count;
}

}  // namespace trammel::test
