#pragma once
// A station's file made again from the rows that left it.

#include <memory>

#include "store/canonical.hpp"
#include "store/new_file.hpp"

namespace trammel::store {

/// A reading as it left: its number in the file, what its digest was taken over (kChainedReadings),
/// and the digest.
struct LeftReading {
  std::string campaign;  // uuid
  Id id = 0;
  std::string bytes;
  Blob sha256;
};

/// Puts rows into a new file, in which they get the numbers and the seals they had. Guards are off
/// while it is filled and on again at its end; then everything is verified, and the file gets its
/// name. Rows name each other by natural keys: those that are named come first (kRefillOrder).
/// Proof: push_pull_test.cpp.
class Refill {
 public:
  /// @throws InputError  the name is taken
  explicit Refill(std::filesystem::path file);
  ~Refill();
  Refill(const Refill&) = delete;
  Refill& operator=(const Refill&) = delete;

  /// The first part of the row, or the others. @throws InputError  its bytes are not those of a row
  /// of its table; a row that it names is not there; StoreError: the database refuses it
  enum class Parts { first, others, all };
  void add(const CanonicalRow& row, const Blob& sha256, Parts parts);
  void add(const LeftReading& reading);

  /// Verified and on the disk when this has returned.
  CheckReport finish();

 private:
  struct Work;
  std::filesystem::path file_;
  std::unique_ptr<Partial> partial_;
  std::unique_ptr<Work> work_;
};

/// In which order tables come. "reading" is that of readings. A job's sessions name jobs, and jobs
/// their sessions: its first part comes before, its others after.
struct RefillStep {
  const char* table;
  Refill::Parts parts = Refill::Parts::all;
};
extern const std::vector<RefillStep> kRefillOrder;

}  // namespace trammel::store
