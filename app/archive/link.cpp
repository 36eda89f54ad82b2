#include "app/archive/link.hpp"

#include <fmt/format.h>
#include <postgresql/libpq-fe.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <memory>

#include "app/archive/answer.hpp"

namespace trammel::archive {

namespace {

using Result = std::unique_ptr<PGresult, decltype(&PQclear)>;

// A cut network must not hold a station for hours: nothing heard for a minute ends the connection.
constexpr std::array<std::array<const char*, 2>, 7> kPatience = {{{"connect_timeout", "10"},
                                                                  {"keepalives", "1"},
                                                                  {"keepalives_idle", "30"},
                                                                  {"keepalives_interval", "10"},
                                                                  {"keepalives_count", "3"},
                                                                  {"tcp_user_timeout", "60000"},
                                                                  {"client_encoding", "UTF8"}}};
// And what we leave hanging must not hold the server: a statement ends after an hour (a campaign of
// 10^7 readings takes minutes), a transaction in which we are silent after two minutes. What is
// committed is on its disk, whatever its settings say.
constexpr const char* kServerPatience =
    "SET statement_timeout = '1h'; SET idle_in_transaction_session_timeout = '2min'; "
    "SET lock_timeout = '1min'; SET jit = off; SET search_path = pg_catalog, pg_temp; "
    "SELECT set_config('synchronous_commit', 'on', false) "
    "WHERE current_setting('synchronous_commit') = 'off'";

// As long as the server lets it, and a minute in which it should have said so.
constexpr std::chrono::minutes kLongestStatement{61};

constexpr std::string_view kMayNot = "42501";  // insufficient_privilege

constexpr std::size_t kCopyBytes = 256 * 1024;  // sent at once
constexpr std::string_view kCopyHeader{"PGCOPY\n\377\r\n\0\0\0\0\0\0\0\0\0", 19};

void append(std::string& bytes, std::uint64_t value, int size) {
  for (int shift = 8 * (size - 1); shift >= 0; shift -= 8) {
    bytes += static_cast<char>(value >> static_cast<unsigned>(shift));
  }
}

std::uint64_t number_at(std::string_view bytes, std::size_t at, std::size_t size) {
  if (at + size > bytes.size()) {
    throw DeviceError({.what = "the archive sent a row that is not whole"});
  }
  std::uint64_t value = 0;
  for (std::size_t k = 0; k < size; ++k)
    value = value << 8U | static_cast<unsigned char>(bytes[at + k]);
  return value;
}

std::int32_t int32_at(std::string_view bytes, std::size_t at) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(number_at(bytes, at, 4)));
}

constexpr int kOidInt8 = 20, kOidInt4 = 23;

template <class T>
void add_numbers(std::string& bytes, const std::vector<T>& values, int oid) {
  constexpr int kSize = sizeof(T);
  std::string field;
  append(field, values.empty() ? 0 : 1, 4);  // dimensions
  append(field, 0, 4);                       // no NULL in it
  append(field, static_cast<std::uint64_t>(oid), 4);
  if (!values.empty()) {
    append(field, values.size(), 4);
    append(field, 1, 4);  // the first one's index
  }
  for (const T value : values) {
    append(field, kSize, 4);
    append(field, static_cast<std::uint64_t>(value), kSize);
  }
  add_field(bytes, field);
}

std::vector<Link::Row> rows_of(const PGresult* result) {
  std::vector<Link::Row> rows;
  for (int row = 0; row < PQntuples(result); ++row) rows.push_back(row_of(result, row));
  return rows;
}

