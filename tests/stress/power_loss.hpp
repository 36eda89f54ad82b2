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

/// One thing a recorder did: a disk operation, or (told > 0) "so many points are stored".
struct LogEntry {
  DiskOperation operation;
  int told = 0;
};

enum class Durability {
  full,    // as the program has it
  normal,  // synchronous=NORMAL: the control that must lose readings
};

/// The operations of a real session of `n_points` on a new database in `folder`.
std::vector<LogEntry> record_log(const std::filesystem::path& folder, int n_points,
                                 Durability durability = Durability::full);

/// A disk with a cache of its own: what was written since the last sync of a file may be there or
/// not, in any order and in pieces.
class CachedDisk {
 public:
  /// `lies`: a sync is answered and not done (a control).
  explicit CachedDisk(bool lies = false) : lies_(lies) {}
  void apply(const DiskOperation& operation);
  [[nodiscard]] bool has_unsynced() const;

  /// How the cache is lost; kinds 0 to 7: all of it; none; half, in order (2, 3); half, in any
  /// order; the last write torn at a byte; every write torn at sectors; half torn, in any order.
  static constexpr int kKinds = 8;
  /// The files after the power went, by path.
  [[nodiscard]] std::map<std::string, std::string> image(int kind, Random& random) const;

 private:
  struct File {
    std::string durable;
    std::vector<DiskOperation> unsynced;
    bool there = false;    // its name is on the disk
    bool removed = false;  // the name may be, or may not be there
  };
  void forget_removed();
  std::map<std::string, File> files_;
  bool lies_;
};

struct PowerLossCount {
  int operations = 0;  // of the recorder, each a place where power was lost
  int images = 0;
  int lost_images = 0;  // images in which an acknowledged point is missing
  int lost_points = 0;  // the most in one image
  int corrupt = 0;      // images that do not open or do not verify
  int resumed = 0;      // images from which the session was finished
  int wrong_resumes = 0;
  std::string first_problem = {};
};

struct PowerLossOptions {
  int n_points = 60;
  int every = 1;           // power is lost at every so many operations
  int resume_every = 500;  // images; 0: none
  bool lies = false;
  bool first_loss = false;  // ends with the first lost image: for a control
  Durability durability = Durability::full;
  std::uint64_t seed = 20240501;
};

/// Records a session, loses power at each operation in all kinds (once where nothing is unsynced),
/// opens each image as the program would, and counts. Uses `folder` for files.
PowerLossCount lose_power(const std::filesystem::path& folder, const PowerLossOptions& options);

}  // namespace trammel::test
