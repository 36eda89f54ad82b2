#pragma once
// Power lost at every operation of a recorded session: what is on the disk then, and is it enough?

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/statistics/random.hpp"
#include "tests/stress/disk.hpp"

namespace trammel::test {

/// One thing a recorder did: a disk operation, or (told > 0) "so many readings are safe".
struct LogEntry {
  DiskOperation operation;
  int told = 0;
};

enum class Durability {
  full,    // as the program has it
  normal,  // synchronous=NORMAL: the control that must lose readings
  off,     // synchronous=OFF: the control that must corrupt
};

struct RecordOptions {
  int n_points = 60;
  Durability durability = Durability::full;
  int checkpoint_pages = 0;  // wal_autocheckpoint; 0: as the program has it
  int full_after = 0;  // points: then the database's disk is full for good, and the reading in
                       // hand goes to the side file; 0: never
};

/// The operations of a real session on a new database in `folder`.
std::vector<LogEntry> record_log(const std::filesystem::path& folder, const RecordOptions& options);

/// What a disk does not do that it should.
enum class Lie {
  none,
  sync,   // a sync is answered and not done
  names,  // nor is that of a folder
};

/// A disk with a cache of its own: what was written since the last sync of a file may be there or
/// not, in any order and in pieces; what was made or removed since the last sync of its folder,
/// too.
class CachedDisk {
 public:
  explicit CachedDisk(Lie lie = Lie::none) : lie_(lie) {}
  void apply(const DiskOperation& operation);
  [[nodiscard]] bool has_unsynced() const;

  /// How the cache is lost; kinds 0 to 9: all of it; none; half, in order (2, 3); half, in any
  /// order; the last write torn at a byte; every write torn at the sectors of the device, of 512 or
  /// 4096 bytes; half torn, in any order; all files to one moment; all of some files and nothing of
  /// others.
  static constexpr int kKinds = 10;
  /// The files after the power went, by path.
  [[nodiscard]] std::map<std::string, std::string> image(int kind, Random& random) const;

 private:
  struct Pending {
    DiskOperation operation;
    std::uint64_t at = 0;  // of all operations
  };
  struct File {
    std::string durable;
    std::vector<Pending> unsynced;
    bool there = false;    // its name is on the disk
    bool removed = false;  // the name may be, or may not be there
  };
  static std::string survived(const File& file, int kind, std::uint64_t until, Random& random);
  std::map<std::string, File> files_;
  std::uint64_t n_ = 0;
  Lie lie_;
};

struct PowerLossCount {
  int operations = 0;    // of the recorder, each a place where power was lost
  int written_back = 0;  // of these, writes to the database itself under points that are told
  int images = 0;
  int lost_images = 0;  // images in which an acknowledged reading is missing
  int lost_points = 0;  // the most in one image
  int corrupt = 0;      // images that do not open or do not verify
  int resumed = 0;      // images from which the session was finished
  int wrong_resumes = 0;
  std::string first_problem = {};
};

struct PowerLossOptions {
  RecordOptions record = {};
  int every = 1;           // power is lost at every so many operations
  int from_told = 0;       // but not before so many readings are acknowledged
  int resume_every = 500;  // images; 0: none
  Lie lie = Lie::none;
  enum class Until { end, loss, corruption } until = Until::end;  // the first: for a control
  std::uint64_t seed = 20240501;
};

/// Records a session, loses power at each operation in all kinds (once where nothing is unsynced),
/// opens each image as the program would, and counts. Uses `folder` for files.
PowerLossCount lose_power(const std::filesystem::path& folder, const PowerLossOptions& options);

}  // namespace trammel::test