std::string one_line(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c == '\n' || c == '\t'; }, ' ');
  while (text.ends_with(' ')) text.pop_back();
  return text;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> connection_words(const LinkOptions& options) {
  char* fault = nullptr;
  const std::unique_ptr<PQconninfoOption, decltype(&PQconninfoFree)> parsed(
      PQconninfoParse(options.uri.c_str(), &fault), PQconninfoFree);
  if (!parsed) {
    InputError error({.what = "this does not name an archive",
                      .where = {.field = "URI"},
                      .got = fault != nullptr ? one_line(fault) : "no memory",
                      .expected = "postgresql://HOST/NAME, or what libpq takes"});
    PQfreemem(fault);
    throw error;
  }
  std::vector<std::pair<std::string, std::string>> words;
  std::string sslmode;
  for (const PQconninfoOption* option = parsed.get(); option->keyword != nullptr; ++option) {
    if (option->val == nullptr) continue;
    const std::string keyword = option->keyword;
    if (keyword == "password" || keyword == "sslpassword") {
      throw InputError({.what = "a password on the command line can be read by everyone here",
                        .where = {.field = "URI"},
                        .expected = "none",
                        .hint = "put it into ~/.pgpass, a service file or PGPASSWORD"});
    }
    if (keyword == "sslmode") {
      sslmode = option->val;
    } else if (keyword != "application_name") {
      words.emplace_back(keyword, option->val);
    }
  }
  if (sslmode.empty() && std::getenv("PGSSLMODE") != nullptr) sslmode = std::getenv("PGSSLMODE");
  if (!options.insecure && !sslmode.empty() && sslmode != "verify-full") {
    throw InputError({.what = "this connection would not prove whose server it is",
                      .where = {.field = "sslmode"},
                      .got = sslmode,
                      .expected = "verify-full (local sockets need no TLS)",
                      .hint = "--insecure insists"});
  }
  words.emplace_back("sslmode", !options.insecure ? "verify-full"
                                : sslmode.empty() ? "prefer"
                                                  : sslmode);
  if (!options.insecure) words.emplace_back("gssencmode", "disable");  // instead of TLS
  words.emplace_back("application_name", options.who);
  for (const auto& [keyword, value] : kPatience) {
    const bool given = std::ranges::any_of(
        words, [name = std::string_view(keyword)](const auto& word) { return word.first == name; });
    if (!given) words.emplace_back(keyword, value);
  }
  return words;
}

Link::Link(const LinkOptions& options) {
  const auto words = connection_words(options);
  std::vector<const char*> keywords, values;
  for (const auto& [keyword, value] : words) {
    keywords.push_back(keyword.c_str());
    values.push_back(value.c_str());
    if (keyword == "host" || keyword == "service" || keyword == "dbname") name_ += " " + value;
  }
  keywords.push_back(nullptr);
  values.push_back(nullptr);
  name_ = name_.empty() ? "the archive" : name_.substr(1);
  connection_.reset(PQconnectdbParams(keywords.data(), values.data(), 0));
  if (PQstatus(connection_.get()) != CONNECTION_OK) {
    const std::string said = one_line(PQerrorMessage(connection_.get()));
    const bool tls =
        said.find("SSL") != std::string::npos || said.find("root certificate") != std::string::npos;
    throw DeviceError(
        {.what = "the archive cannot be reached",
         .where = {.file = name_},
         .got = said,
         .hint = tls ? "the server needs a certificate that is known here (sslrootcert); "
                       "--insecure goes without"
                     : "are host, database and role right? a password stands in ~/.pgpass, a "
                       "service file or PGPASSWORD"});
  }
  if (const int version = PQserverVersion(connection_.get()); version < kOldestServer) {
    throw StoreError({.what = "the archive's server is too old for it",
                      .where = {.file = name_},
                      .got = fmt::format("PostgreSQL {}", version / 10000),
                      .expected = fmt::format("PostgreSQL {} or later", kOldestServer / 10000),
                      .hint = "pg_upgrade, by who keeps the server"});
  }
  PQsetNoticeProcessor(
      connection_.get(), [](void*, const char*) {}, nullptr);
  run(kServerPatience);
}

void Link::Close::operator()(pg_conn* connection) const { PQfinish(connection); }

void Link::fail(const std::string& doing, const pg_result* result) const {
  const char* state = result == nullptr ? nullptr : PQresultErrorField(result, PG_DIAG_SQLSTATE);
  const char* primary =
      result == nullptr ? nullptr : PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY);
  ErrorText text{.what = doing,
                 .where = {.file = name_},
                 .got = one_line(primary != nullptr ? primary : PQerrorMessage(connection_.get()))};
  if (state != nullptr) text.got += std::string(" (") + state + ")";
  text.hint = state != nullptr && state == kMayNot
                  ? "its owner decides: GRANT trammel_station (trammel_worker, trammel_reader) TO "
                    "ROLE"
                  : "nothing of it is stored; the server's log may say more";
  if (PQstatus(connection_.get()) != CONNECTION_OK) {
    text.hint = "nothing that was not acknowledged counts; the same command goes on from there";
    throw DeviceError(std::move(text));
  }
  throw Refused(std::move(text), state == nullptr ? "" : state);
}

