#include "app/archive/answer.hpp"

#include <poll.h>
#include <postgresql/libpq-fe.h>

namespace trammel::archive {

namespace {

using std::chrono::milliseconds, std::chrono::steady_clock;

StoreError too_long() {
  return StoreError({.what = "the archive's answer took too long",
                     .hint = "ask for less; `trammel query` has --timeout-s"});
}

}  // namespace

Link::Row row_of(const PGresult* result, int row) {
  Link::Row cells;
  for (int column = 0; column < PQnfields(result); ++column) {
    auto& cell = cells.emplace_back();
    if (PQgetisnull(result, row, column) != 0) continue;
    cell.emplace(PQgetvalue(result, row, column),
                 static_cast<std::size_t>(PQgetlength(result, row, column)));
  }
  return cells;
}

void Link::Answer::Clear::operator()(pg_result* result) const { PQclear(result); }

Link::Answer::Answer(Link& link, const std::string& sql, milliseconds limit,
                     const std::vector<std::string>& values)
    : link_(link), deadline_(steady_clock::now() + limit) {
  PGconn* connection = link_.connection_.get();
  std::vector<const char*> parameters;
  for (const std::string& value : values) parameters.push_back(value.c_str());
  if (PQsendQueryParams(connection, sql.c_str(), static_cast<int>(parameters.size()), nullptr,
                        parameters.data(), nullptr, nullptr, 0) == 0) {
    link_.fail("the question could not be sent", nullptr);
  }
  PQsetSingleRowMode(connection);
  fetch();
  const auto status = PQresultStatus(row_.get());
  const bool has_rows = status == PGRES_SINGLE_TUPLE || status == PGRES_TUPLES_OK;
  for (int column = 0; has_rows && column < PQnfields(row_.get()); ++column) {
    columns_.emplace_back(PQfname(row_.get(), column));
    types_.push_back(PQftype(row_.get(), column));
  }
  if (columns_.empty()) {
    throw InputError({.what = "this is not a question to the archive",
                      .where = {.field = "SQL"},
                      .expected = "one SELECT"});
  }
}

void Link::Answer::fetch() {
  PGconn* connection = link_.connection_.get();
  while (PQisBusy(connection) == 1) {
    const auto left = std::chrono::ceil<milliseconds>(deadline_ - steady_clock::now());
    pollfd waiting{PQsocket(connection), POLLIN, 0};
    if (left.count() <= 0 || ::poll(&waiting, 1, static_cast<int>(left.count())) == 0) {
      throw too_long();
    }
    if (PQconsumeInput(connection) == 0) link_.fail("the archive stopped", nullptr);
  }
  row_.reset(PQgetResult(connection));
  const auto status = PQresultStatus(row_.get());
  const bool copies = status == PGRES_COPY_OUT || status == PGRES_COPY_IN;
  if (status == PGRES_SINGLE_TUPLE || copies) return;
  // The last one: then the connection is ready for another question.
  while (const std::unique_ptr<pg_result, Clear> more{PQgetResult(connection)}) continue;
  if (status == PGRES_TUPLES_OK || status == PGRES_COMMAND_OK) return;
  const char* state = PQresultErrorField(row_.get(), PG_DIAG_SQLSTATE);
  constexpr std::string_view kCancelled = "57014";  // by statement_timeout
  if (state != nullptr && state == kCancelled) throw too_long();
  link_.fail("the archive refused", row_.get());
}

std::optional<Link::Row> Link::Answer::next() {
  if (PQntuples(row_.get()) == 0) return std::nullopt;
  const Row row = row_of(row_.get(), 0);
  fetch();
  return row;
}

}  // namespace trammel::archive
