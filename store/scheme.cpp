#include "store/scheme.hpp"

#include "store/reading.hpp"

namespace trammel::store {

namespace {

Scheme former() {
  return {
      .order = ByteOrder::little,
      .readings =
          "SELECT reading_id, campaign_id, seq, session_id, epoch, attempt_id, reading_set, "
          "target_x_mm, target_y_mm, target_phi_rad, cmd_l1_mm, cmd_l2_mm, cmd_l3_mm, from_l1_mm, "
          "from_l2_mm, from_l3_mm, x_mm, y_mm, phi_rad, encoder_l1_mm, encoder_l2_mm, "
          "encoder_l3_mm, time_s, temp_degc, raw_reply, extra_json, sha256 FROM reading "
          "NOT INDEXED ORDER BY reading_id",
      .first = 0,
      .end = 26,
      .sealed = {
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
            "SELECT * FROM job_statistic WHERE job_id = ?1 ORDER BY reading_set, metric, "
            "in_sample, phase",
            "SELECT * FROM job_point WHERE job_id = ?1 ORDER BY seq"}},
          {"model", "model_id", {"SELECT * FROM model WHERE model_id = ?1"}},
      }};
}

Scheme present() {
  return {.readings = kChainedReadings,
          .first = kFirstChained,
          .end = kEndChained,
          .sealed = sealed_tables()};
}

}  // namespace

const Scheme& scheme_of(int version) {
  static const Scheme before = former(), now = present();
  return version < kRedrawn ? before : now;
}

}  // namespace trammel::store
