#include "store/refill.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <map>

#include "store/open.hpp"
#include "store/reading.hpp"
#include "store/take_over.hpp"
#include "store/transaction.hpp"

namespace trammel::store {

const std::vector<RefillStep> kRefillOrder = {{"campaign"},
                                              {"job", Refill::Parts::first},
                                              {"session"},
                                              {"session_event"},
                                              {"epoch"},
                                              {"attempt"},
                                              {"reading"},
                                              {"exclusion"},
                                              {"job", Refill::Parts::others},
                                              {"model"},
                                              {"taken_over"}};

namespace {

/// For each part of a sealed table (seal.cpp) the INSERT of its rows: ?1 the row's number, ?2 and
/// on the part's columns; of a point, last, its own number.
const std::map<std::string, std::vector<std::string>, std::less<>>& inserts() {
  static const std::map<std::string, std::vector<std::string>, std::less<>> all = {
      {"campaign",
       {"INSERT INTO campaign VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
        "INSERT INTO machine VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
        "INSERT INTO machine_chain VALUES (?1, ?2, ?3, ?4)",
        "INSERT INTO drive VALUES (?1, ?2, ?3, ?4, ?5)",
        "INSERT INTO campaign_fact VALUES (?1, ?2, ?3)"}},
      // A compensation may be a job of another campaign: its own first.
      {"session",
       {"INSERT INTO session SELECT ?1, campaign_id, ?3, coalesce((SELECT job_id FROM job WHERE "
        "job.campaign_id = campaign.campaign_id AND key = ?4 AND run = ?5), (SELECT min(job_id) "
        "FROM job WHERE key = ?4 AND run = ?5)), ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15 FROM "
        "campaign WHERE uuid = ?2",
        "INSERT INTO point VALUES (?16, ?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, "
        "?14, ?15)"}},
      {"session_event",
       {"INSERT INTO session_event SELECT ?1, session_id, ?4, ?5, ?6, ?7 FROM session JOIN "
        "campaign USING (campaign_id) WHERE uuid = ?2 AND session.name = ?3"}},
      {"epoch",
       {"INSERT INTO epoch SELECT ?1, session_id, ?4, ?5, ?6 FROM session JOIN campaign USING "
        "(campaign_id) WHERE uuid = ?2 AND session.name = ?3"}},
      {"attempt",
       {"INSERT INTO attempt SELECT ?1, point_id, ?5, epoch_id, ?7, ?8, ?9, ?10, ?11 FROM session "
        "JOIN campaign USING (campaign_id) JOIN point ON point.session_id = session.session_id "
        "AND point.seq = ?4 JOIN epoch ON epoch.session_id = session.session_id AND epoch.number "
        "= ?6 WHERE uuid = ?2 AND session.name = ?3"}},
      {"exclusion",
       {"INSERT INTO exclusion SELECT ?1, campaign_id, ?3, ?4, ?5 FROM campaign WHERE uuid = ?2"}},
      {"job",
       {"INSERT INTO job SELECT ?1, campaign_id, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, "
        "?14, ?15, ?16, ?17, ?18 FROM campaign WHERE uuid = ?2",
        "INSERT INTO job_session SELECT ?1, session_id FROM session JOIN job USING (campaign_id) "
        "WHERE job_id = ?1 AND session.name = ?2",
        "INSERT INTO job_exclusion SELECT ?1, exclusion_id FROM exclusion JOIN job USING "
        "(campaign_id) WHERE job_id = ?1 AND seq = ?2",
        "INSERT INTO job_parent SELECT ?1, parent.job_id FROM job AS parent JOIN job ON job.job_id "
        "= ?1 WHERE parent.key = ?2 AND parent.run = ?3 AND parent.job_id <> ?1 ORDER BY "
        "parent.campaign_id = job.campaign_id DESC, parent.job_id LIMIT 1",
        "INSERT INTO job_key_part VALUES (?1, ?2, ?3)",
        "INSERT INTO job_statistic VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)",
        "INSERT INTO job_point VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)"}},
      {"model",
       {"INSERT INTO model SELECT ?1, campaign_id, ?3, (SELECT model_id FROM model AS parent WHERE "
        "parent.campaign_id = campaign.campaign_id AND version = ?4), coalesce((SELECT job_id FROM "
        "job WHERE job.campaign_id = campaign.campaign_id AND key = ?5 AND run = ?6), (SELECT "
        "min(job_id) FROM job WHERE key = ?5 AND run = ?6)), ?7, ?8, ?9, ?10, ?11, ?12 FROM "
        "campaign WHERE uuid = ?2"}},
      {"taken_over",
       {"INSERT INTO taken_over SELECT ?1, ?3, ?4, ?5 FROM campaign WHERE uuid = ?2"}},
  };
  return all;
}

// ?1 the number, ?2 the campaign's uuid, ?3 and on what is chained, last the digest.
constexpr const char* kReading =
    "INSERT INTO reading (reading_id, campaign_id, seq, session_id, epoch, attempt_id, "
    "reading_set, "
    "target_x_mm, target_y_mm, target_phi_rad, cmd_l1_mm, cmd_l2_mm, cmd_l3_mm, from_l1_mm, "
    "from_l2_mm, from_l3_mm, x_mm, y_mm, phi_rad, encoder_l1_mm, encoder_l2_mm, encoder_l3_mm, "
    "time_s, temp_degc, raw_reply, extra_json, sha256) SELECT ?1, campaign_id, ?3, "
    "session.session_id, ?5, (SELECT attempt_id FROM attempt JOIN point USING (point_id) WHERE "
    "point.session_id = session.session_id AND point.seq = ?6 AND number = ?7), ?8, ?9, ?10, ?11, "
    "?12, ?13, ?14, ?15, ?16, ?17, ?18, ?19, ?20, ?21, ?22, ?23, ?24, ?25, ?26, ?27, ?28 FROM "
    "session JOIN campaign USING (campaign_id) WHERE uuid = ?2 AND session.name = ?4";
constexpr int kReadingColumns = kEndChained - kFirstChained;

void bind_value(Statement& insert, const Value& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value)) {
    insert << *integer;
  } else if (const auto* real = std::get_if<double>(&value)) {
    insert << *real;
  } else if (const auto* text = std::get_if<std::string>(&value)) {
    insert << *text;
  } else if (const auto* blob = std::get_if<Blob>(&value)) {
    insert << Bytes(*blob);
  } else {
    insert << std::nullopt;
  }
}

