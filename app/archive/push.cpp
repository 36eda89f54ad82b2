#include "app/archive/push.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "store/reading.hpp"
#include "store/transaction.hpp"

namespace trammel::archive {

namespace {

using store::Bytes;
using store::Connection;
using store::Sha256;
using store::Statement;

struct LocalRow {
  std::string table;
  store::Id id = 0;
  std::string sha256;  // raw
};

std::string raw(Bytes bytes) { return {bytes.begin(), bytes.end()}; }
std::string hex_of(std::string_view bytes) {
  return store::hex(Bytes(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

std::vector<LocalRow> local_rows(Connection& db, store::Id campaign) {
  std::vector<LocalRow> all;
  Statement rows(db, store::kSealedRowsOfCampaign);
  rows << campaign;
  while (rows.step()) all.push_back({rows.text(0), rows.integer(1), raw(rows.blob(2))});
  return all;
}

std::string digest_of(const std::vector<LocalRow>& rows) {
  std::vector<std::string_view> seals;
  for (const LocalRow& row : rows) seals.push_back(row.sha256);
  std::ranges::sort(seals);
  std::string all;
  for (const std::string_view seal : seals) all += seal;
  return store::hex(store::sha256_of(all));
}

Head head_with(Connection& db, const CampaignName& campaign, const std::vector<LocalRow>& rows) {
  Head head{.head = store::hex(store::chain_head(db, campaign.id)),
            .rows_sha256 = digest_of(rows),
            .n_rows = static_cast<std::int64_t>(rows.size())};
  Statement count(db, "SELECT coalesce(max(seq), 0), count(*) FROM reading WHERE campaign_id = ?");
  count << campaign.id;
  if (count.step()) {
    head.last_seq = count.integer(0);
    head.n_readings = count.integer(1);
  }
  return head;
}

constexpr const char* kHeadColumns =
    "SELECT encode(head, 'hex'), last_seq, n_readings, encode(rows_sha256, 'hex'), n_rows, "
    "campaign, station FROM ";

Head head_of(const Link::Row& row) {
  return {.head = text_of(row, 0),
          .last_seq = number_of(row, 1),
          .n_readings = number_of(row, 2),
          .rows_sha256 = text_of(row, 3),
          .n_rows = number_of(row, 4)};
}

std::string said(std::string_view of, const Head& head) {
  return std::string(of) + ": " + std::to_string(head.n_readings) + " readings ending in " +
         head.head + ", " + std::to_string(head.n_rows) + " other rows";
}

InputError parted(const CampaignName& campaign, const Head& local, const Head& archived,
                  const std::string& where) {
  return InputError(
      {.what = "the archive has another '" + campaign.name + "' under the same uuid",
       .where = {.field = campaign.uuid, .point = where},
       .got = said("this file", local),
       .expected = said("the archive", archived),
       .hint = "nothing was sent: is this database a copy that went its own way, was it edited, or "
               "is it an older backup? `trammel archive pull` gives what the archive has"});
}

/// The file's readings up to the archive's last one are those that the archive has.
void require_same_chain(Connection& db, const CampaignName& campaign, const Head& local,
                        const Head& archived) {
  Statement upto(
      db,
      "SELECT count(*), (SELECT sha256 FROM reading WHERE campaign_id = ?1 AND seq = ?2) "
      "FROM reading WHERE campaign_id = ?1 AND seq <= ?2");
  upto << campaign.id << archived.last_seq;
  const bool none = archived.last_seq == 0;
  const bool same = upto.step() && upto.integer(0) == archived.n_readings &&
                    (none ? archived.head == store::hex(store::Sha256{})
                          : !upto.is_null(1) && store::hex(upto.blob(1)) == archived.head);
  if (!same) throw parted(campaign, local, archived, "seq " + std::to_string(archived.last_seq));
}

/// The file's rows that the archive has not; it has none that the file has not.
std::vector<LocalRow> new_rows(Link& link, const CampaignName& campaign,
                               const std::vector<LocalRow>& rows, const Head& local,
                               const Head& archived) {
  if (archived.n_rows == 0) return rows;
  std::set<std::string> there;
  for (const Link::Row& row :
       link.ask("SELECT encode(sha256, 'hex') FROM trammel.archive_row WHERE campaign = $1",
                {campaign.uuid})) {
    there.insert(text_of(row, 0));
  }
  std::vector<LocalRow> fresh;
  std::size_t n_known = 0;
  for (const LocalRow& row : rows) {
    if (there.contains(hex_of(row.sha256))) {
      ++n_known;
    } else {
      fresh.push_back(row);
    }
  }
  if (n_known != there.size())
    throw parted(campaign, local, archived, "rows that this file does not have");
  return fresh;
}

/// In the order in which they may name each other.
void send_rows(Link& link, Connection& db, const CampaignName& campaign,
               const std::vector<LocalRow>& rows) {
  auto next = rows.begin();
  link.copy_in(
      "COPY trammel.archive_row (campaign, table_name, row_key, row_ids, n_rows, bytes, sha256) "
      "FROM STDIN (FORMAT binary)",
      [&](std::string& bytes) {
        if (next == rows.end()) return false;
        const auto& tables = store::sealed_tables();
        const auto sealed = std::ranges::find(tables, next->table, &store::Sealed::table);
        TRAMMEL_ASSERT(sealed != tables.end());
        const store::CanonicalRow row = store::canonical_row(db, *sealed, next->id);
        if (raw(store::sha256_of(row.bytes)) != next->sha256) {
          throw StoreError({.what = "a row is not what was stored, and is not sent",
                            .where = {.file = db.file().string(),
                                      .point = row.table + " " + std::to_string(next->id)},
                            .hint = "see `trammel db verify`"});
        }
        add_count(bytes, 7);
        add_field(bytes, campaign.uuid);
        add_field(bytes, row.table);
        add_field(bytes, row.key);
        add_array(bytes, row.ids);
        add_array(bytes, row.n_rows);
        add_field(bytes, row.bytes);
        add_field(bytes, next->sha256);
        ++next;
        return true;
      });
}

/// A field of binary COPY is a value's canonical bytes without what says its kind.
void add_value(std::string& bytes, const std::string& canonical) {
  const char kind = canonical.front();
  if (kind == 'n') {
    add_null(bytes);
  } else {
    add_field(bytes, std::string_view(canonical).substr(kind == 't' || kind == 'b' ? 9 : 1));
  }
}

/// The answer to `then`, asked behind them.
Link::Row send_readings(Link& link, Connection& db, const CampaignName& campaign,
                        std::int64_t beyond, const std::string& then, std::int64_t& n_sent) {
  constexpr int kFields = 2 + store::kEndChained - store::kFirstChained + 1;
  Sha256 head = {};
  if (beyond > 0) {
    Statement last(db, "SELECT sha256 FROM reading WHERE campaign_id = ? AND seq = ?");
    last << campaign.id << beyond;
    if (last.step()) std::ranges::copy(last.blob(0).first(head.size()), head.begin());
  }
  Statement rows(db, store::chained_readings_beyond());
  rows << campaign.id << beyond;
  const auto answer = link.copy_in(
      "COPY trammel.reading (campaign, row_id, seq, session, epoch, point, attempt, reading_set, "
      "target_x_mm, target_y_mm, target_phi_rad, cmd_l1_mm, cmd_l2_mm, cmd_l3_mm, from_l1_mm, "
      "from_l2_mm, from_l3_mm, x_mm, y_mm, phi_rad, encoder_l1_mm, encoder_l2_mm, encoder_l3_mm, "
      "time_s, temp_degc, raw_reply, extra_json, sha256) FROM STDIN (FORMAT binary); " +
          then,
      [&](std::string& bytes) {
        if (!rows.step()) return false;
        store::Digest digest;
        digest << Bytes(head);
        head = digest.row(rows, store::kFirstChained, store::kEndChained).finish();
        if (!std::ranges::equal(rows.blob(store::kEndChained), head)) {
          throw StoreError({.what = "a reading is not what was stored, and is not sent",
                            .where = {.file = db.file().string(), .point = "seq " + rows.text(2)},
                            .hint = "see `trammel db verify`"});
        }
        add_count(bytes, kFields);
        add_field(bytes, campaign.uuid);
        add_integer(bytes, rows.integer(0));
        for (int column = store::kFirstChained; column < store::kEndChained; ++column) {
          add_value(bytes, store::canonical_bytes(rows, column, column + 1));
        }
        add_field(bytes, raw(head));
        ++n_sent;
        return true;
      });
  return answer.at(0);
}

Pushed push_one(Link& link, Connection& db, const std::string& station,
                const CampaignName& campaign, const std::optional<Head>& known) {
  const store::Snapshot snapshot(db);
  const std::vector<LocalRow> rows = local_rows(db, campaign.id);
  const Head local = head_with(db, campaign, rows);
  Pushed pushed{.campaign = campaign.name, .uuid = campaign.uuid, .head = local};
  if (known == local) return pushed;
  std::vector<Link::Row> rows_begun;
  Link::Transaction transaction(link,
                                std::string(kHeadColumns) + "trammel.begin_push(" +
                                    link.quoted(campaign.uuid) + ", " + link.quoted(station) + ")",
                                rows_begun);
  const Link::Row& begun = rows_begun.at(0);
  const Head archived = head_of(begun);
  if (text_of(begun, 6) != station) {
    throw InputError({.what = "'" + campaign.name + "' is in the archive from another station",
                      .where = {.field = campaign.uuid},
                      .got = said("this file, station " + station, local),
                      .expected = said("the archive, station " + text_of(begun, 6), archived),
                      .hint = "nothing was sent: is this database a copy? one file alone is a "
                              "campaign's writer"});
  }
  require_same_chain(db, campaign, local, archived);
  const std::vector<LocalRow> fresh = new_rows(link, campaign, rows, local, archived);
  if (!fresh.empty()) send_rows(link, db, campaign, fresh);
  pushed.n_rows = static_cast<std::int64_t>(fresh.size());
  const std::string now = std::string(kHeadColumns) +
                          "trammel.campaign_head WHERE campaign = " + link.quoted(campaign.uuid);
  const Head reached =
      head_of(local.n_readings > archived.n_readings
                  ? send_readings(link, db, campaign, archived.last_seq, now, pushed.n_readings)
                  : link.ask(now).at(0));
  if (reached != local) throw parted(campaign, local, reached, "after all was sent");
  transaction.commit();
  return pushed;
}

}  // namespace

std::vector<CampaignName> campaigns_of(Connection& db) {
  std::vector<CampaignName> all;
  Statement rows(db, "SELECT campaign_id, uuid, name FROM campaign ORDER BY campaign_id");
  while (rows.step()) all.push_back({rows.integer(0), rows.text(1), rows.text(2)});
  return all;
}

Head local_head(Connection& db, const CampaignName& campaign) {
  return head_with(db, campaign, local_rows(db, campaign.id));
}

std::vector<Pushed> push(Link& link, Connection& db, const std::string& station,
                         const std::vector<CampaignName>& campaigns,
                         const std::function<void(int, const Pushed&)>& progress) {
  std::map<std::string, Head> known;
  for (const Link::Row& row : link.ask(
           std::string(kHeadColumns) + "trammel.campaign_head WHERE station = $1", {station})) {
    known.emplace(text_of(row, 5), head_of(row));
  }
  std::vector<Pushed> all;
  for (const CampaignName& campaign : campaigns) {
    const auto at = known.find(campaign.uuid);
    all.push_back(push_one(link, db, station, campaign,
                           at == known.end() ? std::nullopt : std::optional(at->second)));
    if (progress) progress(static_cast<int>(all.size()), all.back());
  }
  return all;
}

}  // namespace trammel::archive
