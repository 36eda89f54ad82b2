#pragma once

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

  /// "Stored" may be said when this has returned.
  void commit();

 private:
  Connection& connection_;
  bool outermost_ = false;
  bool done_ = false;
};

}  // namespace trammel::store
