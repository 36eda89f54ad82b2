#pragma once

#include <cstdint>

#include "store/connection.hpp"

namespace trammel::store {

/// All or nothing: takes the write lock at once (BEGIN IMMEDIATE), rolls back unless committed.
/// Inside another transaction it is a part of that one and commits with it.
class Transaction {
 public:
  explicit Transaction(Connection& connection);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  /// "Stored" may be reported when this has returned.
  void commit();

 private:
  Connection& connection_;
  bool outermost_ = false;
  bool done_ = false;
};

/// What is read while it lasts is one state of the database, whatever others write, and takes one
/// lock. Inside a transaction it is a part of that one.
class Snapshot {
 public:
  explicit Snapshot(Connection& connection);
  ~Snapshot();
  Snapshot(const Snapshot&) = delete;
  Snapshot& operator=(const Snapshot&) = delete;

 private:
  Connection& connection_;
  bool outermost_ = false;
};

/// Another number than before when any other connection has committed a change since.
std::int64_t data_version(Connection& connection);

}  // namespace trammel::store