void Link::written_by_a_person(const std::string& field, const std::string& expected,
                               const std::function<void()>& ask) {
  try {
    ask();
  } catch (const Refused& refused) {
    // Not implemented; too many rows; values; writing; syntax, names and types.
    constexpr std::array<std::string_view, 5> kOfTheWords = {"0A", "21", "22", "25", "42"};
    const auto is_class = [&refused](std::string_view c) { return refused.state.starts_with(c); };
    if (refused.state == kMayNot || std::ranges::none_of(kOfTheWords, is_class)) throw;
    run("ROLLBACK");
    std::string names;
    for (const Row& row :
         this->ask("SELECT relname FROM pg_class WHERE relnamespace = "
                   "'trammel'::regnamespace AND relkind IN ('r', 'v') ORDER BY 1")) {
      names += (names.empty() ? "" : ", ") + text_of(row, 0);
    }
    throw InputError({.what = "the archive cannot run this",
                      .where = {.field = field},
                      .got = refused.text().got,
                      .expected = expected + names,
                      .hint = "their columns stand in store/README.md and app/archive/README.md"});
  }
}

std::vector<Link::Row> Link::ask(const std::string& sql, const std::vector<std::string>& values) {
  Answer answer(*this, sql, kLongestStatement, values);
  std::vector<Row> rows;
  std::size_t bytes = 0;
  while (auto row = answer.next()) {
    for (const auto& cell : *row) bytes += sizeof cell + (cell ? cell->size() : 0);
    rows.push_back(*std::move(row));
    if (bytes <= kMostAnsweredBytes) continue;
    connection_.reset();
    throw DeviceError({.what = "the archive sends more than this program takes",
                       .where = {.file = name_},
                       .expected = std::to_string(kMostAnsweredBytes) + " bytes at most"});
  }
  return rows;
}

void Link::run(const std::string& sql) {
  const Result result(PQexec(connection_.get(), sql.c_str()), PQclear);
  const auto status = PQresultStatus(result.get());
  if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK) {
    fail("the archive refused", result.get());
  }
}

void Link::commit() {
  const Result result(PQexec(connection_.get(), "COMMIT"), PQclear);
  if (PQresultStatus(result.get()) != PGRES_COMMAND_OK) {
    fail("the archive did not commit", result.get());
  }
  // A transaction in which something failed is rolled back by COMMIT, and that is no error.
  if (std::string_view(PQcmdStatus(result.get())) != "COMMIT") {
    throw StoreError({.what = "the archive rolled back",
                      .where = {.file = name_},
                      .hint = "nothing was stored; the same command goes on from there"});
  }
}

std::vector<Link::Row> Link::copy_in(const std::string& sql,
                                     const std::function<bool(std::string&)>& more) {
  const Result begun(PQexec(connection_.get(), sql.c_str()), PQclear);
  if (PQresultStatus(begun.get()) != PGRES_COPY_IN) fail("the archive refused", begun.get());
  const auto send = [this](const std::string& bytes) {
    if (PQputCopyData(connection_.get(), bytes.data(), static_cast<int>(bytes.size())) != 1) {
      fail("the archive takes no more", nullptr);
    }
  };
  std::string bytes(kCopyHeader);
  try {
    while (more(bytes)) {
      if (bytes.size() < kCopyBytes) continue;
      send(bytes);
      bytes.clear();
    }
  } catch (...) {
    PQputCopyEnd(connection_.get(), "the station stopped");
    while (const Result rest{PQgetResult(connection_.get()), PQclear}) continue;
    throw;
  }
  append(bytes, 0xffff, 2);  // the end
  send(bytes);
  if (PQputCopyEnd(connection_.get(), nullptr) != 1) fail("the archive takes no more", nullptr);
  const Result ended(PQgetResult(connection_.get()), PQclear);
  Result last(nullptr, PQclear);
  while (Result next{PQgetResult(connection_.get()), PQclear}) last = std::move(next);
  if (PQresultStatus(ended.get()) != PGRES_COMMAND_OK) {
    fail("the archive refused what was sent", ended.get());
  }
  if (!last) return {};
  if (PQresultStatus(last.get()) != PGRES_TUPLES_OK) fail("the archive refused", last.get());
  return rows_of(last.get());
}

void Link::copy_out(const std::string& sql, const std::function<void(const Fields&)>& take) {
  const Result begun(PQexec(connection_.get(), sql.c_str()), PQclear);
  if (PQresultStatus(begun.get()) != PGRES_COPY_OUT) fail("the archive refused", begun.get());
  const std::unique_ptr<Link, void (*)(Link*)> drained(this, [](Link* link) { link->drain(); });
  std::size_t skip = kCopyHeader.size();
  char* buffer = nullptr;
  int size = 0;
  Fields fields;
  while ((size = PQgetCopyData(connection_.get(), &buffer, 0)) > 0) {
    const std::unique_ptr<char, decltype(&PQfreemem)> owned(buffer, PQfreemem);
    std::string_view row(buffer, static_cast<std::size_t>(size));
    row.remove_prefix(std::min(skip, row.size()));  // the header comes with the first row
    skip = 0;
    if (row.empty()) continue;
    const auto n_fields = static_cast<std::int16_t>(number_at(row, 0, 2));
    if (n_fields < 0) continue;  // the end
    fields.assign(static_cast<std::size_t>(n_fields), std::nullopt);
    std::size_t at = 2;
    for (auto& field : fields) {
      const std::int32_t length = int32_at(row, at);
      at += 4;
      if (length < 0) continue;
      if (static_cast<std::size_t>(length) > row.size() - at) {
        throw DeviceError({.what = "the archive sent a row that is not whole"});
      }
      field = row.substr(at, static_cast<std::size_t>(length));
      at += static_cast<std::size_t>(length);
    }
    take(fields);
  }
  const Result ended(size == -1 ? PQgetResult(connection_.get()) : nullptr, PQclear);
  if (PQresultStatus(ended.get()) != PGRES_COMMAND_OK) fail("the archive stopped", ended.get());
}

