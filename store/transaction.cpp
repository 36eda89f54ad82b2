#include "store/transaction.hpp"

#include <sqlite3.h>

#include "store/statement.hpp"

namespace trammel::store {

Transaction::Transaction(Connection& connection)
    : connection_(connection), outermost_(sqlite3_get_autocommit(connection.handle()) != 0) {
  Statement(connection_, outermost_ ? "BEGIN IMMEDIATE" : "SAVEPOINT part").run();
}

Transaction::~Transaction() {
  if (done_) return;
  // Some errors (disk full, I/O) have rolled back already: then there is nothing to undo.
  if (sqlite3_get_autocommit(connection_.handle()) != 0) return;
  const char* undo = outermost_ ? "ROLLBACK" : "ROLLBACK TO part; RELEASE part";
  sqlite3_exec(connection_.handle(), undo, nullptr, nullptr, nullptr);
}

void Transaction::commit() {
  Statement(connection_, outermost_ ? "COMMIT" : "RELEASE part").run();
  done_ = true;
}

Snapshot::Snapshot(Connection& connection)
    : connection_(connection), outermost_(sqlite3_get_autocommit(connection.handle()) != 0) {
  if (outermost_) Statement(connection_, "BEGIN").run();
}

Snapshot::~Snapshot() {
  if (!outermost_ || sqlite3_get_autocommit(connection_.handle()) != 0) return;
  try {
    Statement(connection_, "COMMIT").run();
  } catch (const StoreError&) {  // nothing was written
  }
}

std::int64_t data_version(Connection& connection) {
  Statement version(connection, "PRAGMA data_version");
  return version.step() ? version.integer(0) : 0;
}

}  // namespace trammel::store