InputError not_a_row(const std::string& table, Id id, std::string got) {
  return InputError({.what = "an archived row is not what a station stores",
                     .where = {.point = table + " " + std::to_string(id)},
                     .got = std::move(got)});
}

}  // namespace

struct Refill::Work {
  explicit Work(const std::filesystem::path& part)
      : to(part, Access::create), prepared(to), transaction(to), guards(take_guards_off(to)) {}
  struct Prepared {
    explicit Prepared(Connection& to) {
      to.execute("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF");  // it has no name yet
      create_schema(to, newest_version());
    }
  };
  void insert_one(const std::string& table, Id id, Statement& insert) {
    insert.run();
    // INSERT … SELECT finds nothing to insert where a row that is named is not there.
    if (sqlite3_changes(to.handle()) != 1) throw not_a_row(table, id, "it names a missing row");
  }
  Connection to;
  Prepared prepared;
  Transaction transaction;
  std::vector<std::string> guards;
};

Refill::Refill(std::filesystem::path file) : file_(std::move(file)) {
  if (std::filesystem::exists(file_)) {
    throw InputError({.what = "the file's name is taken",
                      .where = {.file = file_.string()},
                      .hint = "name a new file"});
  }
  partial_ = std::make_unique<Partial>(Partial{file_.string() + ".part"});
  { const Partial left_by_a_dead_one{partial_->path}; }
  work_ = std::make_unique<Work>(partial_->path);
}

Refill::~Refill() { work_.reset(); }  // closed before it is removed

void Refill::add(const CanonicalRow& row, const Blob& sha256, Parts parts) {
  const auto of_table = inserts().find(row.table);
  if (of_table == inserts().end() || row.ids.empty() ||
      row.n_rows.size() != of_table->second.size()) {
    throw not_a_row(row.table, row.ids.empty() ? 0 : row.ids.front(), "other parts");
  }
  const Id id = row.ids.front();
  CanonicalReader values(row.bytes);
  std::size_t next_id = 1;
  for (std::size_t part = 0; part < row.n_rows.size(); ++part) {
    if (values.next() != Value(static_cast<std::int64_t>(part))) {
      throw not_a_row(row.table, id, "another number of rows in a part");
    }
    const bool wanted = parts == Parts::all || (parts == Parts::first) == (part == 0);
    const bool numbered = row.table == "session" && part == 1;
    Statement insert(work_->to, of_table->second[part]);
    const int n_values = sqlite3_bind_parameter_count(insert.handle()) - 1 - (numbered ? 1 : 0);
    for (std::int32_t n = 0; n < row.n_rows[part]; ++n) {
      if (wanted) insert << id;
      for (int column = 0; column < n_values; ++column) {
        const Value value = values.next();
        if (wanted) bind_value(insert, value);
      }
      if (numbered) {
        if (next_id >= row.ids.size()) throw not_a_row(row.table, id, "a point without a number");
        insert << row.ids[next_id++];
      }
      if (wanted) work_->insert_one(row.table, id, insert);
      if (wanted) insert.reset();
    }
  }
  if (!values.at_end()) throw not_a_row(row.table, id, "values beyond its last part");
  if (parts == Parts::others) return;
  Statement seal(work_->to, "INSERT INTO seal (table_name, row_id, sha256) VALUES (?, ?, ?)");
  seal << row.table << id << Bytes(sha256);
  seal.run();
}

void Refill::add(const LeftReading& reading) {
  CanonicalReader values(reading.bytes);
  Statement insert(work_->to, kReading);
  insert << reading.id << reading.campaign;
  for (int column = 0; column < kReadingColumns; ++column) bind_value(insert, values.next());
  if (!values.at_end()) throw not_a_row("reading", reading.id, "more values than a reading has");
  insert << Bytes(reading.sha256);
  work_->insert_one("reading", reading.id, insert);
}

CheckReport Refill::finish() {
  for (const std::string& guard : work_->guards) work_->to.execute(guard);
  work_->transaction.commit();
  work_->to.execute("PRAGMA journal_mode = WAL");
  work_.reset();
  CheckReport report;
  {
    Connection made = open_as_it_is(partial_->path);
    report = whole(made, file_);
  }
  sync(partial_->path);
  std::filesystem::rename(partial_->path, file_);
  sync(std::filesystem::absolute(file_).parent_path());
  return report;
}

}  // namespace trammel::store