/// What is left of a COPY that was not taken to its end: of an endless one the connection ends.
void Link::drain() {
  std::size_t bytes = 0;
  char* rest = nullptr;
  for (int size = 0; (size = PQgetCopyData(connection_.get(), &rest, 0)) > 0; PQfreemem(rest)) {
    if ((bytes += static_cast<std::size_t>(size)) > kMostAnsweredBytes) return connection_.reset();
  }
  while (const Result last{PQgetResult(connection_.get()), PQclear}) continue;
}

Link::Transaction::Transaction(Link& link, const std::string& sql, std::vector<Row>& rows)
    : link_(link) {
  const Result result(PQexec(link.connection_.get(), ("BEGIN; " + sql).c_str()), PQclear);
  if (PQresultStatus(result.get()) != PGRES_TUPLES_OK) {
    if (PQtransactionStatus(link.connection_.get()) == PQTRANS_INERROR) link.run("ROLLBACK");
    link.fail("the archive refused", result.get());
  }
  rows = rows_of(result.get());
}

Link::Transaction::~Transaction() {
  if (done_) return;
  try {
    link_.run("ROLLBACK");
  } catch (const Error&) {  // the connection is gone, and with it the transaction
  }
}

void Link::Transaction::commit() {
  link_.commit();
  done_ = true;
}

std::string Link::quoted(const std::string& text) const {
  const std::unique_ptr<char, decltype(&PQfreemem)> made(
      PQescapeLiteral(connection_.get(), text.data(), text.size()), PQfreemem);
  if (!made) throw InputError({.what = "text that is not UTF-8", .got = text});
  return made.get();
}

void add_count(std::string& bytes, std::int16_t n_fields) {
  append(bytes, static_cast<std::uint64_t>(n_fields), 2);
}
void add_null(std::string& bytes) { append(bytes, 0xffffffff, 4); }
void add_field(std::string& bytes, std::string_view field) {
  append(bytes, field.size(), 4);
  bytes += field;
}
void add_integer(std::string& bytes, std::int64_t value) {
  append(bytes, 8, 4);
  append(bytes, static_cast<std::uint64_t>(value), 8);
}
void add_array(std::string& bytes, const std::vector<std::int64_t>& values) {
  add_numbers(bytes, values, kOidInt8);
}
void add_array(std::string& bytes, const std::vector<std::int32_t>& values) {
  add_numbers(bytes, values, kOidInt4);
}

const std::string& text_of(const Link::Row& row, std::size_t column) {
  if (column >= row.size() || !row[column]) {
    throw DeviceError({.what = "the archive sent a row without a value that it must have"});
  }
  return *row[column];
}

std::int64_t number_of(const Link::Row& row, std::size_t column) {
  const std::string& text = text_of(row, column);
  std::int64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, value);
  if (read.ec == std::errc{} && read.ptr == end) return value;
  throw DeviceError({.what = "the archive sent no whole number", .got = text.substr(0, 100)});
}

std::int64_t integer_of(std::string_view field) {
  return static_cast<std::int64_t>(number_at(field, 0, 8));
}

std::vector<std::int64_t> array_of(std::string_view field) {
  std::vector<std::int64_t> values;
  if (int32_at(field, 0) == 0) return values;
  const std::int32_t n = int32_at(field, 12);
  for (std::size_t at = 20; n > 0 && values.size() < static_cast<std::size_t>(n);) {
    const std::int32_t size = int32_at(field, at);
    if (size != 4 && size != 8) throw DeviceError({.what = "the archive sent no array of numbers"});
    values.push_back(size == 4 ? int32_at(field, at + 4) : integer_of(field.substr(at + 4)));
    at += 4 + static_cast<std::size_t>(size);
  }
  return values;
}

}  // namespace trammel::archive
