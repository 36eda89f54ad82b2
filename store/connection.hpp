#pragma once
// One open SQLite file.

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "core/error.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace trammel::store {

enum class Access {
  read_only,  // must exist
  write,      // must exist
  create,     // write, and made where it is not there
};

/// The name under which SQLite opens a file to read it, whatever its characters.
std::string read_only_uri(const std::filesystem::path& file);

/// Owns the handle. One thread at a time. Statements and transactions must not outlive it.
class Connection {
 public:
  /// Opens the file as SQLite, and sets what every connection of ours has: busy_timeout, foreign
  /// keys, recursive triggers, trusted_schema off, defensive. Reads nothing of it yet: use open()
  /// of store/open.hpp, which also checks whose file it is.
  /// @throws StoreError  no such file, no permission
  /// An empty name with `create`: a private database that is gone with the connection.
  Connection(const std::filesystem::path& file, Access access);
  ~Connection();
  Connection(Connection&& other) noexcept;
  Connection& operator=(Connection&&) = delete;

  /// Runs one or several statements that return nothing.
  void execute(std::string_view sql) const;

  [[nodiscard]] sqlite3* handle() const { return db_; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] Access access() const { return access_; }
  /// From here on this is what `file` holds, to be read alone.
  void stand_for(const std::filesystem::path& file);

  /// The error SQLite now holds, with its code, the file, and what to do about it.
  [[nodiscard]] StoreError error(int code, std::string_view doing) const;

 private:
  friend class Statement;
  sqlite3* db_ = nullptr;
  std::filesystem::path file_;
  Access access_;
  std::multimap<std::string, sqlite3_stmt*, std::less<>> idle_;  // prepared, waiting for use
};

}  // namespace trammel::store
