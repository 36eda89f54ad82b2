#pragma once
// A connection to the archive: PostgreSQL by libpq, behind thin RAII.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"

struct pg_conn;
struct pg_result;

namespace trammel::archive {

struct LinkOptions {
  std::string uri = {};   // libpq's: postgresql://host/name, service=NAME, …
  bool insecure = false;  // take what the URI says of TLS
  std::string who = {};   // application_name: who works there sees it
};

/// What is needed of the connection before anything is sent.
///
/// TLS with the server's certificate checked (sslmode=verify-full), whatever the host: libpq leaves
/// it out on a local socket alone. A URI or an environment that asks for less is refused, unless
/// `insecure`. A password on the command line is refused: passfile, service file or PGPASSWORD.
/// @throws InputError  the URI is none, or asks for one of these. Proof: link_test.cpp
std::vector<std::pair<std::string, std::string>> connection_words(const LinkOptions& options);

/// As PQserverVersion: the oldest that the archive's schema was tried on.
inline constexpr int kOldestServer = 150000;

/// Of one answer that is held whole: the digests of 10^7 rows.
inline constexpr std::size_t kMostAnsweredBytes = std::size_t{1} << 30;

/// The server took no statement, and the connection goes on.
struct Refused : StoreError {
  Refused(ErrorText text, std::string sqlstate)
      : StoreError(std::move(text)), state(std::move(sqlstate)) {}
  std::string state;  // five letters and digits of PostgreSQL's; none where it was not the server
};

/// Owns the connection. One thread at a time.
class Link {
 public:
  /// @throws DeviceError  naming the server and what it answered; StoreError: it is older than
  /// kOldestServer
  explicit Link(const LinkOptions& options);

  /// Rows of a query as texts; what is NULL is nothing. An answer of more than kMostAnsweredBytes,
  /// or of more than an hour, ends the connection.
  using Row = std::vector<std::optional<std::string>>;
  std::vector<Row> ask(const std::string& sql, const std::vector<std::string>& values = {});
  class Answer;  // the rows one by one: answer.hpp
  /// Statements without values or rows.
  void run(const std::string& sql);
  /// Commits; throws where the server has rolled back instead.
  void commit();

  /// Binary COPY to the server: `more` appends the next row, and says whether there was one. The
  /// rows of the query behind it in `sql`, if there is one: a way there and back less.
  std::vector<Row> copy_in(const std::string& sql,
                           const std::function<bool(std::string& bytes)>& more);
  /// Binary COPY from the server: `take` gets the fields of each row as bytes.
  using Fields = std::vector<std::optional<std::string_view>>;
  void copy_out(const std::string& sql, const std::function<void(const Fields&)>& take);

  /// Rolls back unless committed.
  class Transaction {
   public:
    explicit Transaction(Link& link) : link_(link) { link_.run("BEGIN"); }
    /// With the answer to a first query, by one way there and back.
    Transaction(Link& link, const std::string& sql, std::vector<Row>& rows);
    ~Transaction();
    Transaction(const Transaction&) = delete;
    Transaction& operator=(const Transaction&) = delete;
    void commit();

   private:
    Link& link_;
    bool done_ = false;
  };

  /// `ask` runs SQL that a person wrote, and throws what the server says of it as InputError of
  /// that field, with the names of tables and views that there are. Any transaction ends with it.
  /// @throws Refused  what is not of the words: a role that may not, a full disk.
  /// Proof: query_archive_test.cpp
  void written_by_a_person(const std::string& field, const std::string& expected,
                           const std::function<void()>& ask);

  /// Quotes a text for SQL where no value can stand (COPY's query).
  [[nodiscard]] std::string quoted(const std::string& text) const;

 private:
  void drain();
  [[noreturn]] void fail(const std::string& doing, const pg_result* result) const;
  struct Close {
    void operator()(pg_conn* connection) const;
  };
  std::unique_ptr<pg_conn, Close> connection_;
  std::string name_;  // of the server, without a password
};

/// Of a row's cell that must be there, as it is or as a whole number.
/// @throws DeviceError  it is not. Proof: hostile_archive_test.cpp
const std::string& text_of(const Link::Row& row, std::size_t column);
std::int64_t number_of(const Link::Row& row, std::size_t column);

/// Fields of binary COPY, appended.
void add_count(std::string& bytes, std::int16_t n_fields);
void add_null(std::string& bytes);
void add_field(std::string& bytes, std::string_view field);
void add_integer(std::string& bytes, std::int64_t value);
void add_array(std::string& bytes, const std::vector<std::int64_t>& values);
void add_array(std::string& bytes, const std::vector<std::int32_t>& values);

/// Of a field: an int8, or an array of int8 or int4. @throws DeviceError  it is none
std::int64_t integer_of(std::string_view field);
std::vector<std::int64_t> array_of(std::string_view field);

}  // namespace trammel::archive
