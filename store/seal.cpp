#include "store/seal.hpp"

#include <algorithm>

namespace trammel::store {

const std::vector<Sealed>& sealed_tables() {
  static const std::vector<Sealed> tables = {
      {"campaign",
       "campaign_id",
       {"SELECT * FROM campaign WHERE campaign_id = ?1",
        "SELECT * FROM campaign_chain WHERE campaign_id = ?1 ORDER BY chain",
        "SELECT * FROM campaign_fact WHERE campaign_id = ?1 ORDER BY key"}},
      {"session",
       "session_id",
       {"SELECT * FROM session WHERE session_id = ?1",
        "SELECT * FROM point WHERE session_id = ?1 ORDER BY seq"}},
      {"session_event", "event_id", {"SELECT * FROM session_event WHERE event_id = ?1"}},
      {"epoch", "epoch_id", {"SELECT * FROM epoch WHERE epoch_id = ?1"}},
      {"attempt", "attempt_id", {"SELECT * FROM attempt WHERE attempt_id = ?1"}},
      {"exclusion", "exclusion_id", {"SELECT * FROM exclusion WHERE exclusion_id = ?1"}},
      {"job",
       "job_id",
       {"SELECT * FROM job WHERE job_id = ?1",
        "SELECT * FROM job_session WHERE job_id = ?1 ORDER BY session_id",
        "SELECT * FROM job_exclusion WHERE job_id = ?1 ORDER BY exclusion_id",
        "SELECT * FROM job_parent WHERE job_id = ?1 ORDER BY parent_job_id",
        "SELECT * FROM job_key_part WHERE job_id = ?1 ORDER BY part",
        "SELECT * FROM job_statistic WHERE job_id = ?1 ORDER BY reading_set, metric, in_sample, "
        "phase",
        "SELECT * FROM job_point WHERE job_id = ?1 ORDER BY seq"}},
      {"model", "model_id", {"SELECT * FROM model WHERE model_id = ?1"}},
  };
  return tables;
}

Sha256 seal_of(Connection& connection, const Sealed& sealed, Id id) {
  Digest digest;
  for (std::size_t part = 0; part < sealed.rows.size(); ++part) {
    digest << static_cast<int>(part);
    Statement rows(connection, sealed.rows[part]);
    rows << id;
    while (rows.step()) digest.row(rows, rows.columns());
  }
  return digest.finish();
}

void seal(Connection& connection, std::string_view table, Id id) {
  const auto& all = sealed_tables();
  const auto sealed = std::ranges::find(all, table, &Sealed::table);
  TRAMMEL_ASSERT(sealed != all.end());
  const Sha256 sha256 = seal_of(connection, *sealed, id);
  Statement insert(connection, "INSERT INTO seal (table_name, row_id, sha256) VALUES (?, ?, ?)");
  insert << table << id << Bytes(sha256);
  insert.run();
}

}  // namespace trammel::store
