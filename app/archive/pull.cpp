#include "app/archive/pull.hpp"

#include "store/refill.hpp"

namespace trammel::archive {

namespace {

std::string_view required(const std::optional<std::string_view>& field) {
  if (!field)
    throw DeviceError({.what = "the archive sent a row without a value that it must have"});
  return *field;
}

store::Blob blob_of(std::string_view field) { return {field.begin(), field.end()}; }

void pull_rows(Link& link, const std::string& station, const store::RefillStep& step,
               store::Refill& refill) {
  link.copy_out(
      "COPY (SELECT r.row_ids, r.n_rows, r.bytes, r.sha256 FROM "
      "trammel.archive_row AS r JOIN trammel.campaign_head USING (campaign) WHERE station = " +
          link.quoted(station) + " AND table_name = " + link.quoted(step.table) +
          " ORDER BY r.row_ids) TO STDOUT (FORMAT binary)",
      [&](const Link::Fields& fields) {
        store::CanonicalRow row{.table = step.table,
                                .key = {},
                                .ids = array_of(required(fields.at(0))),
                                .n_rows = {},
                                .bytes = std::string(required(fields.at(2)))};
        for (const std::int64_t n : array_of(required(fields.at(1)))) {
          row.n_rows.push_back(static_cast<std::int32_t>(n));
        }
        refill.add(row, blob_of(required(fields.at(3))), step.parts);
      });
}

void pull_readings(Link& link, const std::string& station, store::Refill& refill) {
  link.copy_out(
      "COPY (SELECT r.campaign, r.row_id, trammel.bytes_of(r), r.sha256 FROM "
      "trammel.reading AS r JOIN trammel.campaign_head USING (campaign) "
      "WHERE station = " +
          link.quoted(station) + " ORDER BY r.row_id) TO STDOUT (FORMAT binary)",
      [&](const Link::Fields& fields) {
        refill.add({.campaign = std::string(required(fields.at(0))),
                    .id = integer_of(required(fields.at(1))),
                    .bytes = std::string(required(fields.at(2))),
                    .sha256 = blob_of(required(fields.at(3)))});
      });
}

}  // namespace

store::CheckReport pull(Link& link, const std::string& station, const std::filesystem::path& to) {
  store::Refill refill(to);
  Link::Transaction transaction(link);
  link.run("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ READ ONLY");
  if (link.ask("SELECT 1 FROM trammel.campaign_head WHERE station = $1 LIMIT 1", {station})
          .empty()) {
    throw NotFoundError({.what = "the archive has nothing of this station",
                         .where = {.field = station},
                         .hint = "see `trammel archive status`"});
  }
  for (const store::RefillStep& step : store::kRefillOrder) {
    if (std::string_view(step.table) == "reading") {
      pull_readings(link, station, refill);
    } else {
      pull_rows(link, station, step, refill);
    }
  }
  return refill.finish();
}

}  // namespace trammel::archive
