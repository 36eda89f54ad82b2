#include "app/archive/pull.hpp"

#include <map>

#include "store/refill.hpp"

namespace trammel::archive {

namespace {

std::string_view required(const std::optional<std::string_view>& field) {
  if (!field)
    throw DeviceError({.what = "the archive sent a row without a value that it must have"});
  return *field;
}

store::Blob blob_of(std::string_view field) { return {field.begin(), field.end()}; }

/// The condition on rows with a column campaign.
std::string of_campaigns(Link& link, const Wanted& wanted) {
  if (wanted.campaign.empty()) {
    return " campaign IN (SELECT campaign FROM trammel.campaign_head WHERE station = " +
           link.quoted(wanted.station) + ") ";
  }
  std::string list;
  for (const Link::Row& row : link.ask("SELECT trammel.needed_by($1)", {wanted.campaign})) {
    list += (list.empty() ? "" : ", ") + link.quoted(text_of(row, 0));
  }
  return " campaign IN (" + list + ") ";
}

/// Workers' jobs that the station has not under their key and run: the first of each, numbered on.
std::string results(const std::string& campaigns) {
  return " UNION ALL SELECT ARRAY[row_number() OVER (ORDER BY id) + (SELECT "
         "coalesce(max(row_ids[1]), 0) FROM "
         "trammel.archive_row AS r WHERE r.table_name = 'job' AND" +
         campaigns +
         ")], n_rows, bytes, sha256 FROM (SELECT DISTINCT ON (row_key) * FROM trammel.result AS w "
         "WHERE" +
         campaigns +
         "AND NOT EXISTS (SELECT 1 FROM trammel.archive_row AS r WHERE r.campaign = w.campaign AND "
         "r.table_name = 'job' AND r.row_key = w.row_key) ORDER BY row_key, id) AS found";
}

/// One campaign's rows get the numbers from 1, in the order of those they had: a file begins there.
class Numbers {
 public:
  explicit Numbers(bool from_one) : from_one_(from_one) {}
  /// Before the rows of each table, which come in the order of their numbers.
  void begin() { row_ = point_ = 0; }
  store::Id row(store::Id id) { return from_one_ ? ++row_ : id; }
  void number(const std::string& table, std::vector<store::Id>& ids) {
    if (!from_one_) return;
    const store::Id before = ids.at(0);
    ids[0] = table == "taken_over" ? campaigns_.at(before) : ++row_;  // that has its campaign's
    if (table == "campaign") campaigns_[before] = ids[0];
    for (std::size_t k = 1; k < ids.size(); ++k) ids[k] = ++point_;
  }

 private:
  bool from_one_;
  store::Id row_ = 0, point_ = 0;
  std::map<store::Id, store::Id> campaigns_;
};

void pull_rows(Link& link, const std::string& campaigns, bool with_results,
               const store::RefillStep& step, Numbers& numbers, store::Refill& refill) {
  const bool more = with_results && std::string_view(step.table) == "job";
  link.copy_out("COPY (SELECT row_ids, n_rows, bytes, sha256 FROM trammel.archive_row WHERE" +
                    campaigns + "AND table_name = " + link.quoted(step.table) +
                    (more ? results(campaigns) : "") + " ORDER BY 1) TO STDOUT (FORMAT binary)",
                [&](const Link::Fields& fields) {
                  store::CanonicalRow row{.table = step.table,
                                          .key = {},
                                          .ids = array_of(required(fields.at(0))),
                                          .n_rows = {},
                                          .bytes = std::string(required(fields.at(2)))};
                  for (const std::int64_t n : array_of(required(fields.at(1)))) {
                    row.n_rows.push_back(static_cast<std::int32_t>(n));
                  }
                  numbers.number(row.table, row.ids);
                  refill.add(row, blob_of(required(fields.at(3))), step.parts);
                });
}

void pull_readings(Link& link, const std::string& campaigns, Numbers& numbers,
                   store::Refill& refill) {
  link.copy_out(
      "COPY (SELECT r.campaign, r.row_id, trammel.bytes_of(r), r.sha256 FROM "
      "trammel.reading AS r WHERE" +
          campaigns + "ORDER BY r.row_id) TO STDOUT (FORMAT binary)",
      [&](const Link::Fields& fields) {
        refill.add({.campaign = std::string(required(fields.at(0))),
                    .id = numbers.row(integer_of(required(fields.at(1)))),
                    .bytes = std::string(required(fields.at(2))),
                    .sha256 = blob_of(required(fields.at(3)))});
      });
}

}  // namespace

store::CheckReport pull(Link& link, const Wanted& wanted, const std::filesystem::path& to) {
  store::Refill refill(to);
  Link::Transaction transaction(link);
  link.run("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ READ ONLY");
  if (link.ask("SELECT 1 FROM trammel.campaign_head WHERE station = $1 LIMIT 1", {wanted.station})
          .empty()) {
    throw NotFoundError({.what = "the archive has nothing from this station",
                         .where = {.field = wanted.station},
                         .hint = "see `trammel archive status`"});
  }
  const std::string of = of_campaigns(link, wanted);
  Numbers numbers(!wanted.campaign.empty());
  for (const store::RefillStep& step : store::kRefillOrder) {
    numbers.begin();
    if (std::string_view(step.table) == "reading") {
      pull_readings(link, of, numbers, refill);
    } else {
      pull_rows(link, of, wanted.with_results, step, numbers, refill);
    }
  }
  return refill.finish();
}

}  // namespace trammel::archive
